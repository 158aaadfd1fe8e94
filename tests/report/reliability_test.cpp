// Who may be called reliable: the rule by itself, and the stores that used to be endorsed without evidence.

#include <cmath>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>

#include "study/report/choice.h"
#include "study/report/report.h"
#include "tests/support/program_run.h"
#include "tests/support/synthetic_store.h"

namespace lcpbench::reliability_test {
namespace {

using report::CellStatistics;
using report::Contender;
using report::Ground;
using report::Statistics;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kSet = "paper/monotone/exp1";
constexpr MadeAnswer kGivesUp{.claim = Claim::kIterationLimit, .error = kNone, .criterion = false, .time_s = 1e-6};
constexpr MadeAnswer kLies{.error = 0.5, .criterion = false, .time_s = 1e-6};
constexpr MadeAnswer kRefuses{.claim = Claim::kUnsupported, .error = kNone, .criterion = false, .detail = "too large"};

/// `solved` of `taken` problems.
CellStatistics made_cell(std::int64_t solved, std::int64_t taken, std::int64_t wrong = 0, std::int64_t refused = 0) {
  CellStatistics cell{.met = taken + refused, .refused = refused};
  cell.solved.fill(solved);
  cell.wrong.fill(wrong);
  for (std::int64_t i = 0; i < taken; ++i) cell.time.add(std::log(1e-3));
  return cell;
}

/// What the rule says of the first of some solvers on one set.
Ground ground_of(const std::vector<CellStatistics>& cells, report::SetPlan plan = {}) {
  Statistics statistics;
  statistics.cells = cells;
  statistics.plans = {plan};
  std::vector<std::size_t> solvers;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    statistics.cells[i].solver = i;
    solvers.push_back(i);
  }
  for (const Contender& contender : choose(statistics, {0}, solvers, 0).contenders) {
    if (contender.solver == 0) return contender.ground;
  }
  throw std::logic_error("the first solver takes no part");
}

TEST(ReliabilityTest, ThirtyFiveSolvedOfThirtyFiveIsTheLeastEvidence) {
  EXPECT_EQ(report::least_problems(), 35);
  EXPECT_EQ(ground_of({made_cell(34, 34)}), Ground::kFewProblems);
  EXPECT_EQ(ground_of({made_cell(35, 35)}), Ground::kNone);
  EXPECT_EQ(ground_of({made_cell(0, 2)}), Ground::kFewProblems);
}

TEST(ReliabilityTest, TheIntervalOfTheShareSolvedDecides) {
  EXPECT_EQ(ground_of({made_cell(41, 50)}), Ground::kWideInterval);
  EXPECT_EQ(ground_of({made_cell(82, 100)}), Ground::kUnsolved);
  EXPECT_EQ(ground_of({made_cell(95, 100)}), Ground::kWideInterval);
  EXPECT_EQ(ground_of({made_cell(96, 100)}), Ground::kNone);
}

TEST(ReliabilityTest, AFalseClaimCountsAtAnyNumberOfProblems) {
  EXPECT_EQ(ground_of({made_cell(1, 2, 1)}), Ground::kFalseClaims);
  EXPECT_EQ(ground_of({made_cell(561, 562, 1)}), Ground::kFalseClaims);
  EXPECT_EQ(ground_of({made_cell(562, 563, 1)}), Ground::kNone);
}

TEST(ReliabilityTest, BehindTheBestOrOnASmallerSampleIsNotReliable) {
  EXPECT_EQ(ground_of({made_cell(100, 100), made_cell(201, 201)}), Ground::kSmallSample);
  EXPECT_EQ(ground_of({made_cell(100, 100), made_cell(200, 200)}), Ground::kNone);
}

TEST(ReliabilityTest, LessThanHalfOfThePlanNeedsAmpleProblems) {
  EXPECT_EQ(report::ample_problems(), 381);
  EXPECT_EQ(ground_of({made_cell(380, 380)}, {100, 49}), Ground::kShortOfPlan);
  EXPECT_EQ(ground_of({made_cell(380, 380)}, {100, 50}), Ground::kNone);
  EXPECT_EQ(ground_of({made_cell(381, 381)}, {100, 10}), Ground::kNone);
}

TEST(ReliabilityTest, RefusalsAreNoFailuresAndAreSaid) {
  EXPECT_EQ(ground_of({made_cell(60, 60, 0, 40)}), Ground::kRefuses);
  EXPECT_EQ(ground_of({made_cell(60, 60, 0, 6)}), Ground::kNone);
}

/// A solver that errors of 1e-3 satisfy is another than the one for 1e-9.
TEST(ReliabilityTest, TheErrorDecidesWhoSolved) {
  CellStatistics rough = made_cell(100, 100, 0);
  for (std::size_t error = 4; error < report::kErrors; ++error) rough.solved[error] = 0;
  Statistics statistics;
  statistics.cells = {rough, made_cell(100, 100)};
  statistics.plans.resize(1);
  statistics.cells[0].time.sum -= 100;
  statistics.cells[1].solver = 1;
  EXPECT_EQ(choose(statistics, {0}, {0, 1}, 3).contenders[0].solver, 0U);
  EXPECT_EQ(choose(statistics, {0}, {0, 1}, 4).contenders[0].solver, 1U);
}

class EndorsementTest : public ::testing::Test {
 protected:
  EndorsementTest() : made_(folder_ / "s.db") {}

