#include "study/summary/summary.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "study/report/report.h"
#include "tests/study/filled_store.h"

namespace lcpbench::summary_test {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kSet = "paper/copositive/exp1";

const Cell& only_cell(const Summary& summary) {
  EXPECT_EQ(summary.cells.size(), 1U);
  return summary.cells.front();
}

std::int64_t sum_of_verdicts(const nlohmann::ordered_json& cell) {
  std::int64_t total = 0;
  for (const char* verdict : {"solved", "wrong", "unsolvable", "refused", "missed", "open"}) {
    total += cell.at(verdict).get<std::int64_t>();
  }
  return total;
}

/// Every combination that a verdict has, once, on problems of which nothing else is known.
TEST(SummaryTest, VerdictsAddUpToTrialsAndTheOtherCountsOverlap) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "s.db");
  const auto solver = made.solver("lemke");
  std::int64_t trial = 0;
  const auto add = [&](const MadeAnswer& answer, const std::string& theory) {
    made.problem(kSet, trial++, {{solver, answer}}, 10, theory);
  };
  add({.error = 1e-12}, "solvable");
  add({.error = 2e-9}, "");
  add({.error = 2e-6}, "");
  add({.claim = Claim::kIterationLimit, .error = 0.9e-9}, "");  // solved, and did not say so
  add({.error = 1e-2, .criterion = true}, "");                 // wrong: the paper's criterion excuses nothing
  add({.error = 1e-2, .criterion = false}, "");                // wrong
  add({.error = kNone}, "");                                   // wrong: NaN
  add({.claim = Claim::kUnsolvable, .error = kNone, .proves_unsolvable = true}, "");
  add({.claim = Claim::kNumericalFailure, .error = kNone}, "solvable");     // missed
  add({.claim = Claim::kCrashed, .error = kNone}, "");                      // open
  add({.claim = Claim::kTimeLimit, .error = 1e-2, .criterion = true}, "");  // open
  add({.claim = Claim::kUnsupported, .error = kNone}, "solvable");          // refused

  const Summary summary = summarize(made.store());
  const auto cell = summary_json(summary)["cells"][0];
  EXPECT_EQ(cell["trials"], 12);
  EXPECT_EQ(sum_of_verdicts(cell), 12);
  EXPECT_EQ(cell["solved"], 4);
  EXPECT_EQ(cell["solved_1e6"], 3);
  EXPECT_EQ(cell["solved_1e9"], 2);
  EXPECT_EQ(cell["wrong"], 3);
  EXPECT_EQ(cell["unsolvable"], 1);
  EXPECT_EQ(cell["refused"], 1);
  EXPECT_EQ(cell["missed"], 1);
  EXPECT_EQ(cell["open"], 2);
  EXPECT_EQ(cell["unsolvable_problems"], 1);
  EXPECT_EQ(cell["claimed"], 6);
  EXPECT_EQ(cell["criterion"], 4);  // of those who claimed
  EXPECT_EQ(cell["criterion_any"], 6);
  EXPECT_EQ(cell["false_claims"], 3);
  EXPECT_EQ(cell["gave_up"], 4);
  EXPECT_EQ(cell["crashed"], 1);
  EXPECT_EQ(cell["time_limit"], 1);
  EXPECT_DOUBLE_EQ(cell["rate"].get<double>(), 4.0 / 11);
  EXPECT_DOUBLE_EQ(cell["rate_low"].get<double>(), wilson(4, 11).low);
  EXPECT_EQ(cell["claims"]["solved"]["wrong"], 3);
  EXPECT_EQ(cell["claims"]["iteration_limit"]["solved"], 1);
}

