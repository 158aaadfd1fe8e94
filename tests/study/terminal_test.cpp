// What the commands print for people: it fits the terminal, the answer comes last and is short, a misspelt name is
// recognised.

#include "study/output/terminal.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "study/report/report.h"
#include "study/report/worst.h"
#include "study/output/text_table.h"
#include "tests/support/program_run.h"
#include "tests/support/synthetic_store.h"

namespace lcpbench::terminal_test {
namespace {

using Align = TextTable::Align;

/// The answer of a store.
std::string answer_of(SyntheticStore& made, int width, std::size_t lines = kAnswerLines) {
  const report::Report report = report::read_report(made.store());
  report::fill_tables(made.store(), report);
  return answer_text(made.store(), report, width, lines);
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

void expect_fits(const std::string& text, std::size_t width, const std::string& what) {
  for (const std::string& line : lines_of(text))
    EXPECT_LE(character_count(line), width) << what << ": " << line;
}

TEST(ShellWordTest, StandsInOneLineAndIsReadBackByTheShell) {
  const ScratchFolder folder;
  const std::string script = folder / "word.sh";
  const std::string out = folder / "word.out";
  for (const std::string word : {"plain-1.json", "a b", "it's", "$HOME`x`", "\x1b[2J", "two\nlines'\\", "\u009b2J",
                                 "\u00e9t\u00e9 \x01"}) {
    const std::string text = shell_word(word);
    EXPECT_EQ(printable(text), text);
    std::ofstream(script) << "printf %s " << text;
    EXPECT_EQ(std::system(("bash " + script + " > " + out).c_str()), 0);
    EXPECT_EQ(read_file(out), word);
  }
  EXPECT_EQ(file_argument("-o.json"), "./-o.json");
  EXPECT_EQ(file_argument("o.json"), "o.json");
}

TEST(CommandTextTest, TheShellReadsWhatIsContinuedAsOneCommand) {
  const ScratchFolder folder;
  const std::string script = folder / "command.sh";
  const std::string out = folder / "command.out";
  std::string command = "printf '[%s]'";
  std::string printed;
  for (const std::string word : {"two of my words", "it's a \\ in \"quotes\"", "c:\\", "two\nlines 'and' a \\", "plain",
                                 "external{command=python3 a solver of mine.py}", "--trials", "a b"}) {
    command += " " + shell_word(word);
    printed += "[" + word + "]";
  }
  for (int width = 40; width <= 200; width += 3) {
    std::ofstream(script) << report::command_text(command, "words", width);
    EXPECT_EQ(std::system(("bash " + script + " > " + out).c_str()), 0) << width;
    EXPECT_EQ(read_file(out), printed) << read_file(script);
  }
}

TEST(FoldedTest, BreaksAtBlanksElseBehindJointsElseAnywhere) {
  EXPECT_EQ(folded("one two three\n", 8, 2), "one two\n  three\n");
  EXPECT_EQ(folded("  abc{longer=1,other=2}", 16, 2), "  abc{longer=1,\n    other=2}");
  EXPECT_EQ(folded("abcdefghijklmnop", 10, 0), "abcdefghij\nklmnop");
  EXPECT_EQ(folded("ill-conditioned", 14, 0), "ill-\nconditioned");
  EXPECT_EQ(folded("precision=double", 15, 0), "precision=\ndouble");
  EXPECT_EQ(folded("diagonal=1e-12}", 13, 0), "diagonal=\n1e-12}") << "a sign is no hyphen";
  EXPECT_EQ(folded("µµµµ µµµµµ", 10, 0), "µµµµ µµµµµ") << "characters, not bytes";
  EXPECT_EQ(folded("as long as it comes out\n\n", kUnlimited), "as long as it comes out\n\n");
  EXPECT_EQ(folded("a\n\nb", 10), "a\n\nb");
}

TextTable sample() {
  TextTable table({{"name", Align::kLeft}, {"first"}, {"second", Align::kRight, 1}, {"third", Align::kRight, 2}});
  table.add_row({"contact_lemke{precision=polished,engine=kernel}", "1", "22", "333"});
  return table;
}

TEST(TextTableTest, IsAsWideAsItComesOutWithoutALimit) {
  EXPECT_EQ(sample().text(),
            "name                                             first  second  third\n"
            "-----------------------------------------------  -----  ------  -----\n"
            "contact_lemke{precision=polished,engine=kernel}      1      22    333\n");
}

TEST(TextTableTest, BreaksNamesBeforeItLeavesOutColumns) {
  EXPECT_EQ(sample().text(44),
            "name                    first  second  third\n"
            "----------------------  -----  ------  -----\n"
            "contact_lemke{              1      22    333\n"
            "precision=polished,\n"
            "engine=kernel}\n");
}

TEST(TextTableTest, BreaksNamesThatAreIndentedBehindTheIndent) {
  TextTable table({{"name", Align::kLeft}, {"first"}});
  table.add_row({"  contact_lemke{precision=polished}", "1"});
  EXPECT_EQ(table.text(28),
            "name                   first\n"
            "---------------------  -----\n"
            "  contact_lemke{           1\n"
            "precision=polished}\n");
}

TEST(TextTableTest, LeavesOutTheColumnsOfTheLargestRankAndSaysSo) {
  const std::string text = sample().text(26);
  EXPECT_EQ(text.substr(0, text.find('\n')), "name                 first");
  EXPECT_NE(text.find("2 columns left out: --wide shows them\n"), std::string::npos) << text;
  EXPECT_NE(sample().text(32).find("1 column left out: --wide shows it\n"), std::string::npos);
}

TEST(FittingTextTest, TakesTheMostRowsThatLeaveRoom) {
  const auto rows = [](std::size_t count) { return std::string(count, '\n') + "end\n"; };
  EXPECT_EQ(fitting_text(9, 4, rows), "\n\n\nend\n");
  EXPECT_EQ(fitting_text(2, 4, rows), "\n\nend\n");
  EXPECT_EQ(fitting_text(9, 0, rows), "end\n");
}

/// A solver for each part: reliable and fast, reliable and more accurate, two libraries that are often wrong.
class AnswerTest : public ::testing::Test {
 protected:
  AnswerTest() : made_(folder_ / "s.db") {
    const auto fast = made_.solver("active_set");
    const auto fine = made_.solver("contact_lemke", "precision=polished");
    const auto bullet = made_.solver("bullet_dantzig", "", "", "Bullet");
    const auto ode = made_.solver("ode_step", "", "", "ODE");
    for (std::int64_t trial = 0; trial < 60; ++trial) {
      const bool fails = trial % 3 == 0;
      made_.problem("paper/monotone/exp1", trial,
                    {{fast, {.error = 1e-9, .time_s = 1e-5}},
                     {fine, {.error = 1e-14, .time_s = 3e-5}},
                     {bullet, {.error = fails ? 1e-2 : 1e-9, .time_s = 4e-5}},
                     {ode, {.error = 1e-9, .time_s = 1e-4}}});
    }
  }
  ScratchFolder folder_;
  SyntheticStore made_;
};

TEST_F(AnswerTest, NamesTheSolverToUseTheFrontierAndTheFactorsOverTheLibraries) {
  const std::string text = answer_of(made_, 120);
  expect_fits(text, 120, "answer");
  EXPECT_LE(lines_of(text).size(), kAnswerLines);
  const auto line_with = [&text](const std::string& words) {
    for (const std::string& line : lines_of(text)) {
      if (line.find(words) != std::string::npos) return line;
    }
    return "no '" + words + "' in\n" + text;
  };
  const std::string use = line_with("use");
  EXPECT_NE(use.find("Frictionless"), std::string::npos) << use;
  EXPECT_NE(use.find("active_set"), std::string::npos) << use;
  EXPECT_NE(use.find("100 %"), std::string::npos) << use;
  EXPECT_NE(line_with("accurate").find("contact_lemke{"), std::string::npos) << text;
  EXPECT_NE(text.find("Bullet    bullet_dantzig"), std::string::npos) << text;
  EXPECT_NE(line_with("ODE  ").find("ode_step"), std::string::npos) << text;
  EXPECT_NE(line_with("Bullet  ").find("4.00x (4.00–4.00) n=40"), std::string::npos) << text;
  EXPECT_NE(line_with("ODE  ").find("10.0x (10.0–10.0) n=60"), std::string::npos) << text;
  EXPECT_NE(text.find("said solved, and was wrong: bullet_dantzig on 20 of 60\n"), std::string::npos) << text;
}

/// 35 problems are enough. Of 96 trials of which each fifth is solved, 20 count.
TEST(AnswerHintTest, AsksForTheTrialsThatGiveEnoughProblems) {
  for (const auto& [step, problems, hint] : {std::tuple(1, 12, "--trials 35;"), std::tuple(5, 20, "--trials 171;")}) {
    const ScratchFolder folder;
    SyntheticStore made(folder / "s.db");
    const auto solver = made.solver("lemke");
    for (int i = 0; i < problems; ++i) made.problem("paper/monotone/exp1", step * i, {{solver, {}}});
    EXPECT_NE(answer_of(made, 200).find(hint), std::string::npos) << answer_of(made, 200);
  }
}

TEST(AnswerOfSweepsTest, FalseClaimsOfParameterisationsAreTold) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "s.db");
  made.problem("paper/monotone/exp1", 0, {{made.solver("swept", "eps=1", "paper"), {.error = 0.5}}});
  EXPECT_NE(answer_of(made, 120)
                .find("said solved, and was wrong: no solver at single settings; 1 parameterisation of sweeps, counted on each "
                      "set\n"),
            std::string::npos);
}

/// A factor rests on problems that both solved: 34 carry none, 35 do.
TEST(AnswerFactorTest, FewerThan35CommonProblemsCarryNoFactor) {
  for (const int common : {34, 35}) {
    const ScratchFolder folder;
    SyntheticStore made(folder / "s.db");
    const auto fast = made.solver("active_set");
    const auto bullet = made.solver("bullet_dantzig", "", "", "Bullet");
    const auto reference = made.solver("lemke", "engine=dense");
    for (std::int64_t trial = 0; trial < 60; ++trial) {
      const MadeAnswer slow{.claim = trial < common ? Claim::kSolved : Claim::kIterationLimit,
                            .error = trial < common ? 1e-9 : 0.5,
                            .time_s = 4e-5};
      made.problem("paper/monotone/exp1", trial, {{fast, {.time_s = 1e-5}}, {bullet, slow}, {reference, slow}});
    }
    const std::string answer = answer_of(made, 120);
    const std::string results = results_text(made.store(), summarize(made.store()), 120);
    EXPECT_EQ(answer.find("- (n=34)") != std::string::npos, common == 34) << answer;
    EXPECT_EQ(results.find("- (34 of 60)") != std::string::npos, common == 34) << results;
    for (const std::string& text : {answer, results}) {
      EXPECT_EQ(text.find("n=35") != std::string::npos, common == 35) << text;
    }
  }
}

/// Where no problem has a solution and nobody claims one, there is no share and no error, but a time.
TEST(ResultsTest, ARowWithoutShareAndErrorKeepsItsOtherColumns) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "s.db");
  const auto solver = made.solver("lemke");
  const MadeAnswer denies{.claim = Claim::kUnsolvable,
                          .error = Errors::kNone,
                          .criterion = false,
                          .proves_unsolvable = true,
                          .time_s = 1e-5};
  made.problem("file:problems", 0, {{solver, denies}}, 0, "", "lcp");
  answer_of(made, 120);  // fills the tables
  const std::string text = results_text(made.store(), summarize(made.store()), 120);
  EXPECT_NE(text.find("10.0 µs"), std::string::npos) << text;
}

