// The interface that users' scripts rely on: exit codes, one-line errors, and what commands do together.

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "study/output/explanation.h"
#include "study/store/store.h"
#include "tests/support/program_run.h"
#include "tests/support/study_support.h"

namespace lcpbench::cli_test {
namespace {

using nlohmann::json;

class CommandLineTest : public ::testing::Test {
 protected:
  ProgramRun run(const std::string& arguments) { return run_program(folder_ / "", arguments); }
  json run_json(const std::string& arguments) {
    const ProgramRun output = run(arguments + " --format json");
    EXPECT_EQ(output.exit_code, 0) << output.err;
    return json::parse(output.out);
  }
  ScratchFolder folder_;
};

TEST_F(CommandLineTest, MistakesOfUseExitWith2AndOneLine) {
  for (const char* arguments : {"frobnicate",
                                "run nosuch",
                                "run --shard 0/3",
                                "run --shard 4/3",
                                "run --shard 1/3x",
                                "run --list-shards 0",
                                "run --list-shards 2 --costs nosuch.db",
                                "run --trials 0",
                                "run --seed -4",
                                "run --seed 18446744073709551616",
                                "run --seed 1.5",
                                "run --budget nan",
                                "bench --problems 1 --time-limit nan",
                                "frobnicate --help",
                                "run --jobs 0",
                                "run smoke --solver nope",
                                "run smoke --solver 'lemke{foo=1}'",
                                "run smoke --set nope",
                                "run --sweep nope",
                                "run --sweep paper --solver murty",
                                "solve",
                                "solve nosuch.json",
                                "solve nosuch.scenes",
                                "solve nosuch.scenes#1",
                                "solve x.scenes#y",
                                "import fclib",
                                "import other x --out y.scenes",
                                "import fclib nosuch --out y.scenes",
                                "import fclib nosuch --out y.json",
                                "capture stack --out y.json",
                                "solve --format xml x.json",
                                "solve --max-velocity-error nan x.json",
                                "solve --max-velocity-error 0 x.json",
                                "solve --max-velocity-error 1e-3 --solver auto x.json",
                                "solve --max-velocity-error 1e-3 nosuch.json",
                                "models",
                                "models nosuch.json",
                                "models --max-velocity-error -1 x.json",
                                "generate",
                                "generate nope --seed 1 --count 1 --out d",
                                "generate paper/monotone/exp1 --seed 1 --count 0 --out d",
                                "merge",
                                "merge out.db nosuch.db",
                                "sets nope",
                                "sets file:nosuch",
                                "sets file:nosuch.scenes",
                                "sets file:nosuch.scenes#3",
                                "sets 'paper/monotone/exp2{redundancy=nope}'",
                                "sets 'paper/monotone/exp2{nope=1}'",
                                "report nosuch.db --out ''",
                                "generate paper/monotone/exp1 --seed 1 --count 1 --out ''",
                                "run smoke --set paper/monotone/exp1 --store .",
                                "bench --solver nope",
                                "bench --problems 0",
                                "run smoke --store /nosuchfolder/x.db"}) {
    const ProgramRun output = run(arguments);
    EXPECT_EQ(output.exit_code, 2) << arguments;
    EXPECT_EQ(output.err.rfind("lcpbench: ", 0), 0U) << arguments << ": " << output.err;
    EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1) << arguments << ": " << output.err;
    EXPECT_EQ(output.out, "") << arguments;
  }
  EXPECT_NE(run("solve").err.find("(lcpbench solve --help)"), std::string::npos);
  EXPECT_NE(run("--frobnicate").err.find("(lcpbench --help)"), std::string::npos);
}

TEST_F(CommandLineTest, SolversThatRunOnNoneOfTheSetsAreNotCalledUnavailable) {
  std::ofstream(folder_ / "plan.json") << R"({"format": "lcpbench-plan", "version": 1, "name": "p",
      "sets": ["rigid/exp1"], "solvers": [{"solver": "lemke", "sets": ["rigid/*"]}]})";
  const ProgramRun output = run("run plan.json --set planted/definite");
  EXPECT_EQ(output.exit_code, 2);
  EXPECT_EQ(output.err, "lcpbench: plan p: none of its solvers runs on the sets of --set\n");
}