/// At contacts that miss a solution by less than the tolerance who says solved and who says unsolvable are both right.
TEST(SummaryTest, NearlySolvableContactsAreCountedApart) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "s.db");
  const auto honest = made.solver("a_honest");
  const auto near = made.solver("b_near");
  const auto lost = made.solver("c_lost");
  const MadeAnswer denies{.claim = Claim::kUnsolvable, .error = kNone, .proves_unsolvable = true};
  const MadeAnswer fails{.claim = Claim::kIterationLimit, .error = kNone};
  made.problem(kSet, 0, {{honest, denies}, {near, {}}, {lost, fails}}, 10, "");
  const MadeAnswer denies_falsely{.claim = Claim::kUnsolvable, .error = kNone};
  made.problem(kSet, 1, {{honest, {}}, {near, denies_falsely}, {lost, fails}}, 10, "");
  const Summary summary = summarize(made.store());
  EXPECT_EQ(summary.sets[0].nearly, 1);
  const auto cells = summary_json(summary)["cells"];
  for (const auto& cell : cells) {
    EXPECT_EQ(cell["nearly_problems"], 1);
    EXPECT_EQ(cell["false_claims"], 0);
    EXPECT_EQ(sum_of_verdicts(cell), 2);
  }
  EXPECT_EQ(cells[0]["nearly_unsolvable"], 1);
  EXPECT_EQ(cells[0]["rate"], 1.0);  // its right denial is left out
  EXPECT_EQ(cells[1]["nearly_solved"], 1);
  EXPECT_EQ(cells[1]["false_unsolvable"], 0);  // an answer within the tolerance proves no solution
  EXPECT_EQ(cells[1]["open"], 1);
  EXPECT_EQ(cells[1]["rate"], 0.5);
  EXPECT_EQ(cells[2]["missed"], 2);
  EXPECT_EQ(cells[2]["rate"], 0.0);
}

/// A solver that claims to have solved what another proved unsolvable makes a false claim, unless its answer passes.
TEST(SummaryTest, ClaimOnAnUnsolvableProblemIsFalse) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "s.db");
  const auto honest = made.solver("a_honest");
  const auto liar = made.solver("b_liar");
  made.problem(
      kSet, 0,
      {{honest, {.claim = Claim::kUnsolvable, .error = kNone, .proves_unsolvable = true}}, {liar, {.error = 1e-2}}}, 0,
      "", "lcp");
  const Summary summary = summarize(made.store());
  EXPECT_EQ(summary.cells[0].false_claims(), 0);
  EXPECT_EQ(summary.cells[0].gave_up(), 0);
  EXPECT_EQ(summary.cells[1].false_claims(), 1);
  EXPECT_EQ(summary.cells[1].count(Verdict::kWrong), 1);
  EXPECT_EQ(summary.cells[1].count(Verdict::kUnsolvable), 0);
  EXPECT_EQ(summary.cells[1].unsolvable_problems, 1);
  EXPECT_EQ(summary.cells[1].solvable(), 0);
  const auto cell = summary_json(summary)["cells"][1];
  EXPECT_TRUE(std::isnan(cell["rate"].get<double>()));
  EXPECT_NE(cell.dump().find("\"rate\":null"), std::string::npos);
}

TEST(SummaryTest, TimesAreSetUpPlusSolveAndLeaveOutRefusals) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "s.db");
  const auto solver = made.solver("lemke");
  made.problem(kSet, 0, {{solver, {.time_s = 1}}});
  made.problem(kSet, 1, {{solver, {.time_s = 2}}});
  made.problem(kSet, 2, {{solver, {.claim = Claim::kIterationLimit, .error = kNone, .time_s = 9}}});
  made.problem(kSet, 3, {{solver, {.claim = Claim::kUnsupported, .error = kNone, .time_s = 0, .detail = "too large"}}});
  const Summary summary = summarize(made.store());
  const Cell& cell = only_cell(summary);
  EXPECT_DOUBLE_EQ(cell.solved_time.mean, 1.5);
  EXPECT_DOUBLE_EQ(cell.solved_time.max, 2);
  EXPECT_DOUBLE_EQ(cell.all_time.mean, 4);
  EXPECT_DOUBLE_EQ(cell.all_time.median, 2);
  EXPECT_DOUBLE_EQ(cell.time_parts[1], 1);
  EXPECT_EQ(cell.refusal, "too large");
  EXPECT_FALSE(cell.refused());
}