  /// The same answers on the problems first .. last - 1 of a set.
  void answers(std::int64_t first, std::int64_t last, const std::vector<std::pair<std::int64_t, MadeAnswer>>& answers,
               const std::string& set = kSet) {
    for (std::int64_t trial = first; trial < last; ++trial) made_.problem(set, trial, answers);
  }
  void read() { report_ = report::read_report(made_.store()); }
  /// The rows of the table `caught`.
  nlohmann::ordered_json caught() {
    report::fill_tables(made_.store(), report_);
    for (const report::TableQuery& query : report::kTableQueries) {
      if (query.name == std::string("caught")) {
        return report::records_of(report::run_query(made_.store().database(), query.name, query.sql));
      }
    }
    throw std::logic_error("no table caught");
  }
  Contender contender(const std::string& solver) const {
    for (const report::Situation& situation : report_.situations) {
      for (const Contender& each : situation.choice.contenders) {
        if (report_.summary.solvers[each.solver].name == solver) return each;
      }
    }
    throw std::logic_error("no contender " + solver);
  }
  /// The solver recommended for the only situation with solvers; "" for none.
  std::string recommended() const {
    for (const report::Situation& situation : report_.situations) {
      if (situation.recommended()) return report_.summary.solvers[situation.recommended()->solver].name;
    }
    return "";
  }
  std::string withheld() const {
    for (const report::Situation& situation : report_.situations) {
      if (!situation.withheld.empty()) return situation.withheld;
    }
    return "";
  }