/// One problem solved and 59 refused is no share of 100 %.
TEST(AnswerRefusalTest, RefusedProblemsAreNotSolved) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "s.db");
  const auto fast = made.solver("active_set");
  const auto bullet = made.solver("bullet_dantzig", "", "", "Bullet");
  const auto other = made.solver("bullet_lemke", "", "", "Bullet");
  for (std::int64_t trial = 0; trial < 60; ++trial) {
    const MadeAnswer refuses{.claim = Claim::kUnsupported, .error = Errors::kNone, .criterion = false};
    const MadeAnswer fails{.claim = Claim::kIterationLimit, .error = 0.5};
    made.problem("paper/monotone/exp1", trial,
                 {{fast, {.time_s = 1e-5}}, {bullet, trial == 0 ? MadeAnswer{} : refuses},
                  {other, trial < 30 ? MadeAnswer{} : fails}});
  }
  const std::string text = answer_of(made, 120);
  EXPECT_NE(text.find("Bullet  bullet_lemke"), std::string::npos) << "half of 60 is surer than 1 of 1\n" << text;
}

TEST_F(AnswerTest, FitsNarrowTerminalsAndFewLines) {
  for (const int width : {80, 100}) expect_fits(answer_of(made_, width), static_cast<std::size_t>(width), "answer");
  EXPECT_LT(lines_of(answer_of(made_, 100, 8)).size(), lines_of(answer_of(made_, 100)).size());
  EXPECT_NE(answer_of(made_, 100, 8).find("active_set"), std::string::npos);
}