/// Ratios are taken where both are right: neither a fast wrong answer nor the reference's failure counts.
TEST(SummaryTest, TimeRatioUsesTheProblemsThatBothSolved) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "s.db");
  const auto reference = made.solver("lemke");
  const auto solver = made.solver("quick");
  made.problem(kSet, 0, {{reference, {.time_s = 4}}, {solver, {.time_s = 1}}});
  made.problem(kSet, 1, {{reference, {.time_s = 8}}, {solver, {.time_s = 2}}});
  made.problem(kSet, 2, {{reference, {.time_s = 8}}, {solver, {.error = 1, .criterion = false, .time_s = 0.001}}});
  made.problem(kSet, 3, {{reference, {.error = 1, .criterion = false, .time_s = 0.001}}, {solver, {.time_s = 5}}});
  made.problem(kSet, 4, {{solver, {.time_s = 7}}});
  const Summary summary = summarize(made.store());
  EXPECT_EQ(summary.reference, "lemke");
  ASSERT_EQ(summary.cells.size(), 2U);
  EXPECT_EQ(summary.cells[1].paired, 2);
  EXPECT_DOUBLE_EQ(summary.cells[1].time_ratio.value, 0.25);
  EXPECT_DOUBLE_EQ(summary.cells[1].time_ratio.low, 0.25);
  EXPECT_DOUBLE_EQ(summary.cells[0].time_ratio.value, 1);
}

/// Errors describe what the user was handed as solved; an answer that is no number is beyond every bound.
TEST(SummaryTest, ErrorsAreThoseOfClaimedAnswersAndNaNIsInfinite) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "s.db");
  const auto solver = made.solver("lemke");
  made.problem(kSet, 0, {{solver, {.error = 1e-10}}});
  made.problem(kSet, 1, {{solver, {.error = 1e-8}}});
  made.problem(kSet, 2, {{solver, {.error = kNone}}});
  made.problem(kSet, 3, {{solver, {.claim = Claim::kIterationLimit, .error = 0.5}}});
  const Summary summary = summarize(made.store());
  const Cell& cell = only_cell(summary);
  EXPECT_EQ(cell.error_count, 3);
  EXPECT_EQ(cell.error_median, 1e-8);
  EXPECT_TRUE(std::isinf(cell.error_p99));
  EXPECT_STREQ(cell.error_measure, "velocity_residual_relative");
  EXPECT_NE(summary_json(summary).dump().find("\"p99\":null"), std::string::npos);
}

TEST(SummaryTest, ErrorsOfContactsAndMatricesTogetherHaveNoMeasure) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "s.db");
  const auto solver = made.solver("lemke");
  std::int64_t trial = 0;
  for (const char* kind : {"lcp", "lcp", "contact", "lcp", "lcp"}) {
    made.problem(kSet, trial++, {{solver, {}}}, 0, "solvable", kind);
  }
  EXPECT_STREQ(only_cell(summarize(made.store())).error_measure, "");
}

TEST(SummaryTest, SetsSayWhatTheirProblemsAre) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "s.db");
  const auto solver = made.solver("lemke");
  made.problem("paper/monotone/exp5-1e10", 0, {{solver, {}}});
  made.problem("paper/monotone/exp5-1e8", 0, {{solver, {}}});
  made.problem(kSet, 0, {{solver, {}}}, 12, "");
  const Summary summary = summarize(made.store());
  ASSERT_EQ(summary.sets.size(), 3U);
  EXPECT_EQ(summary.sets[0].name, kSet);
  EXPECT_TRUE(summary.sets[0].frictional);
  EXPECT_FALSE(summary.sets[0].ill_conditioned);
  EXPECT_TRUE(summary.sets[0].all_solvable);  // somebody's verified answer proves it
  EXPECT_EQ(summary.sets[1].name, "paper/monotone/exp5-1e8");
  EXPECT_FALSE(summary.sets[1].frictional);
  EXPECT_TRUE(summary.sets[1].ill_conditioned);
  EXPECT_EQ(summary.sets[2].name, "paper/monotone/exp5-1e10");
}