TEST_F(CommandLineTest, OutputThatDoesNotArriveIsAnError) {
  for (const char* command :
       {"solvers", "sets --format json", "generate paper/monotone/exp1 --seed 1 --count 1 --out d",
        "run --set paper/monotone/exp1 --solver lemke --trials 1", "--help"}) {
    const ProgramRun output = run(std::string(command) + " >/dev/full");
    EXPECT_EQ(output.exit_code, 2) << command;
    EXPECT_NE(output.err.find("No space left on device"), std::string::npos) << command << ": " << output.err;
  }
}

TEST_F(CommandLineTest, TheKnownAnswerOfAHardCaseIsThatOfItsOptions) {
  const auto summary = [&](const std::string& set) { return run("sets '" + set + "' --format json").out; };
  EXPECT_NE(summary("hard/contact/painleve-acceleration").find("no solution: "), std::string::npos);
  const std::string below = summary("hard/contact/painleve-acceleration{mu=1}");
  EXPECT_NE(below.find("solvable, one solution"), std::string::npos) << below;
  EXPECT_NE(summary("hard/edge/scalar{M=-1,q=2}").find("several solutions"), std::string::npos);
}

TEST_F(CommandLineTest, ClosedOutputEndsUpInNoFileAndIsAnError) {
  EXPECT_EQ(run("generate paper/monotone/exp1 --seed 1 --count 2 --out open").exit_code, 0);
  EXPECT_EQ(run("generate paper/monotone/exp1 --seed 1 --count 2 --out closed <&- >&- 2>&-").exit_code, 2);
  for (const char* command : {"sets >&-", "sets 'paper/*/exp1' >&-"}) {
    const ProgramRun listed = run(command);
    EXPECT_EQ(listed.exit_code, 2) << command;
    EXPECT_NE(listed.err.find("Bad file descriptor"), std::string::npos) << listed.err;
  }
  for (const char* name : {"000000.json", "000001.json"}) {
    EXPECT_EQ(read_file(folder_ / "closed" / name), read_file(folder_ / "open" / name)) << name;
  }
}

TEST_F(CommandLineTest, HelpIsCompleteAndNoError) {
  const std::vector<std::pair<std::string, std::vector<const char*>>> options{
      {"solvers", {"--format"}},
      {"steppers", {"--format"}},
      {"sets", {"PATTERN", "--format"}},
      {"generate", {"SET", "--seed", "--count", "--first", "--out"}},
      {"import", {"FORMAT", "FILE", "--out", "--symmetrize"}},
      {"solve", {"FILE", "--solver", "--max-velocity-error", "--time-limit", "--format"}},
      {"models", {"FILE", "--max-velocity-error", "--time-limit", "--wide", "--long", "--format"}},
      {"replay",
       {"SCENE", "--solver", "--stepper", "--plan", "--claim", "--engine-solver", "--engine", "--steps", "--out",
        "--fresh", "--format"}},
      {"shrink",
       {"FILE", "--solver", "--until", "--against", "--speed", "--out", "--time-limit", "--budget", "--format"}},
      {"certify",
       {"FILE", "--exact", "--time-limit", "--proofs", "--format", "--store", "--set", "--every", "--jobs",
        "--other-velocity"}},
      {"run",
       {"PLAN", "--set", "--solver", "--sweep", "--trials", "--seed", "--jobs", "--store", "--shard", "--fresh",
        "--list-shards", "--costs"}},
      {"merge", {"OUT", "IN", "--mixed"}},
      {"report", {"STORE", "--out"}},
      {"bench", {"--set", "--solver", "--problems", "--seed", "--format"}}};
  const ProgramRun overview = run("--help");
  EXPECT_EQ(overview.exit_code, 0);
  for (const auto& [command, names] : options) {
    EXPECT_NE(overview.out.find("\n  " + command + " "), std::string::npos) << command;
    const ProgramRun help = run(command + " --help");
    EXPECT_EQ(help.exit_code, 0);
    for (const char* name : names) EXPECT_NE(help.out.find(name), std::string::npos) << command << " " << name;
    EXPECT_EQ(help.out.find(std::string(31, ' ')), std::string::npos) << "what an option does has one left edge";
  }
}

