// What the commands print for people: it fits the terminal, the answer comes last and is short, a misspelt name is
// recognised.

#include "study/output/terminal.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "study/output/text_table.h"
#include "study/report/report.h"
#include "study/report/worst.h"
#include "tests/support/program_test.h"
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

void expect_fits(const std::string& text, std::size_t width, const std::string& what) {
  for (const std::string& line : lines_of(text)) EXPECT_LE(character_count(line), width) << what << ": " << line;
}

/// What the shell prints of a script that calls printf on words.
std::string printed_by_shell(const std::string& script) {
  const ScratchFolder folder;
  std::ofstream(folder / "script.sh") << script;
  const std::string out = folder / "out";
  EXPECT_EQ(std::system(("bash '" + std::string(folder / "script.sh") + "' > '" + out + "'").c_str()), 0) << script;
  return read_file(out);
}

TEST(ShellWordTest, StandsInOneLineAndIsReadBackByTheShell) {
  for (const std::string word :
       {"plain-1.json", "a b", "it's", "$HOME`x`", "\x1b[2J", "two\nlines'\\", "\u009b2J", "\u00e9t\u00e9 \x01"}) {
    const std::string text = shell_word(word);
    EXPECT_EQ(printable(text), text);
    EXPECT_EQ(printed_by_shell("printf %s " + text), word);
  }
  EXPECT_EQ(file_argument("-o.json"), "./-o.json");
  EXPECT_EQ(file_argument("o.json"), "o.json");
}

TEST(CommandTextTest, TheShellReadsWhatIsContinuedAsOneCommand) {
  std::string command = "printf '[%s]'";
  std::string printed;
  for (const std::string word : {"two of my words", "it's a \\ in \"quotes\"", "c:\\", "two\nlines 'and' a \\", "plain",
                                 "external{command=python3 a solver of mine.py}", "--trials", "a b"}) {
    command += " " + shell_word(word);
    printed += "[" + word + "]";
  }
  for (int width = 40; width <= 200; width += 20) {
    EXPECT_EQ(printed_by_shell(report::command_text(command, "words", width)), printed) << width;
  }
}

TEST(FoldedTest, BreaksAtBlanksElseBehindJointsElseAnywhere) {
  EXPECT_EQ(folded("one two three\n", 8, 2), "one two\n  three\n");
  EXPECT_EQ(folded("  abc{longer=1,other=2}", 16, 2), "  abc{longer=1,\n    other=2}");
  EXPECT_EQ(folded("abcdefghijklmnop", 10, 0), "abcdefghij\nklmnop");
  EXPECT_EQ(folded("ill-conditioned", 14, 0), "ill-\nconditioned");
  EXPECT_EQ(folded("precision=double", 15, 0), "precision=\ndouble");
  EXPECT_EQ(folded("diagonal=1e-12}", 13, 0), "diagonal=\n1e-12}") << "a sign is no hyphen";
  EXPECT_EQ(folded("file:go1.scenes", 14, 0), "file:\ngo1.scenes");
  EXPECT_EQ(folded("my-robot.scenes 1.5", 12, 0), "my-robot.\nscenes 1.5");
  EXPECT_EQ(folded("time=12345.678901", 15, 0), "time=\n12345.678901") << "a number stays whole";
  EXPECT_EQ(folded("µµµµ µµµµµ", 10, 0), "µµµµ µµµµµ") << "characters, not bytes";
  EXPECT_EQ(folded("as long as it comes out\n\n", kUnlimited), "as long as it comes out\n\n");
  EXPECT_EQ(folded("a\n\nb", 10), "a\n\nb");
}