// ------------------------------------------------------------------------------------------------- the commands

class TerminalTest : public ::testing::Test {
 protected:
  ProgramRun run(const std::string& arguments) { return run_program(folder_ / "", arguments); }
  void TearDown() override { unsetenv("COLUMNS"); }
  ScratchFolder folder_;
};

/// So many sets and solvers that their table has more lines than the answer.
constexpr const char* kStudy =
    "run --set 'paper/monotone/exp?' --set 'rigid/exp?' --solver lemke --solver psor --solver contact_lemke "
    "--solver active_set --trials 2 --store a.db";
const std::string kLongStudy = std::string(kStudy) + " --long";

TEST_F(TerminalTest, WhatIsPrintedFitsTheTerminal) {
  ASSERT_EQ(run("generate paper/copositive/exp1 --seed 1 --count 2 --out p").exit_code, 0);
  for (const char* columns : {"80", ""}) {
    if (*columns == '\0') unsetenv("COLUMNS");
    if (*columns != '\0') setenv("COLUMNS", columns, 1);
    const std::size_t width = *columns == '\0' ? 100 : std::stoul(columns);
    for (const std::string& arguments :
         std::vector<std::string>{"--help",
                                  "run --help",
                                  "validate --help",
                                  "certify --help",
                                  "solvers",
                                  "solvers --long",
                                  "solvers lemke",
                                  "sets",
                                  "sets --long",
                                  "sets 'hard/*'",
                                  "solve p/000000.json p/000001.json --solver lemke --solver principal_pivoting",
                                  "inspect p/000000.json",
                                  "certify p/000000.json",
                                  "bench --set 'paper/monotone/exp2{redundancy=combination}' --problems 2",
                                  "stability --set 'hard/contact/*' --solver lemke --solver psor --trials 1",
                                  "stability --set 'hard/contact/*' --solver lemke --solver psor --trials 1 --long",
                                  "validate --solver lemke --set planted/definite --trials 2",
                                  kStudy,
                                  kLongStudy,
                                  "run --set 'hard/ray/*' --solver lemke --solver psor --store hard.db",
                                  "compare a.db a.db",
                                  "compare a.db a.db --long",
                                  "certify --store a.db"}) {
      const ProgramRun output = run(arguments);
      EXPECT_EQ(output.exit_code, 0) << arguments << ": " << output.err;
      EXPECT_NE(output.out, "") << arguments;
      expect_fits(output.out, width, arguments);
    }
  }
}