// A solver of the round cone is none of the pyramid: `bench` judges its answers as `solve` does.
TEST_F(CommandLineTest, BenchVerifiesAnswersByTheirSolversModelOfFriction) {
  const json cells =
      run_json("bench --set scene/stack/ode --solver 'cone_ipm{cone=true}' --reference auto --problems 3")["cells"];
  ASSERT_EQ(cells.size(), 1U);
  EXPECT_EQ(cells[0]["timed"], 3);
}

TEST_F(CommandLineTest, AMissingWorkerProgramMakesItsSolversUnavailable) {
  setenv("LCPBENCH_WORKER_DIR", (folder_ / "").c_str(), 1);
  const json solvers = run_json("solvers");
  const ProgramRun study = run("run smoke --trials 1 --store alone.db");
  unsetenv("LCPBENCH_WORKER_DIR");
  for (const json& solver : solvers) {
    EXPECT_EQ(solver["available"], solver["origin"] != "library") << solver["name"];
    EXPECT_EQ(solver["reason"].get<std::string>().empty(), solver["available"].get<bool>()) << solver["name"];
  }
  EXPECT_EQ(study.exit_code, 0) << study.err;
  EXPECT_NE(study.err.find("skipped: bullet_dantzig: "), std::string::npos) << study.err;
}

// Not there, no library, no PATH: in each case the study goes on without it, and the reason names no folder.
TEST_F(CommandLineTest, ALibraryOfTheUsersThatIsNoneMakesItsSolverUnavailable) {
  std::ofstream(folder_ / "notes.txt") << "no library";
  std::ofstream(folder_ / "good.json")
      << R"({"format": "lcpbench-problem", "version": 1, "name": "one", "kind": "lcp", "M": [[1]], "q": [-1]})";
  std::ofstream(folder_ / "plan.json")
      << R"({"format": "lcpbench-plan", "version": 1, "name": "two", "trials": 1, "sets": ["planted/definite"],)"
      << R"("solvers": ["lemke", {"solver": "path", "optional": true}]})";
  for (const auto& [library, cause] :
       std::vector<std::pair<std::string, std::string>>{{folder_ / "nowhere.so", "nowhere.so"},
                                                        {folder_ / "notes.txt", "notes.txt"},
                                                        {"libm.so.6", "Path_Version"}}) {
    setenv("PATH_LIBRARY", library.c_str(), 1);
    const json solvers = run_json("solvers");
    const ProgramRun solve = run("solve good.json");
    const ProgramRun asked = run("solve good.json --solver path");
    const ProgramRun study = run("run plan.json --fresh --store two.db");
    const ProgramRun validation =
        run("validate --solver lemke --solver siconos_lemke --set planted/definite --trials 2");
    unsetenv("PATH_LIBRARY");
    const auto path =
        std::find_if(solvers.begin(), solvers.end(), [](const json& solver) { return solver["name"] == "path"; });
    ASSERT_NE(path, solvers.end());
    const std::string reason = (*path)["reason"];
    EXPECT_FALSE((*path)["available"].get<bool>()) << library;
    EXPECT_NE(reason.find(cause), std::string::npos) << reason;
    EXPECT_EQ(reason.find('/'), std::string::npos) << reason;
    EXPECT_EQ(solve.exit_code, 0) << solve.err;
    EXPECT_EQ(asked.exit_code, 2);
    EXPECT_NE(asked.err.find(reason), std::string::npos) << asked.err;
    EXPECT_EQ(study.exit_code, 0) << study.err;
    EXPECT_NE(study.err.find("skipped: path: " + reason), std::string::npos) << study.err;
    EXPECT_EQ(validation.exit_code, 0) << validation.err;
  }
}