/// Four parameterisations, eight trials. The best on the even trials is not the best on the odd ones: what is reported
/// as held out must be the even trials' choice, judged on the odd trials.
TEST(SummaryTest, SweepGivesWorstAverageBestAndAnHonestBest) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "s.db");
  const auto a = made.solver("lemke", "zero_tolerance=1e-4", "paper");
  const auto b = made.solver("lemke", "zero_tolerance=1e-8", "paper");
  const MadeAnswer right;
  const MadeAnswer wrong{.error = 1, .criterion = true};
  for (std::int64_t trial = 0; trial < 8; ++trial) {
    const bool even = trial % 2 == 0;
    made.problem(kSet, trial, {{a, even || trial == 1 ? right : wrong}, {b, trial == 0 ? wrong : right}});
  }
  const auto sweeps = summary_json(summarize(made.store()))["sweeps"];
  ASSERT_EQ(sweeps.size(), 1U);
  const auto& sweep = sweeps[0];
  EXPECT_EQ(sweep["cells"], 2);
  EXPECT_EQ(sweep["trials"], 8);
  EXPECT_DOUBLE_EQ(sweep["worst"].get<double>(), 5.0 / 8);
  EXPECT_DOUBLE_EQ(sweep["best"].get<double>(), 7.0 / 8);
  EXPECT_DOUBLE_EQ(sweep["average"].get<double>(), 6.0 / 8);
  EXPECT_EQ(sweep["best_settings"], "zero_tolerance=1e-8");
  EXPECT_EQ(sweep["criterion"]["worst"], 1);
  EXPECT_DOUBLE_EQ(sweep["best_held_out"].get<double>(), 1.0 / 4);
}

/// A sweep of three cells on four trials, whose cells agree in another way on each; beside it the reference.
class SweptStore {
 public:
  explicit SweptStore(const std::filesystem::path& file) : made_(file) {
    SolverRow row{"lemke", "cap=3n", "engine=kernel,cap=3n", "native", "1.0", "baseline", "grid{cap=3n}"};
    Store& store = made_.store();
    store.begin();
    std::vector<SolverRow> cells(3, row);
    for (std::size_t i = 0; i < 3; ++i) cells[i].settings = "cap=3n,t=" + std::to_string(10 - i);
    sweep_ = store.add_solver(row, cells);
    store.commit();
    reference_ = made_.solver("lemke");
    add(0, {{{0, 1, 2}, {.time_s = 2, .violation_m_per_s = 1e-6}}});
    add(1, {{{0}, {.time_s = 4}}, {{1, 2}, {.error = 1, .criterion = true, .time_s = 6, .violation_m_per_s = 2e-6}}});
    add(2, {{{0, 2}, {.claim = Claim::kIterationLimit, .error = kNone, .time_s = 8}}, {{1}, {.time_s = 1}}});
    add(3, {{{0}, {.error = 1, .criterion = false, .time_s = 3}}, {{1}, {.time_s = 5}}, {{2}, {.time_s = 7}}});
  }

  Store& store() { return made_.store(); }

 private:
  using Part = std::pair<std::vector<std::uint32_t>, MadeAnswer>;