TextTable sample() {
  TextTable table({{"name", Align::kLeft}, {"first"}, {"second", Align::kRight, 1}, {"third", Align::kRight, 2}});
  table.add_row({"contact_lemke{precision=polished,engine=kernel}", "1", "22", "333"});
  return table;
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
  for (const auto& [words, others] : std::vector<std::pair<std::string, std::vector<std::string>>>{
           {"use", {"Frictionless", "active_set", "100 %"}},
           {"accurate", {"contact_lemke{"}},
           {"Bullet  ", {"bullet_dantzig", "4.00x (4.00–4.00) n=40"}},
           {"ODE  ", {"ode_step", "10.0x (10.0–10.0) n=60"}}}) {
    const std::vector<std::string> lines = lines_of(text);
    const auto line = std::find_if(lines.begin(), lines.end(), [&](const auto& each) { return contains(each, words); });
    ASSERT_NE(line, lines.end()) << words << " in\n" << text;
    for (const std::string& other : others) EXPECT_TRUE(contains(*line, other)) << other << " in\n" << text;
  }
  EXPECT_TRUE(contains(text, "said solved, and was wrong: bullet_dantzig on 20 of 60\n")) << text;
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
  EXPECT_NE(
      answer_of(made, 120).find(
          "said solved, and was wrong: no solver at single settings; 1 parameterisation of sweeps, counted on each "
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

TEST_F(AnswerTest, FitsNarrowTerminalsAndFewLines) {
  for (const int width : {80, 100}) expect_fits(answer_of(made_, width), static_cast<std::size_t>(width), "answer");
  EXPECT_LT(lines_of(answer_of(made_, 100, 8)).size(), lines_of(answer_of(made_, 100)).size());
  EXPECT_NE(answer_of(made_, 100, 8).find("active_set"), std::string::npos);
}

// ------------------------------------------------------------------------------------------------- the commands

class TerminalTest : public ProgramTest {
 protected:
  void SetUp() override {
    write_problem_of("ball.json", R"("kind": "scene", "bodies": [{"mass": 1, "position": [0, 0, 0.1],
        "inertia": [[0.004, 0, 0], [0, 0.004, 0], [0, 0, 0.004]], "linear_velocity": [0.3, 0, -1],
        "angular_velocity": [0, 0, 0]}], "contacts": [{"body_a": 0, "body_b": -1, "point": [0, 0, 0],
        "normal": [0, 0, 1], "tangent": [1, 0, 0], "mu": 0.5, "edges": 4}])");
    setenv("COLUMNS", "80", 1);
  }
  void TearDown() override { unsetenv("COLUMNS"); }

  /// A program for `external` that answers so many questions, says its last words, and ends.
  void write_program(const std::string& name, int answers, const std::string& last_words) {
    std::string text = "#!/bin/sh\n";
    for (int i = 1; i <= answers; ++i) text += "read line; echo '{\"sequence\": " + std::to_string(i) + "}'\n";
    write(name, text + "read line; echo '" + last_words + "' >&2; exit 3\n");
    std::filesystem::permissions(folder_ / name, std::filesystem::perms::owner_all);
  }
};

/// Whether the text has this part, wherever its lines were broken.
bool says(const std::string& text, const std::string& part) {
  std::istringstream words(text);
  std::string unfolded;
  for (std::string word; words >> word;) unfolded += (unfolded.empty() ? "" : " ") + word;
  return contains(unfolded, part);
}

/// So many sets and solvers that their table has more lines than the answer.
const std::string kStudy =
    "run --set 'paper/monotone/exp?' --set 'rigid/exp?' --solver lemke --solver psor --solver contact_lemke "
    "--solver active_set --trials 2 --store a.db";

TEST_F(TerminalTest, WhatIsPrintedFitsTheTerminal) {
  done("generate paper/copositive/exp1 --seed 1 --count 2 --out p");
  write("wide.sql", "SELECT 'some words that stand in one cell, so many of them' AS a, 'and some others that do' AS b");
  for (const char* arguments : {"--help",
                                "run --help",
                                "validate --help",
                                "certify --help",
                                "solvers",
                                "solvers --long",
                                "solvers lemke",
                                "sets",
                                "sets --long",
                                "sets 'hard/*'",
                                "inspect p/000000.json",
                                "certify p/000000.json",
                                "solve p/000000.json p/000001.json --solver lemke --solver principal_pivoting",
                                "solve ball.json",
                                "bench --set 'paper/monotone/exp2{redundancy=combination}' --problems 2",
                                "stability --set 'hard/contact/*' --solver lemke --solver psor --trials 1",
                                "stability --set 'hard/contact/*' --solver lemke --solver psor --trials 1 --long",
                                "validate --solver lemke --set planted/definite --trials 2",
                                kStudy.c_str(),
                                "run --set 'hard/ray/*' --solver lemke --solver psor --store hard.db",
                                "compare a.db a.db",
                                "compare a.db a.db --long",
                                "certify --store a.db",
                                "query a.db wide.sql"}) {
    expect_fits(done(arguments), 80, arguments);
  }
  EXPECT_TRUE(contains(done("solve p/000000.json --solver lemke"), "left out: --wide shows "));
  EXPECT_FALSE(contains(done("solve p/000000.json --solver lemke --wide"), "left out"));
}

TEST_F(TerminalTest, TheAnswerIsShortAndComesLastAndOnce) {
  const std::string study = done(kStudy);
  EXPECT_LE(lines_of(study).size(), kAnswerLines) << study;
  EXPECT_FALSE(contains(study, "so far"));
  EXPECT_TRUE(contains(lines_of(study).back(), "lcpbench report a.db")) << study;
  const std::string all = done(kStudy + " --long");
  EXPECT_GT(lines_of(all).size(), kAnswerLines);
  EXPECT_EQ(lines_of(all).back(), lines_of(study).back());
  EXPECT_EQ(lines_of(done("compare a.db a.db")).back(), "B is a tie with A: no difference beyond noise.");
}

// A step of an engine that told its name, version and time.
TEST_F(TerminalTest, TheEngineIsCalledByItsName) {
  std::ofstream(folder_ / "f.scenes")
      << R"({"format": "lcpbench-scenes", "version": 1, "scene": "s", "engine": "my engine", "engine_version": "0.1"})"
      << "\n"
      << R"({"step": 3, "problem": {"format": "lcpbench-problem", "version": 1, "name": "p", "kind": "contact", )"
      << R"("v": [-1], "N": [[1]], "G": [[2]]}, "engine": {"impulses": [2], "solve_s": 0.0625}})"
      << "\n";
  const std::string text = run("solve 'f.scenes#3' --solver engine --solver lemke").out;
  EXPECT_NE(text.find("\nmy engine 0.1 "), std::string::npos) << text;
  EXPECT_NE(text.find("62.5 ms"), std::string::npos) << text;
}

TEST_F(TerminalTest, ASolveThatRanOutOfTimeIsRepeatedWithItsLimit) {
  setenv("COLUMNS", "1000", 1);
  write("plan.json", R"({"format": "lcpbench-plan", "version": 1, "name": "p", "trials": 3,
      "time_limit_s": 1e-6, "sets": ["rigid/frictional/exp1"], "solvers": ["psor"]})");
  const std::string out = done("run plan.json");
  EXPECT_TRUE(contains(out, "' --solver psor --time-limit 1e-06")) << out;
}