TEST_F(CommandLineTest, AProgramThatDoesNotStartIsOneLine) {
  std::ofstream(folder_ / "good.json")
      << R"({"format": "lcpbench-problem", "version": 1, "name": "one", "kind": "lcp", "M": [[1]], "q": [-1]})";
  const ProgramRun alone = run("solve good.json --solver 'external{command=./nowhere}'");
  EXPECT_EQ(alone.exit_code, 2);
  EXPECT_EQ(alone.out, "");
  EXPECT_EQ(std::count(alone.err.begin(), alone.err.end(), '\n'), 1) << alone.err;
  EXPECT_NE(alone.err.find("./nowhere"), std::string::npos) << alone.err;
  const ProgramRun beside = run("solve good.json --solver 'external{command=./nowhere}' --solver lemke");
  EXPECT_EQ(beside.exit_code, 2);
  EXPECT_NE(beside.out.find("lemke"), std::string::npos) << beside.out;
}

TEST_F(CommandLineTest, SetsShowsFilesAndCanonicalNames) {
  ASSERT_EQ(run("generate paper/monotone/exp1 --seed 1 --count 3 --out three").exit_code, 0);
  const json files = run_json("sets file:three");
  ASSERT_EQ(files.size(), 1U);
  EXPECT_EQ(files[0]["name"], "file:three");
  EXPECT_EQ(files[0]["size"], "3 problems");
  EXPECT_NE(run("sets file:three/000000.json").out.find("1 problem "), std::string::npos);

  const json options = run_json("sets paper/monotone/exp2")[0]["options"];
  ASSERT_FALSE(options.empty());
  const json as_default = run_json("sets 'paper/monotone/exp2{" + options[0]["name"].get<std::string>() + "=" +
                                   options[0]["default"].get<std::string>() + "}'");
  EXPECT_EQ(as_default[0]["name"], "paper/monotone/exp2");
  const json changed = run_json("sets 'paper/*/exp2{redundancy=combination}'");
  ASSERT_EQ(changed.size(), 2U);
  EXPECT_EQ(changed[0]["name"], "paper/monotone/exp2{redundancy=combination}");
}