  void add(std::int64_t trial, const std::vector<Part>& parts) {
    std::vector<std::pair<std::int64_t, MadeAnswer>> answers{{reference_, {.time_s = 1}}};
    for (const Part& part : parts) answers.emplace_back(sweep_, part.second);
    ProblemResult result = made_.result(kSet, trial, answers, 10, "solvable", "contact");
    for (std::size_t i = 0; i < parts.size(); ++i) {
      result.answers[i + 1].cells = parts[i].first;
      result.answers[i + 1].counters.pivots = 10 * trial;
    }
    store().begin();
    store().add(result);
    store().commit();
  }

  SyntheticStore made_;
  std::int64_t sweep_ = 0;
  std::int64_t reference_ = 0;
};

TEST(SummaryTest, SharedAnswersCountForEachOfTheirCells) {
  const ScratchFolder folder;
  SweptStore made(folder / "s.db");
  const Summary summary = summarize(made.store());
  ASSERT_EQ(summary.cells.size(), 4U);
  ASSERT_EQ(summary.solvers[3].settings, "cap=3n,t=10") << "natural order";
  const Cell& third = summary.cells[1];
  const Cell& second = summary.cells[2];
  const Cell& first = summary.cells[3];
  for (const Cell* cell : {&first, &second, &third}) EXPECT_EQ(cell->trials, 4);
  EXPECT_EQ(first.count(Verdict::kSolved), 2);
  EXPECT_EQ(second.count(Verdict::kSolved), 3);
  EXPECT_EQ(third.count(Verdict::kSolved), 2);
  EXPECT_EQ(first.false_claims(), 1);
  EXPECT_EQ(second.criterion, 4);
  EXPECT_EQ(third.criterion, 3);
  EXPECT_DOUBLE_EQ(second.all_time.mean, (2.0 + 6 + 1 + 5) / 4);
  EXPECT_DOUBLE_EQ(second.solved_time.mean, (2.0 + 1 + 5) / 3);
  EXPECT_DOUBLE_EQ(second.solved_time.max, 5);
  EXPECT_EQ(second.criterion_time.count, 4);
  EXPECT_DOUBLE_EQ(second.criterion_violation.max, 2e-6);
  EXPECT_DOUBLE_EQ(second.violation.max, 1e-6);
  EXPECT_DOUBLE_EQ(third.pivots.mean, (0.0 + 10 + 20 + 30) / 4);
  EXPECT_DOUBLE_EQ(second.time_parts[1], 14.0 / 4 / 4);
  EXPECT_EQ(first.halves[0].trials, 2);
  EXPECT_EQ(first.halves[0].solved, 1);
  EXPECT_EQ(first.halves[1].solved, 1);
  EXPECT_DOUBLE_EQ(second.halves[1].criterion_rate(), 1);
  EXPECT_DOUBLE_EQ(second.halves[1].all_time.mean, 5.5);
  EXPECT_DOUBLE_EQ(second.halves[0].criterion_time.max, 2);
  EXPECT_EQ(first.paired, 2);
  EXPECT_DOUBLE_EQ(first.time_ratio.value, 3);
  EXPECT_DOUBLE_EQ(second.time_ratio.value, 8.0 / 3);
  const auto sweeps = summary_json(summary)["sweeps"];
  ASSERT_EQ(sweeps.size(), 1U);
  EXPECT_EQ(sweeps[0]["cells"], 3);
  EXPECT_EQ(sweeps[0]["best_settings"], "cap=3n,t=9");
}

TEST(SummaryTest, NaturalOrderReadsNumbers) {
  EXPECT_TRUE(natural_less("exp5-1e8", "exp5-1e10"));
  EXPECT_FALSE(natural_less("exp5-1e10", "exp5-1e8"));
  EXPECT_TRUE(natural_less("exp2", "exp10"));
  EXPECT_TRUE(natural_less("a", "ab"));
  EXPECT_FALSE(natural_less("a1", "a1"));
  EXPECT_NE(natural_less("a01", "a1"), natural_less("a1", "a01"));
}

}  // namespace
}  // namespace lcpbench::summary_test
