// `lcpbench compare`: two stores that differ in a known way.

#include "study/compare/store_comparison.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/error.h"
#include "study/output/text_table.h"
#include "tests/support/program_run.h"
#include "tests/support/synthetic_store.h"

namespace lcpbench {
namespace {

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
  for (std::int64_t trial = 0; trial < contents.problems; ++trial) {
    std::vector<std::pair<std::int64_t, MadeAnswer>> answers = extra;
    answers.emplace_back(lemke, trial < contents.lemke_fails ? kFails : MadeAnswer{});
    answers.emplace_back(liar, trial < contents.liar_lies ? kLies : MadeAnswer{});
    const double size = 1 + 0.1 * static_cast<double>(trial % 7);
    answers.emplace_back(steady, MadeAnswer{.time_s = contents.steady_time_s * size});
    answers.emplace_back(swept, MadeAnswer{});
    made.problem(kSet, trial, answers);
  }
}

class CompareTest : public testing::Test {
 protected:
  void write(const Contents& a, const Contents& b) {
    SyntheticStore first(folder_ / "a.db");
    fill(first, a);
    SyntheticStore second(folder_ / "b.db");
    fill(second, b);
  }

  void change(const char* store, const std::string& sql) { change_rows(folder_ / store, sql); }

  StoreComparison compare(const CompareOptions& options = {}, const char* b_file = "b.db") {
    Store a = Store::open_for_reading(folder_ / "a.db");
    Store b = Store::open_for_reading(folder_ / b_file);
    return compare_stores(a, b, options);
  }

  static const CellChange& cell(const StoreComparison& comparison, const std::string& solver) {
    for (const CellChange& change : comparison.cells) {
      if (change.a.name == solver) return change;
    }
    throw std::runtime_error("no cell of " + solver);
  }

  int run(const std::string& arguments) { return run_program(folder_ / "", "compare " + arguments).exit_code; }