TEST(AnswerNoteTest, SaysWhyAnAnswerHasNoErrors) {
  Answer answer;
  answer.claim = Claim::kSolved;
  EXPECT_EQ(why_without_errors(answer, 24), "no z returned");
  answer.z = Vector::Zero(3);
  EXPECT_EQ(why_without_errors(answer, 24), "z has 3 entries, expected 24");
  EXPECT_EQ(why_without_errors(answer, 3), "");
  answer.z(1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(why_without_errors(answer, 3), "z is not finite");
  answer = Answer{};
  answer.claim = Claim::kUnsolvable;
  EXPECT_EQ(why_without_errors(answer, 3), "no z returned");
  answer.detail = "secondary ray";
  EXPECT_EQ(why_without_errors(answer, 3), "");
}

TEST(AnswerNoteTest, SaysThatAProblemIsUnsolvableAlsoIfItsInertiaIsUnresolved) {
  JudgedAnswer answer;
  answer.claim = Claim::kSolved;
  answer.errors.unresolved = true;
  answer.truth = Truth::kUnsolvable;
  answer.verdict = verdict(answer.claim, answer.errors, answer.truth);
  const Problem problem("one row", Lcp{Matrix::Zero(1, 1), -Vector::Ones(1)});
  EXPECT_EQ(why_not_solved(problem, answer), "said solved, but the problem is proven to have no solution.");
}

TEST_F(CommandLineTest, TrialAloneIsByteIdenticalToTheTrialInABatch) {
  ASSERT_EQ(run("generate 'paper/copositive/exp2{redundancy=combination}' --seed 5 --count 4 --out batch").exit_code,
            0);
  ASSERT_EQ(run("generate 'paper/copositive/exp2{redundancy=combination}' --seed 5 --count 1 --first 3 --out alone")
                .exit_code,
            0);
  const std::string alone = read_file(folder_ / "alone/000003.json");
  EXPECT_GT(alone.size(), 100U);
  EXPECT_EQ(alone, read_file(folder_ / "batch/000003.json"));
  EXPECT_NE(alone, read_file(folder_ / "batch/000002.json"));
}

TEST_F(CommandLineTest, OneBadFileDoesNotStopTheOthers) {
  std::ofstream(folder_ / "bad.json") << "{}";
  std::ofstream(folder_ / "good.json")
      << R"({"format": "lcpbench-problem", "version": 1, "name": "one", "kind": "lcp", "M": [[1]], "q": [-1]})";
  const ProgramRun output = run("solve bad.json good.json --solver lemke --format json");
  EXPECT_EQ(output.exit_code, 2);
  EXPECT_EQ(output.err.rfind("lcpbench: bad.json: ", 0), 0U) << output.err;
  EXPECT_EQ(json::parse(output.out).size(), 1U);
}

TEST_F(CommandLineTest, SolveSaysHowDifferentlyVerifiedAnswersMove) {
  // A pile of four cubes that may rest: contact_lemke's path ends in another solution.
  ASSERT_EQ(run("generate scene/mass-ratio-1e6/bullet --seed 1 --first 3 --count 1 --out m").exit_code, 0);
  const std::string differently = "another verified answer moves differently by ";
  const std::string text = run("solve m/000003.json --solver contact_lemke --solver friction_ipm").out;
  EXPECT_NE(text.find(differently), std::string::npos) << text;
  EXPECT_NE(text.find("both pass the check"), std::string::npos) << text;
  const std::string alike = run("solve m/000003.json --solver auto --solver friction_ipm").out;
  EXPECT_NE(alike.find("solved by 2 of 2 solvers"), std::string::npos) << alike;
  EXPECT_EQ(alike.find(differently), std::string::npos) << alike;
}

TEST_F(CommandLineTest, SolveSaysWhichImpulsesItShows) {
  ASSERT_EQ(run("generate scene/stack/ode --seed 1 --count 1 --out s").exit_code, 0);
  const std::string text = run("solve s/000000.json --solver auto").out;
  EXPECT_NE(text.find("impulses (auto): any of those that give this motion"), std::string::npos) << text;
  const json rows =
      json::parse(run("solve s/000000.json --solver 'auto{impulses=even}' --solver psor --format json").out);
  for (const json& row : rows) EXPECT_EQ(row["impulses"], row["solver"] == "auto" ? "even" : "");
}

TEST_F(CommandLineTest, SolveNamesTheContactThatSoftnessMovesMost) {
  const auto solve = [&](const char* v) {
    std::ofstream(folder_ / "soft.json")
        << R"({"format": "lcpbench-problem", "version": 1, "name": "soft", "kind": "contact", "v": [1, )" << v
        << R"(], "N": [[1, 0], [0, 1]], "compliance_n": [1, 1], "G": [[1, 0], [0, 1]]})";
    return run("solve soft.json --solver auto").out;
  };
  EXPECT_NE(solve("-1").find("offsets contact 1 would move differently by"), std::string::npos);
  EXPECT_NE(solve("1").find("offsets no contact would move differently\n"), std::string::npos);
}

/// A sliding particle of 1 kg with r_n = 1 and mu = 0.5, by hand: v+ is (3/4, 0, -1/2) with Coulomb's friction, (1/2,
/// 0, 0) where it is hard, and (2/3, 0, -1/3) in the convex model.
TEST_F(CommandLineTest, AReportTellsTheErrorsOfRelaxationAndSoftness) {
  std::ofstream(folder_ / "soft.json")
      << R"({"format": "lcpbench-problem", "version": 1, "name": "slider", "kind": "contact", "v": [1, 0, -1],)"
      << R"("N": [[0], [0], [1]], "D": [[1, 0, -1, 0], [0, 1, 0, -1], [0, 0, 0, 0]], "edges": [4], "mu": [0.5],)"
      << R"("G": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "compliance_n": [1]})";
  const std::string study =
      "run --set file:soft.json --set 'changed{of=file:soft.json,by=hard}' --solver 'cone_ipm{cone=true}' "
      "--solver 'cone_ipm{cone=true,slip=none}' --store s.db";
  const ProgramRun output = run(study);
  ASSERT_EQ(output.exit_code, 0) << output.err;
  ASSERT_EQ(run("report s.db --out r").exit_code, 0);
  const std::string table = read_file(folder_ / "r/tables/model_errors.csv");
  EXPECT_NE(table.find(",1,0.16666"), std::string::npos) << table;
  const std::size_t softness = table.rfind(",1,0.5");
  const std::size_t nearly = table.rfind(",1,0.4999");
  EXPECT_TRUE(softness != std::string::npos || nearly != std::string::npos) << table;
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 3) << table;
}