  ScratchFolder folder_;
  SyntheticStore made_;
  report::Report report_;
};

/// 96 of 100 with four false claims has the higher lower end, and is proven bad; of 30 of 30 nothing is proven.
TEST_F(EndorsementTest, WhoIsProvenBadLeadsNothing) {
  const auto liar = made_.solver("liar");
  const auto newcomer = made_.solver("newcomer");
  answers(0, 30, {{liar, {}}, {newcomer, {}}});
  answers(30, 96, {{liar, {}}});
  answers(96, 100, {{liar, kLies}});
  read();
  EXPECT_EQ(contender("liar").ground, Ground::kFalseClaims);
  EXPECT_GT(contender("liar").solved.interval().low, contender("newcomer").solved.interval().low);
  report::fill_tables(made_.store(), report_);
  const auto leaders = report::records_of(report::run_query(
      made_.store().database(), "leaders", "SELECT part, solver FROM terminal_answer WHERE detail = 0"));
  ASSERT_EQ(leaders.size(), 1U);
  EXPECT_EQ(leaders[0]["part"], "(leads)");
  EXPECT_EQ(leaders[0]["solver"], "newcomer");
  EXPECT_NE(withheld().find("the best by share solved, newcomer, solved"), std::string::npos) << withheld();
}

/// Of 8 of 8 with 52 refusals less is known than of 40 of 60, and of 4 of 4 less than of 30 of 30.
TEST_F(EndorsementTest, WhoRefusesNearlyAllLeadsNothing) {
  const auto picky = made_.solver("picky");
  const auto plain = made_.solver("plain");
  answers(0, 8, {{picky, {.time_s = 1e-6}}, {plain, {}}});
  answers(8, 40, {{picky, kRefuses}, {plain, {}}});
  answers(40, 60, {{picky, kRefuses}, {plain, kGivesUp}});
  read();
  EXPECT_GT(contender("picky").solved.interval().low, contender("plain").solved.interval().low);
  EXPECT_LT(contender("picky").sure_share(), contender("plain").sure_share());
  EXPECT_NE(withheld().find("the best by share solved, plain, "), std::string::npos) << withheld();
  report::fill_tables(made_.store(), report_);
  const auto leaders = report::records_of(report::run_query(
      made_.store().database(), "leaders", "SELECT solver FROM terminal_answer WHERE part = '(leads)'"));
  ASSERT_EQ(leaders.size(), 1U);
  EXPECT_EQ(leaders[0]["solver"], "plain");
  Statistics statistics;
  statistics.cells = {made_cell(4, 4), made_cell(30, 30)};
  statistics.cells[1].solver = 1;
  statistics.plans = {report::SetPlan{}};
  EXPECT_EQ(choose(statistics, {0}, {0, 1}, 0).contenders.front().solver, 1U);
}

/// Where nothing can be solved nobody leads, and who proved it is named.
TEST_F(EndorsementTest, OfProblemsWithoutASolutionWhoSaysSoIsNamed) {
  const auto proves = made_.solver("proves");
  const auto gives_up = made_.solver("gives_up");
  answers(0, 4, {{gives_up, kGivesUp}, {proves, {.claim = Claim::kUnsolvable, .error = kNone, .criterion = false,
                                                 .proves_unsolvable = true}}});
  read();
  EXPECT_EQ(withheld(), "every problem is proven to have no solution; proves said so of 4 of 4 problems");
  report::fill_tables(made_.store(), report_);
  EXPECT_EQ(report::run_query(made_.store().database(), "leaders", "SELECT * FROM terminal_answer WHERE detail = 0")
                .rows.size(),
            0U);
}

/// Mine first, as the user wrote them, and by the name that he gave; the one to use behind them.
TEST_F(EndorsementTest, TheTerminalsAnswerBeginsWithTheNamedSolvers) {
  const auto best = made_.solver("best");
  const auto mine = made_.solver("external", "command=./mine.py,name=mine");
  const auto slow = made_.solver("slow");
  const auto other = made_.solver("other");
  answers(0, 40, {{best, {.time_s = 1e-5}}, {mine, kLies}, {slow, {.time_s = 1}}, {other, {}}});
  read();
  report::fill_tables(made_.store(), report_, {"external{command=./mine.py,name=mine}", "slow"});
  std::string rows;
  for (const auto& row : report::records_of(report::run_query(
           made_.store().database(), "named", "SELECT contacts, solver FROM terminal_answer WHERE detail = 0"))) {
    rows += row["contacts"].get<std::string>() + ":" + row["solver"].get<std::string>() + " ";
  }
  EXPECT_EQ(rows, "Frictionless:mine :slow :best ");
}

TEST_F(EndorsementTest, WhoSolvesSignificantlyFewerThanTheBestIsNotReliable) {
  const auto best = made_.solver("best");
  const auto behind = made_.solver("behind");
  answers(0, 385, {{best, {}}, {behind, {.time_s = 1e-6}}});
  answers(385, 400, {{best, {}}, {behind, kGivesUp}});
  read();
  EXPECT_EQ(contender("behind").ground, Ground::kBehindTheBest);
  EXPECT_EQ(recommended(), "best");
}

/// A solver at the end of a long list, or on a set of no situation, is listed all the same. Its share is of all
/// problems that it took, those of sets on which it was right among them.
TEST_F(EndorsementTest, EveryFalseClaimIsListed) {
  std::vector<std::pair<std::int64_t, MadeAnswer>> all;
  for (int i = 0; i < 9; ++i) all.emplace_back(made_.solver("s" + std::to_string(i)), MadeAnswer{});
  all.emplace_back(made_.solver("liar"), kLies);
  answers(0, 40, all);
  answers(0, 25, {{all.back().first, {}}}, "paper/monotone/exp2");
  answers(25, 30, {{all.back().first, kRefuses}}, "paper/monotone/exp2");
  const auto bare = made_.solver("bare");
  for (std::int64_t trial = 0; trial < 3; ++trial) made_.problem("file:bare", trial, {{bare, kLies}}, 0, "", "lcp");
  read();
  const auto caught = this->caught();
  ASSERT_EQ(caught.size(), 2U);
  EXPECT_EQ(caught[0]["false_claims"], 40);
  EXPECT_EQ(caught[0]["of"], 65);
  EXPECT_DOUBLE_EQ(caught[0]["share"], 40.0 / 65);
  EXPECT_EQ(caught[0]["sets"], kSet);
  EXPECT_EQ(caught[1]["false_claims"], 3);
}

/// The problems of a set that it took none of are among those that it met and refused.
TEST_F(EndorsementTest, AWholeSetRefusedCountsAmongTheRefusals) {
  const auto takes_all = made_.solver("takes_all");
  const auto takes_one = made_.solver("takes_one");
  answers(0, 40, {{takes_all, {}}, {takes_one, {.time_s = 1e-5}}});
  answers(0, 30, {{takes_all, {}}, {takes_one, kRefuses}}, "paper/monotone/exp2");
  read();
  EXPECT_EQ(contender("takes_one").ground, Ground::kSomeSets);
  EXPECT_EQ(contender("takes_one").solved.whole, 40);
  EXPECT_EQ(contender("takes_one").refused.part, 30);
  EXPECT_EQ(contender("takes_one").refused.whole, 70);
  EXPECT_EQ(recommended(), "takes_all");
}

/// It solves its own problem, and fast: that recommends it for no other, and makes nobody else fall behind.
TEST_F(EndorsementTest, ASolverOfTheRoundConeIsNotRankedAmongThoseOfThePyramid) {
  const auto cone = made_.solver("fc3d", "cone=true");
  const auto pyramid = made_.solver("lemke", "engine=dense");
  for (int trial = 0; trial < 60; ++trial) {
    const bool fails = trial % 15 == 0;
    made_.problem(
        kSet, trial,
        {{cone, {.time_s = 1e-6, .solver_error_m_per_s = 3e-9, .model_error_m_per_s = 3e-9}},
         {pyramid, fails ? kGivesUp : MadeAnswer{.solver_error_m_per_s = 2e-13, .model_error_m_per_s = 0.25}}},
        20, "");
  }
  read();
  EXPECT_EQ(contender("fc3d").ground, Ground::kOtherModel);
  EXPECT_NE(contender("lemke").ground, Ground::kBehindTheBest);
  // Its answers do not show that the pyramid has a solution: lemke's failures are open, not missed.
  for (const Cell& cell : report_.summary.cells) {
    const bool is_cone = report_.summary.solvers[cell.solver].name == "fc3d";
    EXPECT_EQ(cell.count(Verdict::kSolved), is_cone ? 60 : 56);
    EXPECT_EQ(cell.count(Verdict::kOpen), is_cone ? 0 : 4);
  }
  write_report(made_.store(), folder_ / "out");
  const std::string results = read_file(folder_ / "out/tables/results.csv");
  EXPECT_NE(results.find(",other_model,cone,3e-09,3e-09,,\n"), std::string::npos) << results;
  EXPECT_NE(results.find(",pyramid,2e-13,0.25,30,lcpbench solve "), std::string::npos) << results;
}

/// The answers of an engine come from a file: they have no time, so that they are neither the fastest nor the best.
TEST_F(EndorsementTest, ASolverWithoutTimesIsNotRanked) {
  const auto engine = made_.solver("engine");
  const auto good = made_.solver("good");
  for (int trial = 0; trial < 60; ++trial) {
    const bool fails = trial % 15 == 0;
    made_.problem(kSet, trial, {{engine, {.time_s = kNone}}, {good, fails ? kGivesUp : MadeAnswer{}}});
  }
  answers(60, 200, {{engine, {.time_s = kNone}}, {good, {}}});
  read();
  EXPECT_EQ(contender("engine").ground, Ground::kNoTime);
  EXPECT_TRUE(contender("good").reliable()) << "nobody without a time makes it fall behind";
  EXPECT_EQ(recommended(), "good");
}

TEST_F(EndorsementTest, IndistinguishableSolversAreATie) {
  const auto a = made_.solver("a");
  const auto b = made_.solver("b");
  answers(0, 60, {{a, {.time_s = 1e-3}}, {b, {.time_s = 1.02e-3}}});
  read();
  EXPECT_EQ(recommended(), "a");
  EXPECT_TRUE(contender("b").tie);
  EXPECT_NEAR(contender("b").factor.ratio.value, 1.02, 1e-4);
  EXPECT_EQ(contender("b").factor.problems, 60);
}

}  // namespace
}  // namespace lcpbench::reliability_test