TEST_F(TerminalTest, WideShowsWhatDidNotFit) {
  ASSERT_EQ(run("generate paper/copositive/exp1 --seed 1 --count 1 --out p").exit_code, 0);
  setenv("COLUMNS", "80", 1);
  EXPECT_NE(run("solve p/000000.json --solver lemke").out.find("left out: --wide shows "), std::string::npos);
  const std::string wide = run("solve p/000000.json --solver lemke --wide").out;
  EXPECT_EQ(wide.find("left out"), std::string::npos);
  EXPECT_NE(wide.find("detail"), std::string::npos);
}

TEST_F(TerminalTest, TheAnswerIsShortAndComesLastAndOnce) {
  const ProgramRun study = run(kStudy);
  ASSERT_EQ(study.exit_code, 0) << study.err;
  EXPECT_LE(lines_of(study.out).size(), kAnswerLines) << study.out;
  EXPECT_EQ(study.out.find("so far"), std::string::npos);
  EXPECT_NE(lines_of(study.out).back().find("lcpbench report a.db"), std::string::npos) << study.out;
  const ProgramRun all = run(kLongStudy);
  EXPECT_GT(lines_of(all.out).size(), kAnswerLines);
  EXPECT_EQ(lines_of(all.out).back(), lines_of(study.out).back());
  for (const char* arguments : {"sets", "solvers", "compare a.db a.db"}) {
    EXPECT_LE(lines_of(run(arguments).out).size(), kAnswerLines) << arguments;
  }
  EXPECT_EQ(lines_of(run("compare a.db a.db").out).back(), "B is a tie with A: no difference beyond noise.");
}