TEST_F(CommandLineTest, SolveRunsAllThatFitWhenNoneIsNamed) {
  std::ofstream(folder_ / "good.json")
      << R"({"format": "lcpbench-problem", "version": 1, "name": "one", "kind": "lcp", "M": [[1, -1], [2, 1]], "q": [-1, -1]})";
  std::vector<std::string> names;
  for (const json& row : run_json("solve good.json")) {
    names.push_back(row["solver"]);
    EXPECT_NE(row["claim"], "unsupported");
  }
  for (const char* name : {"lemke", "murty"}) EXPECT_EQ(std::count(names.begin(), names.end(), name), 1) << name;
  EXPECT_EQ(std::count(names.begin(), names.end(), "ode_quickstep"), 0);
}

constexpr const char* kStudy =
    "run --set paper/monotone/exp1 --set paper/monotone/exp2 --solver lemke --solver primal_dual --trials 12 --seed 3 ";

TEST_F(CommandLineTest, RunResumesAndFreshStartsAnew) {
  const ProgramRun first = run(std::string(kStudy) + "--store a.db");
  EXPECT_EQ(first.exit_code, 0) << first.err;
  EXPECT_NE(first.out.find("48 of 48 cells"), std::string::npos) << first.out;
  const std::string rows = dump(folder_ / "a.db");
  EXPECT_EQ(run(std::string(kStudy) + "--store a.db --jobs 2").exit_code, 0);
  EXPECT_EQ(dump(folder_ / "a.db"), rows);
  EXPECT_EQ(run("run --set paper/monotone/exp1 --solver lemke --trials 2 --store a.db --fresh").exit_code, 0);
  EXPECT_EQ(Store::open_for_reading(folder_ / "a.db").cell_count(), 2);
}

TEST_F(CommandLineTest, AQueryBreaksItsTextsAtTheWidthOfTheTerminal) {
  ASSERT_EQ(run("run --set paper/monotone/exp1 --solver lemke --trials 1 --store a.db").exit_code, 0);
  std::ofstream(folder_ / "wide.sql")
      << "SELECT 'some words that stand in one cell' AS a, 'and some others that do' AS b, 7 AS c";
  const auto widest = [](const std::string& text) {
    std::istringstream lines(text);
    std::size_t most = 0;
    for (std::string line; std::getline(lines, line);) most = std::max(most, line.size());
    return most;
  };
  setenv("COLUMNS", "50", 1);
  const ProgramRun narrow = run("query a.db wide.sql");
  const ProgramRun wide = run("query a.db wide.sql --wide");
  unsetenv("COLUMNS");
  EXPECT_LE(widest(narrow.out), 50U) << narrow.out;
  EXPECT_EQ(widest(wide.out), 33U + 2 + 23 + 2 + 1) << wide.out;
}

