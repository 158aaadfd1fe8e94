// `lcpbench compare`: two stores that differ in a known way.

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "study/compare/comparison.h"
#include "study/output/text_table.h"
#include "tests/support/program_run.h"
#include "tests/support/synthetic_store.h"

namespace lcpbench::compare_test {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kSet = "paper/monotone/exp1";

/// What one store holds: forty problems, each solver right but where it is said otherwise.
struct Contents {
  std::int64_t problems = 40;
  std::int64_t lemke_fails = 1;  ///< on the first of them
  std::int64_t liar_lies = 2;    ///< on the first of them
  double steady_time_s = 1e-3;
  bool has_extra = false;
  const char* sweep = "paper";
  std::vector<const char*> sets{kSet};
};

constexpr MadeAnswer kFails{.claim = Claim::kIterationLimit, .error = kNone, .criterion = false};
constexpr MadeAnswer kLies{.error = 0.5, .criterion = false};

void fill(SyntheticStore& made, const Contents& contents) {
  const auto lemke = made.solver("lemke");
  const auto liar = made.solver("liar");
  const auto steady = made.solver("steady");
  const auto swept = made.solver("swept", "eps=1", contents.sweep);
  std::vector<std::pair<std::int64_t, MadeAnswer>> extra;
  if (contents.has_extra) extra.emplace_back(made.solver("extra"), MadeAnswer{});
  for (std::int64_t i = 0; i < contents.problems * std::ssize(contents.sets); ++i) {
    const std::int64_t trial = i % contents.problems;
    std::vector<std::pair<std::int64_t, MadeAnswer>> answers = extra;
    answers.emplace_back(lemke, trial < contents.lemke_fails ? kFails : MadeAnswer{});
    answers.emplace_back(liar, trial < contents.liar_lies ? kLies : MadeAnswer{});
    const double size = 1 + 0.1 * static_cast<double>(trial % 7);
    answers.emplace_back(steady, MadeAnswer{.time_s = contents.steady_time_s * size});
    answers.emplace_back(swept, MadeAnswer{});
    made.problem(contents.sets[static_cast<std::size_t>(i / contents.problems)], trial, answers);
  }
}

class CompareTest : public ::testing::Test {
 protected:
  void write(const Contents& a, const Contents& b) {
    SyntheticStore first(folder_ / "a.db");
    fill(first, a);
    SyntheticStore second(folder_ / "b.db");
    fill(second, b);
  }

  void change(const char* store, const std::string& sql) { change_rows(folder_ / store, sql); }

  Json compare(const CompareOptions& options = {}, const char* b_file = "b.db") {
    Store a = Store::open_for_reading(folder_ / "a.db");
    Store b = Store::open_for_reading(folder_ / b_file);
    return compare_stores(a, b, options);
  }

  static Json cell(const Json& comparison, const std::string& solver) {
    for (const Json& change : comparison["cells"]) {
      if (change["a"]["solver"] == solver) return change;
    }
    throw std::runtime_error("no cell of " + solver);
  }

  int run(const std::string& arguments) { return run_program(folder_ / "", "compare " + arguments).exit_code; }