  ScratchFolder folder_;
};

TEST_F(CompareTest, AStoreAgainstItselfIsATieInEverything) {
  write({}, {});
  const StoreComparison comparison = compare({}, "a.db");
  ASSERT_EQ(comparison.cells.size(), 4U);
  for (const CellChange& change : comparison.cells) {
    EXPECT_EQ(change.solved(), Tendency::kTie);
    EXPECT_EQ(change.false_claims(), Tendency::kTie);
    EXPECT_EQ(change.lost + change.gained + change.false_new + change.false_gone, 0);
    EXPECT_EQ(change.problems, 40);
    if (change.a.sweep.empty()) {
      EXPECT_EQ(change.time(), Tendency::kTie) << change.a.name;
    }
  }
  EXPECT_FALSE(comparison.regressed());
  EXPECT_FALSE(comparison.slower());
}

TEST_F(CompareTest, LostSolutionsAreWorseByTheCorrectedTest) {
  write({}, {.lemke_fails = 13});
  const CellChange change = cell(compare(), "lemke");
  EXPECT_EQ(change.solved_a, 39);
  EXPECT_EQ(change.solved_b, 27);
  EXPECT_EQ(change.lost, 12);
  EXPECT_EQ(change.gained, 0);
  EXPECT_DOUBLE_EQ(change.solved_p, 2.0 / 4096);
  EXPECT_DOUBLE_EQ(change.solved_p_holm, 3 * 2.0 / 4096) << "three single solvers; the sweep is a family of its own";
  EXPECT_EQ(change.solved(), Tendency::kWorse);
  EXPECT_TRUE(change.regressed());
}

/// Five lost of forty: p = 0.06. A difference that chance explains is a tie, and no regression.
TEST_F(CompareTest, FewLostSolutionsAreATie) {
  write({}, {.lemke_fails = 6});
  EXPECT_EQ(cell(compare(), "lemke").solved(), Tendency::kTie);
  EXPECT_FALSE(compare().regressed());
}

TEST_F(CompareTest, GainedSolutionsAreBetter) {
  write({.lemke_fails = 13}, {});
  EXPECT_EQ(cell(compare(), "lemke").solved(), Tendency::kBetter);
  EXPECT_FALSE(compare().regressed());
}

/// No test is needed to call a new wrong answer wrong.
TEST_F(CompareTest, OneNewFalseClaimIsARegression) {
  write({}, {.liar_lies = 3});
  const StoreComparison comparison = compare();
  EXPECT_EQ(cell(comparison, "liar").false_new, 1);
  EXPECT_EQ(cell(comparison, "liar").false_claims(), Tendency::kTie);
  EXPECT_TRUE(comparison.regressed());
}

TEST_F(CompareTest, TimesAreRatiosWithTies) {
  write({}, {.steady_time_s = 2e-3});
  const CellChange change = cell(compare(), "steady");
  EXPECT_EQ(change.timed, 40);
  EXPECT_NEAR(change.time_ratio.value, 2, 1e-12);
  EXPECT_NEAR(change.median_ratio, 2, 1e-12);
  EXPECT_EQ(change.time(), Tendency::kWorse);
  EXPECT_TRUE(compare().slower());
  EXPECT_FALSE(compare().regressed()) << "time alone is none";
}

TEST_F(CompareTest, FourPercentAreATie) {
  write({}, {.steady_time_s = 1.04e-3});
  EXPECT_EQ(cell(compare(), "steady").time(), Tendency::kTie);
}

TEST_F(CompareTest, ProblemsWithOtherDataAreCountedAndLeftOut) {
  write({}, {.problems = 30, .lemke_fails = 13});
  change("b.db", "UPDATE problems SET hash = '01' WHERE trial < 10");
  const CellChange change = cell(compare(), "lemke");
  EXPECT_EQ(change.problems, 20);
  EXPECT_EQ(change.other_data, 10);
  EXPECT_EQ(change.only_in_a, 10);
  EXPECT_EQ(change.only_in_b, 0);
  EXPECT_EQ(change.lost, 3);
  EXPECT_NE(comparison_text(compare(), kUnlimited).find("whose data differ"), std::string::npos);
}

TEST_F(CompareTest, PivotsAreSummedOverTheSameProblems) {
  write({}, {.problems = 30});
  change("a.db", "UPDATE answers SET pivots = 7");
  change("b.db", "UPDATE answers SET pivots = 8");
  const CellChange change = cell(compare(), "lemke");
  EXPECT_EQ(change.counted, 30);
  EXPECT_EQ(change.pivots_a, 7 * 30);
  EXPECT_EQ(change.pivots_b, 8 * 30);
}

TEST_F(CompareTest, VersionsAndLevelsAreComparedUnderOneName) {
  write({}, {});
  change("b.db", "UPDATE solvers SET version = '2.0', isa = 'avx2' WHERE name = 'lemke'");
  const StoreComparison comparison = compare();
  EXPECT_EQ(cell(comparison, "lemke").b.version, "2.0");
  EXPECT_TRUE(comparison.missing.empty());
  EXPECT_NE(comparison_text(comparison, kUnlimited).find("lemke [1.0 -> 2.0] [baseline -> avx2]"), std::string::npos);
}

TEST_F(CompareTest, SolversOfOneStoreAloneAreNamed) {
  write({.sweep = "other"}, {.has_extra = true});
  const StoreComparison comparison = compare();
  ASSERT_EQ(comparison.added.size(), 2U);
  EXPECT_EQ(comparison.added[0], std::string(kSet) + ": extra");
  ASSERT_EQ(comparison.missing.size(), 1U);
  EXPECT_NE(comparison.missing[0].find("swept"), std::string::npos);
}

TEST_F(CompareTest, TwoSolversOfOneStoreAreCompared) {
  write({.lemke_fails = 13}, {});
  const StoreComparison comparison = compare({.sets = {}, .solver_a = "steady", .solver_b = "lemke"}, "a.db");
  ASSERT_EQ(comparison.cells.size(), 1U);
  EXPECT_EQ(comparison.cells[0].b.name, "lemke");
  EXPECT_EQ(comparison.cells[0].lost, 13);
  EXPECT_EQ(comparison.cells[0].solved(), Tendency::kWorse);
}

TEST_F(CompareTest, NothingInCommonIsBadInput) {
  write({}, {});
  EXPECT_THROW(compare({.sets = {"hard/*"}, .solver_a = "", .solver_b = ""}), InputError);
  EXPECT_THROW(compare({.sets = {}, .solver_a = "nosuch", .solver_b = ""}), InputError);
}

TEST_F(CompareTest, PatternThatNamesNoSetIsNamed) {
  write({}, {});
  std::string message;
  try {
    compare({.sets = {"*", "hard/?"}, .solver_a = "", .solver_b = ""});
  } catch (const InputError& error) {
    message = error.what();
  }
  EXPECT_NE(message.find("'hard/?'"), std::string::npos) << message;
}

TEST_F(CompareTest, ExitCodesAndJsonOfTheProgram) {
  write({}, {.lemke_fails = 13, .steady_time_s = 2e-3});
  EXPECT_EQ(run("a.db b.db"), 0) << read_file(folder_ / "err");
  EXPECT_NE(read_file(folder_ / "out").find("SOLVES FEWER"), std::string::npos);
  EXPECT_EQ(run("a.db b.db --fail-on-regression"), 1);
  EXPECT_EQ(run("b.db a.db --fail-on-regression"), 0);
  EXPECT_EQ(run("a.db b.db --fail-on-slower"), 1);
  EXPECT_EQ(run("b.db a.db --fail-on-slower"), 0);
  EXPECT_EQ(run("a.db nosuch.db"), 2);
  EXPECT_EQ(run("a.db b.db --solver-b lemke"), 2);
  EXPECT_EQ(run("a.db b.db --set 'hard/*'"), 2);
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
}  // namespace lcpbench