TEST_F(CommandLineTest, TheProgramAloneShowsItsHelp) {
  const ProgramRun alone = run("");
  EXPECT_EQ(alone.exit_code, 0) << alone.err;
  EXPECT_EQ(alone.out, run("--help").out);
  EXPECT_NE(run("replay --help").out.find("=lcpbench-replay"), std::string::npos) << run("replay --help").out;
}

TEST_F(CommandLineTest, AQueryLosesNoColumnAndAlignsNumbersBehindNulls) {
  ASSERT_EQ(run("run --set paper/monotone/exp1 --solver lemke --trials 1 --store a.db").exit_code, 0);
  std::ofstream(folder_ / "same.sql") << "SELECT x.a, y.a FROM (SELECT 1 AS a) x, (SELECT 2 AS a) y";
  EXPECT_EQ(run("query a.db same.sql --format csv").out, "a,a\n1,2\n");
  const ProgramRun refused = run("query a.db same.sql --format json");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_EQ(refused.err, "lcpbench: same.sql: two columns are named 'a', and JSON needs different names: use AS\n");
  std::ofstream(folder_ / "null.sql") << "SELECT NULL AS n UNION ALL SELECT 22222";
  EXPECT_NE(run("query a.db null.sql").out.find("\n    -\n22222\n"), std::string::npos);
}

TEST_F(CommandLineTest, ShardsMergeToTheUnshardedRun) {
  ASSERT_EQ(run(std::string(kStudy) + "--store whole.db").exit_code, 0);
  for (const char* shard : {"1/2", "2/2"}) {
    ASSERT_EQ(run(std::string(kStudy) + "--shard " + shard + " --store " + shard[0] + ".db").exit_code, 0);
  }
  EXPECT_EQ(run("merge out.db 1.db 2.db").exit_code, 0);
  EXPECT_EQ(dump(folder_ / "out.db"), dump(folder_ / "whole.db"));
}

TEST_F(CommandLineTest, ShardsAreListedWithTheirCostAndWhetherTheyAreDone) {
  const std::string study(kStudy);
  EXPECT_EQ(run(study + "--list-shards 3").exit_code, 2) << "their cost is not known";
  ASSERT_EQ(run("run --set paper/monotone/exp1 --set paper/monotone/exp2 --solver lemke --solver primal_dual "
                "--trials 3 --seed 3 --jobs 1 --store pilot.db")
                .exit_code,
            0);
  EXPECT_EQ(Store::open_for_reading(folder_ / "pilot.db").runs().size(), 1U) << "the record of its cost is no run";
  const std::string list = study + "--jobs 1 --list-shards 3 --costs pilot.db --store 's{}.db' --format json";
  const json before = json::parse(run(list).out);
  EXPECT_EQ(before["array"], "1-3");
  EXPECT_GT(before["megabytes"].get<int>(), 1);
  EXPECT_GE(before["minutes"].get<int>(), 1);
  std::int64_t cells = 0;
  for (const json& shard : before["shards"]) {
    cells += shard["cells"].get<std::int64_t>();
    EXPECT_GT(shard["processor_s"].get<double>(), 0);
    EXPECT_GT(shard["error_s"].get<double>(), 0);
  }
  EXPECT_EQ(cells, 48);
  ASSERT_EQ(run(study + "--costs pilot.db --shard 2/3 --store s2.db").exit_code, 0);
  const json after = json::parse(run(list).out);
  EXPECT_EQ(after["array"], "1,3");
  EXPECT_EQ(after["shards"][1]["done"], after["shards"][1]["cells"]);
  ASSERT_EQ(run("run --set paper/monotone/exp3 --solver lemke --solver primal_dual --trials 12 --seed 3 --store s1.db")
                .exit_code,
            0);
  EXPECT_EQ(json::parse(run(list).out)["array"], "1,3") << "s1.db has the problems of another set";
  std::string other_seed = list;
  other_seed.replace(list.find("--seed 3"), 8, "--seed 4");
  EXPECT_EQ(json::parse(run(other_seed).out)["array"], "1-3") << "s2.db has the problems of another seed";
  const ProgramRun other = run("run --set paper/copositive/exp1 --solver lemke --list-shards 3 --costs pilot.db");
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_NE(other.err.find("no times of 'lemke' on the set 'paper/copositive/exp1'"), std::string::npos) << other.err;
}