  ScratchFolder folder_;
};

TEST_F(CompareTest, AStoreAgainstItselfIsATieInEverything) {
  write({}, {});
  const Json comparison = compare({}, "a.db");
  ASSERT_EQ(comparison["cells"].size(), 4U);
  for (const Json& change : comparison["cells"]) {
    EXPECT_EQ(change["change"], "tie");
    EXPECT_EQ(change["solved"]["b_is"], "tie");
    EXPECT_EQ(change["false_claims"]["b_is"], "tie");
    for (const char* what : {"solved", "false_claims"}) {
      EXPECT_EQ(change[what]["only_a"], 0);
      EXPECT_EQ(change[what]["only_b"], 0);
    }
    EXPECT_EQ(change["problems"], 40);
    EXPECT_EQ(change["time"]["b_is"], change["a"]["sweep"] == "" ? "tie" : "unknown") << change;
  }
  EXPECT_EQ(comparison["regressed"], false);
  EXPECT_EQ(comparison["slower"], false);
}

TEST_F(CompareTest, LostSolutionsAreWorseByTheCorrectedTest) {
  write({}, {.lemke_fails = 13});
  const Json change = cell(compare(), "lemke");
  EXPECT_EQ(change["solved"]["a"], 39);
  EXPECT_EQ(change["solved"]["b"], 27);
  EXPECT_EQ(change["solved"]["only_a"], 12);
  EXPECT_EQ(change["solved"]["only_b"], 0);
  EXPECT_DOUBLE_EQ(change["solved"]["p"].get<double>(), 2.0 / 4096);
  EXPECT_DOUBLE_EQ(change["solved"]["p_holm"].get<double>(), 3 * 2.0 / 4096)
      << "three single solvers; the sweep is a family of its own";
  EXPECT_EQ(change["solved"]["b_is"], "worse");
  EXPECT_EQ(change["regressed"], true);
}

/// Holm's procedure steps down and never turns the order of the p-values.
TEST_F(CompareTest, EachOfSeveralWorseSolversIsCorrectedByItsRank) {
  write({}, {.lemke_fails = 9, .liar_lies = 14});
  const Json comparison = compare();
  const double lemke = cell(comparison, "lemke")["solved"]["p"].get<double>();
  const double liar = cell(comparison, "liar")["solved"]["p"].get<double>();
  ASSERT_LT(liar, lemke);
  EXPECT_DOUBLE_EQ(cell(comparison, "liar")["solved"]["p_holm"].get<double>(), 3 * liar);
  EXPECT_DOUBLE_EQ(cell(comparison, "lemke")["solved"]["p_holm"].get<double>(), 2 * lemke);
  EXPECT_EQ(cell(comparison, "steady")["solved"]["p_holm"], 1.0);
}

/// Five lost of forty: p = 0.06. A difference that chance explains is a tie, and no regression.
TEST_F(CompareTest, FewLostSolutionsAreATie) {
  write({}, {.lemke_fails = 6});
  EXPECT_EQ(cell(compare(), "lemke")["solved"]["b_is"], "tie");
  EXPECT_EQ(compare()["regressed"], false);
}

/// Three solvers are a family: of five problems all could be lost, with p = 3/16. Seven would do, with p = 3/64.
TEST_F(CompareTest, TooFewProblemsAreNoTie) {
  for (const int problems : {5, 7}) {
    write({.problems = problems}, {.problems = problems});
    const Json comparison = compare();
    EXPECT_EQ(cell(comparison, "lemke")["solved"]["too_few"], problems == 5);
    EXPECT_EQ(comparison["conclusion"], problems == 5 ? "No difference beyond noise, and too few problems to tell."
                                                      : "B is a tie with A: no difference beyond noise.");
  }
}

/// Four lost of forty, on each of two sets: p = 1/8 for each, and 1/128 for both together.
TEST_F(CompareTest, AllSetsTogetherTellWhatNoneTellsAlone) {
  const std::vector<const char*> sets{kSet, "paper/monotone/exp2"};
  write({.sets = sets}, {.lemke_fails = 5, .steady_time_s = 2e-3, .sets = sets});
  const Json comparison = compare();
  EXPECT_EQ(cell(comparison, "lemke")["solved"]["b_is"], "tie");
  ASSERT_EQ(comparison["solvers"].size(), 3U) << "sweeps stay apart";
  const Json& lemke = comparison["solvers"][0];
  EXPECT_EQ(lemke["solver"], "lemke");
  EXPECT_EQ(lemke["problems"], 80);
  EXPECT_EQ(lemke["solved"]["only_a"], 8);
  EXPECT_DOUBLE_EQ(lemke["solved"]["p_holm"].get<double>(), 3 * 1.0 / 128);
  EXPECT_EQ(lemke["solved"]["b_is"], "worse");
  EXPECT_NEAR(comparison["solvers"][2]["time"]["ratio"].get<double>(), 2, 1e-12);
  EXPECT_EQ(comparison["regressed"], true);
  EXPECT_NE(comparison_text(comparison, kUnlimited, false).find("all sets"), std::string::npos);
}

/// No test is needed to call a new wrong answer wrong.
TEST_F(CompareTest, OneNewFalseClaimIsARegression) {
  write({}, {.liar_lies = 3});
  const Json comparison = compare();
  EXPECT_EQ(cell(comparison, "liar")["false_claims"]["only_b"], 1);
  EXPECT_EQ(cell(comparison, "liar")["false_claims"]["b_is"], "tie");
  EXPECT_EQ(cell(comparison, "liar")["change"], "1 new false claim");
  EXPECT_EQ(comparison["regressed"], true);
}

TEST_F(CompareTest, TimesAreRatiosWithTies) {
  write({}, {.steady_time_s = 2e-3});
  const Json time = cell(compare(), "steady")["time"];
  EXPECT_EQ(time["problems"], 40);
  EXPECT_NEAR(time["ratio"].get<double>(), 2, 1e-12);
  EXPECT_NEAR(time["median_ratio"].get<double>(), 2, 1e-12);
  EXPECT_EQ(time["b_is"], "worse");
  EXPECT_EQ(compare()["slower"], true);
  EXPECT_EQ(compare()["regressed"], false) << "time alone is none";
}

TEST_F(CompareTest, FourPercentAreATieAndFewerFailuresABetterment) {
  write({.lemke_fails = 13}, {.steady_time_s = 1.04e-3});
  EXPECT_EQ(cell(compare(), "steady")["time"]["b_is"], "tie");
  EXPECT_EQ(cell(compare(), "lemke")["solved"]["b_is"], "better");
  EXPECT_EQ(compare()["regressed"], false);
}

TEST_F(CompareTest, ProblemsWithOtherDataAreCountedAndLeftOut) {
  write({}, {.problems = 30, .lemke_fails = 13});
  change("b.db", "UPDATE problems SET hash = '01' WHERE trial < 10");
  const Json change = cell(compare(), "lemke");
  EXPECT_EQ(change["problems"], 20);
  EXPECT_EQ(change["left_out"]["other_data"], 10);
  EXPECT_EQ(change["left_out"]["only_in_a"], 10);
  EXPECT_EQ(change["left_out"]["only_in_b"], 0);
  EXPECT_EQ(change["solved"]["only_a"], 3);
  for (const char* left_out :
       {" Left out: 40 answers to problems whose data differ", " Left out: 40 answers that only"}) {
    EXPECT_NE(compare()["summary"].get<std::string>().find(left_out), std::string::npos) << compare()["summary"];
  }
}

TEST_F(CompareTest, VersionsAndLevelsAreComparedUnderOneName) {
  write({}, {});
  change("b.db", "UPDATE solvers SET version = '2.0', isa = 'avx2' WHERE name = 'lemke'");
  const Json comparison = compare();
  EXPECT_EQ(cell(comparison, "lemke")["b"]["version"], "2.0");
  EXPECT_TRUE(comparison["only_in_a"].empty());
  EXPECT_NE(comparison_text(comparison, kUnlimited, true).find("lemke [1.0 -> 2.0] [baseline -> avx2]"),
            std::string::npos);
}

TEST_F(CompareTest, TwoSolversOfOneStoreAreCompared) {
  write({.lemke_fails = 13}, {});
  const Json comparison = compare({.sets = {}, .solver_a = "steady", .solver_b = "lemke"}, "a.db");
  ASSERT_EQ(comparison["cells"].size(), 1U);
  EXPECT_EQ(comparison["cells"][0]["b"]["solver"], "lemke");
  EXPECT_EQ(comparison["cells"][0]["solved"]["only_a"], 13);
  EXPECT_EQ(comparison["cells"][0]["solved"]["b_is"], "worse");
  // As `run` took it, with a setting that is the default.
  EXPECT_EQ(compare({.sets = {}, .solver_a = "steady", .solver_b = "lemke{engine=kernel}"}, "a.db"), comparison);
}

TEST_F(CompareTest, ExitCodesAndJsonOfTheProgram) {
  write({}, {.lemke_fails = 13, .steady_time_s = 2e-3});
  EXPECT_EQ(run("a.db b.db"), 0) << read_file(folder_ / "err");
  EXPECT_NE(read_file(folder_ / "out").find("solves fewer"), std::string::npos);
  EXPECT_EQ(run("a.db b.db --fail-on-regression"), 1);
  EXPECT_EQ(run("b.db a.db --fail-on-regression"), 0);
  EXPECT_EQ(run("a.db b.db --fail-on-slower"), 1);
  EXPECT_EQ(run("b.db a.db --fail-on-slower"), 0);
  EXPECT_EQ(run("a.db nosuch.db"), 2);
  EXPECT_EQ(run("a.db b.db --solver-b lemke"), 2);
  EXPECT_EQ(run("a.db b.db --set 'paper/*' --set 'hard/?'"), 2);
  EXPECT_NE(read_file(folder_ / "err").find("'hard/?'"), std::string::npos);
  EXPECT_EQ(run("a.db b.db --format json --set 'paper/*'"), 0);
  const auto json = nlohmann::json::parse(read_file(folder_ / "out"));
  EXPECT_TRUE(json["regressed"].get<bool>());
  EXPECT_TRUE(json["slower"].get<bool>());
  EXPECT_EQ(json["a"]["provenance"]["processor"], "test processor");
  ASSERT_EQ(json["cells"].size(), 4U);
  for (const auto& cell : json["cells"]) {
    if (cell["a"]["solver"] != "lemke") continue;
    EXPECT_EQ(cell["solved"]["only_a"], 12);
    EXPECT_EQ(cell["solved"]["b_is"], "worse");
  }
}

}  // namespace
}  // namespace lcpbench::compare_test