TEST_F(TerminalTest, ASolveThatRanOutOfTimeIsRepeatedWithItsLimit) {
  setenv("COLUMNS", "1000", 1);
  std::ofstream(folder_ / "plan.json") << R"({"format": "lcpbench-plan", "version": 1, "name": "p", "trials": 3,
      "time_limit_s": 1e-6, "sets": ["rigid/frictional/exp1"], "solvers": ["psor"]})";
  const std::string out = run("run plan.json").out;
  EXPECT_NE(out.find(".json --solver psor --time-limit 1e-06"), std::string::npos) << out;
}

TEST_F(TerminalTest, MisspeltNamesAreRecognised) {
  std::ofstream(folder_ / "one.json")
      << R"({"format": "lcpbench-problem", "version": 1, "name": "one", "kind": "lcp", "M": [[1]], "q": [-1]})";
  for (const auto& [arguments, name] : std::vector<std::pair<std::string, std::string>>{
           {"slove one.json", "solve"},
           {"solve one.json --sovler lemke", "--solver"},
           {"solve one.json --solver lmke", "lemke"},
           {"solve one.json --solver 'lemke{engin=dense}'", "engine"},
           {"solvers contact_lemk", "contact_lemke"},
           {"run qick", "quick"},
           {"run --set paper/monotone/epx1", "paper/monotone/exp1"},
           {"generate paper/monoton/exp1 --seed 1 --count 1 --out d", "paper/monotone/exp1"},
           {"sets 'paper/monotone/exp2{redundncy=multiple}'", "redundancy"}}) {
    const ProgramRun output = run(arguments);
    EXPECT_EQ(output.exit_code, 2) << arguments;
    EXPECT_NE(output.err.find("(did you mean '" + name + "'?)"), std::string::npos) << arguments << ": " << output.err;
    EXPECT_EQ(lines_of(output.err).size(), 1U) << arguments << ": " << output.err;
  }
  EXPECT_EQ(run("solve one.json --xyzzy").err.find("did you mean"), std::string::npos);
}

}  // namespace
}  // namespace lcpbench::terminal_test