TEST_F(CommandLineTest, ShardsOfAPlanWithTheEnginesOwnAnswersAreListed) {
  const std::string study = "run --set scene/box/ode --solver engine --solver lemke ";
  ASSERT_EQ(run(study + "--trials 3 --store pilot.db").exit_code, 0);
  const ProgramRun output = run(study + "--list-shards 2 --costs pilot.db --format json");
  ASSERT_EQ(output.exit_code, 0) << output.err;
  const json document = json::parse(output.out);
  for (const json& shard : document["shards"]) EXPECT_EQ(shard["cells"], 2 * 9);
}

TEST_F(CommandLineTest, MergeOfContradictionsExitsWith1) {
  ASSERT_EQ(run(std::string(kStudy) + "--store a.db").exit_code, 0);
  std::filesystem::copy_file(folder_ / "a.db", folder_ / "b.db");
  change_rows(folder_ / "b.db", "UPDATE answers SET pivots = pivots + 1");
  const ProgramRun output = run("merge out.db a.db b.db");
  EXPECT_EQ(output.exit_code, 1);
  EXPECT_NE(output.err.find("conflict: b.db: answers: paper/monotone/exp"), std::string::npos) << output.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.db"));
}

TEST_F(CommandLineTest, AScenesFileIsProblemsAndASet) {
  const std::string problem =
      R"("problem":{"format":"lcpbench-problem","version":1,"name":"p","kind":"contact","v":[-1],)"
      R"("N":{"starts":[0,1],"rows":[0],"values":[1]},"G_blocks":[[[2]]]}})";
  std::ofstream(folder_ / "two.scenes") << R"({"format":"lcpbench-scenes","version":1,"scene":"s"})"
                                        << "\n"
                                        << R"({"step":3,)" << problem << "\n"
                                        << R"({"step":7,)" << problem << "\n{\"step\":8,";
  const ProgramRun all = run("solve two.scenes --solver lemke");
  EXPECT_EQ(all.exit_code, 0) << all.err;
  EXPECT_NE(all.out.find("two.scenes#3: contact"), std::string::npos) << all.out;
  EXPECT_NE(all.out.find("two.scenes#7: contact"), std::string::npos) << all.out;
  EXPECT_NE(all.err.find("2 complete steps can be read"), std::string::npos) << all.err;
  const ProgramRun one = run("solve two.scenes#7 --solver lemke");
  EXPECT_EQ(one.exit_code, 0) << one.err;
  EXPECT_EQ(one.out.find("#3"), std::string::npos);
  EXPECT_EQ(run("solve two.scenes#8").exit_code, 2);
  EXPECT_EQ(run("certify two.scenes#7 --proofs two.scenes").exit_code, 2);  // the file stays as it is
  const ProgramRun study = run("run --set file:two.scenes --solver lemke --store scenes.db");
  EXPECT_EQ(study.exit_code, 0) << study.err;
  EXPECT_NE(study.err.find("2 complete steps can be read"), std::string::npos) << study.err;
  EXPECT_EQ(run("generate file:two.scenes --seed 1 --count 2 --out d").exit_code, 0);
}

}  // namespace
}  // namespace lcpbench::cli_test