TEST_F(TerminalTest, OfAFileAllProblemsAreTaken) {
  done("generate paper/monotone/exp1 --seed 1 --count 130 --out long");
  const ProgramRun part = run("run --set file:long --solver lemke --trials 20 --store long.db");
  EXPECT_TRUE(says(part.err, "file:long: the first 20 of its 130 problems are taken; --trials 130 takes all"))
      << part.err;
  const ProgramRun all = run("run --set file:long --set paper/monotone/exp1 --solver lemke --store long.db");
  EXPECT_FALSE(contains(all.err, "are taken")) << all.err;
  EXPECT_EQ(Store::open_for_reading(folder_ / "long.db").cell_count(), 130 + 100);
  for (const std::string command : {"stability", "validate"}) {
    const ProgramRun some = run(command + " --set file:long --solver lemke --trials 2");
    EXPECT_TRUE(says(some.err, "the first 2 of its 130 problems are taken")) << command << ": " << some.err;
  }
}

TEST_F(TerminalTest, TheReasonOfAFailingProgramStandsOnANarrowScreen) {
  write_program("fails.sh", 3, "my matrix is singular");
  const ProgramRun text = run("solve ball.json --solver 'external{command=./fails.sh,name=mine}' --solver lemke");
  EXPECT_EQ(text.exit_code, 1);
  EXPECT_TRUE(says(text.out,
                   "mine ended with crashed (solve: exited with code 3 without an answer; stderr: my matrix is "
                   "singular); the problem has a solution"))
      << text.out;
  EXPECT_LT(text.out.find("\nmine "), text.out.find("\nlemke ")) << "in the order in which they are named\n"
                                                                 << text.out;
  EXPECT_EQ(run("solve ball.json --solver 'external{command=./fails.sh}' --format json").exit_code, 1);
  // A program that does not start at all is bad input; an honest failure is a result.
  write_program("mute.sh", 0, "no start");
  const ProgramRun mute = run("solve ball.json --solver 'external{command=./mute.sh}' --solver lemke");
  EXPECT_EQ(mute.exit_code, 2);
  EXPECT_TRUE(contains(mute.out, "lemke")) << mute.out;
  EXPECT_TRUE(says(done("solve ball.json --solver 'psor{max_iterations=1}' --solver lemke"), "missed"));
  const std::string unnamed = done("solve ball.json");
  EXPECT_FALSE(says(unnamed, " refused the problem") || says(unnamed, " ended with ")) << unnamed;
}

TEST_F(TerminalTest, CertifySaysWhatItLeftOut) {
  done("run --set paper/copositive/exp1 --trials 22 --solver contact_lemke --store f.db");
  const std::string some = done("certify --store f.db");
  EXPECT_TRUE(says(some,
                   "20 problems with friction were left out, because --every 20 takes only one trial in 20 of them. "
                   "--every 1 takes all"))
      << some;
  const ProgramRun all = run("certify --store f.db --every 1 --format json");
  EXPECT_FALSE(contains(all.err, "left out")) << all.err;
  EXPECT_TRUE(says(all.err, "Of 22 problems with a certificate 22 have a solution, 0 have none, and 0 are open."))
      << all.err;
}

}  // namespace
}  // namespace lcpbench::terminal_test
