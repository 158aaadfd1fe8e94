// Who may be called reliable: the rule by itself, and the reports that used to endorse without evidence.

#include "study/report/reliability.h"

#include <cmath>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>

#include "study/report/decision.h"
#include "study/report/report.h"
#include "study/report/solver_comparison.h"
#include "study/report/speed_error.h"
#include "tests/support/program_run.h"
#include "tests/support/synthetic_store.h"

namespace lcpbench {
namespace {

using report::Evidence;
using report::Ground;
using report::judge_reliability;
using report::Reliability;
using report::Standing;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kSet = "paper/monotone/exp1";
constexpr MadeAnswer kGivesUp{.claim = Claim::kIterationLimit, .error = kNone, .criterion = false, .time_s = 1e-6};
constexpr MadeAnswer kLies{.error = 0.5, .criterion = false, .time_s = 1e-6};
constexpr MadeAnswer kRefuses{.claim = Claim::kUnsupported, .error = kNone, .criterion = false, .detail = "too large"};

/// `solved` of `problems`, all of them taken.
Evidence made_evidence(std::int64_t solved, std::int64_t problems, std::int64_t false_claims = 0) {
  return {.solved = {solved, problems},
          .false_claims = {false_claims, problems},
          .refused = {0, problems},
          .most_taken = problems};
}

Ground ground_of(const Evidence& evidence) { return judge_reliability(evidence).ground; }

TEST(ReliabilityTest, ThirtyFiveSolvedOfThirtyFiveIsTheLeastEvidence) {
  EXPECT_EQ(report::least_problems(), 35);
  EXPECT_EQ(ground_of(made_evidence(34, 34)), Ground::kFewProblems);
  EXPECT_EQ(ground_of(made_evidence(35, 35)), Ground::kNone);
  EXPECT_EQ(ground_of(made_evidence(0, 0)), Ground::kRefuses);
  EXPECT_EQ(ground_of(made_evidence(0, 2)), Ground::kFewProblems);
}

TEST(ReliabilityTest, TheIntervalOfTheShareSolvedDecides) {
  EXPECT_EQ(ground_of(made_evidence(41, 50)), Ground::kWideInterval);
  EXPECT_EQ(ground_of(made_evidence(82, 100)), Ground::kUnsolved);
  EXPECT_EQ(ground_of(made_evidence(95, 100)), Ground::kWideInterval);
  EXPECT_EQ(ground_of(made_evidence(96, 100)), Ground::kNone);
}

TEST(ReliabilityTest, AFalseClaimCountsAtAnyNumberOfProblems) {
  EXPECT_EQ(ground_of(made_evidence(1, 2, 1)), Ground::kFalseClaims);
  EXPECT_EQ(ground_of(made_evidence(561, 562, 1)), Ground::kFalseClaims);
  EXPECT_EQ(ground_of(made_evidence(562, 563, 1)), Ground::kNone);
  Evidence caught_more = made_evidence(19'990, 20'000, 6);
  caught_more.more_false_claims = true;
  EXPECT_EQ(ground_of(caught_more), Ground::kFalseClaims);
}

TEST(ReliabilityTest, BehindTheBestOrOnASmallerSampleIsNotReliable) {
  Evidence behind = made_evidence(980, 1000);
  behind.solves_fewer = true;
  EXPECT_EQ(ground_of(behind), Ground::kBehindTheBest);
  Evidence sampled = made_evidence(100, 100);
  sampled.most_taken = 201;
  EXPECT_EQ(ground_of(sampled), Ground::kSmallSample);
  sampled.most_taken = 200;
  EXPECT_EQ(ground_of(sampled), Ground::kNone);
}

TEST(ReliabilityTest, LessThanHalfOfThePlanNeedsAmpleProblems) {
  EXPECT_EQ(report::ample_problems(), 381);
  Evidence thin = made_evidence(380, 380);
  thin.plan_share = 0.49;
  EXPECT_EQ(ground_of(thin), Ground::kShortOfPlan);
  thin.plan_share = 0.5;
  EXPECT_EQ(ground_of(thin), Ground::kNone);
  Evidence ample = made_evidence(381, 381);
  ample.plan_share = 0.1;
  EXPECT_EQ(ground_of(ample), Ground::kNone);
}

TEST(ReliabilityTest, RefusalsAreNoFailuresAndAreSaid) {
  Evidence refuses = made_evidence(60, 60);
  refuses.refused = {40, 100};
  EXPECT_EQ(judge_reliability(refuses).standing, Standing::kPartly);
  EXPECT_EQ(ground_of(refuses), Ground::kRefuses);
  refuses.refused = {6, 66};
  EXPECT_EQ(ground_of(refuses), Ground::kNone);
  Evidence some_sets = made_evidence(60, 60);
  some_sets.met_all_sets = false;
  EXPECT_EQ(ground_of(some_sets), Ground::kSomeSets);
}

class EndorsementTest : public testing::Test {
 protected:
  EndorsementTest() : made_(folder_ / "s.db") {}

  /// The same answer on the problems first .. last - 1 of a set, where `other` answers too.
  void answers(std::int64_t first, std::int64_t last, const std::vector<std::pair<std::int64_t, MadeAnswer>>& answers,
               const std::string& set = kSet) {
    for (std::int64_t trial = first; trial < last; ++trial) made_.problem(set, trial, answers);
  }
  void write() {
    summary_ = summarize(made_.store());
    write_report(made_.store(), folder_ / "out");
    page_ = read_file(folder_ / "out/report.html");
  }
  report::Contender contender(const std::string& solver) const {
    for (const report::Situation& situation : report::decide(summary_)) {
      for (const report::Contender& each : situation.contenders) {
        if (summary_.solvers[each.solver].text() == solver) return each;
      }
    }
    throw std::logic_error("no contender " + solver);
  }
  /// What the tables say of a solver on kSet: reliable, frontier, reliability.
  nlohmann::json record(const std::string& solver) const {
    const auto document = nlohmann::json::parse(read_file(folder_ / "out/summary.json"));
    for (const auto& record : document["speed_against_error"]["speed_error"]) {
      if (record["set"] == kSet && record["solver"] == solver) return record;
    }
    throw std::logic_error("no record of " + solver);
  }
  void expect_not_endorsed(const std::string& solver, const char* reliability, const nlohmann::json& reliable) {
    const nlohmann::json found = record(solver);
    EXPECT_EQ(found["reliable"], reliable) << solver;
    EXPECT_EQ(found["reliability"], reliability) << solver;
    EXPECT_EQ(found["frontier"], false) << solver;
    for (const report::Situation& situation : report::decide(summary_)) {
      if (!situation.recommended) continue;
      EXPECT_NE(summary_.solvers[situation.contenders[0].solver].name, solver);
    }
    EXPECT_EQ(page_.find("<code>" + solver + "</code>: as reliable"), std::string::npos) << solver;
    EXPECT_EQ(page_.find("<code>" + solver + "</code>: a tie"), std::string::npos) << solver;
  }

  ScratchFolder folder_;
  SyntheticStore made_;
  Summary summary_;
  std::string page_;
};

TEST_F(EndorsementTest, NoneSolvedOfTwoIsTooFewToSay) {
  const auto idle = made_.solver("idle");
  const auto other = made_.solver("other");
  answers(0, 2, {{idle, kGivesUp}, {other, {}}});
  write();
  expect_not_endorsed("idle", "few_problems", nullptr);
  expect_not_endorsed("other", "few_problems", nullptr);
  EXPECT_EQ(contender("idle").verdict, "too few to say: solved 0 of 2");
  const std::string first_screen = page_.substr(0, page_.find("Three limits"));
  EXPECT_NE(first_screen.find("no solver is recommended: too few to say: 2 problems; the report needs 35"),
            std::string::npos);
  EXPECT_NE(page_.find("Who is reliable here, and the frontier: too few to say: 2 problems; the report needs 35"),
            std::string::npos);
  EXPECT_NE(read_file(folder_ / "out/tables/speed_error.csv").find(",,false,few_problems\n"), std::string::npos);
}

/// 82 and 84 of 100 solved: too near to each other for the paired test.
TEST_F(EndorsementTest, EighteenPercentUnsolvedIsNotReliableEvenBesideNoBetter) {
  const auto dense = made_.solver("dense");
  const auto best = made_.solver("best");
  answers(0, 80, {{dense, {.time_s = 1e-5}}, {best, {}}});
  answers(80, 82, {{dense, {.time_s = 1e-5}}, {best, kGivesUp}});
  answers(82, 86, {{dense, kGivesUp}, {best, {}}});
  answers(86, 100, {{dense, kGivesUp}, {best, kGivesUp}});
  write();
  expect_not_endorsed("dense", "unsolved", false);
  expect_not_endorsed("best", "unsolved", false);
  EXPECT_NE(contender("dense").verdict.find("left 18.0 % unsolved"), std::string::npos) << contender("dense").verdict;
  EXPECT_NE(
      page_.find("no solver is shown to be reliable here; the best by share solved, <code>best</code>, solved 84"),
      std::string::npos);
}

/// What a run leaves behind that ended after a ninth: an iterative method that fails now and then beside one that does
/// not, and too few problems for the paired test to see it.
TEST_F(EndorsementTest, AfterANinthOfThePlanNothingIsEndorsed) {
  const auto psor = made_.solver("psor");
  const auto steady = made_.solver("steady");
  answers(0, 19, {{psor, {.time_s = 1e-5}}, {steady, {}}});
  answers(19, 22, {{psor, kGivesUp}, {steady, {}}});
  write();
  expect_not_endorsed("psor", "few_problems", nullptr);
  EXPECT_EQ(contender("psor").verdict, "too few to say: solved 19 of 22");
}

TEST_F(EndorsementTest, ASolverCaughtOnceIsNamedWhereverItIsCalledReliable) {
  const auto clean = made_.solver("clean");
  const auto caught = made_.solver("caught");
  answers(0, 599, {{clean, {}}, {caught, {.time_s = 1e-5}}});
  answers(599, 600, {{clean, {}}, {caught, kLies}});
  write();
  EXPECT_EQ(record("caught")["reliable"], true);
  const std::string first_screen = page_.substr(0, page_.find("Three limits"));
  EXPECT_NE(first_screen.find("it said solved and was wrong on 0.17 %"), std::string::npos);
  EXPECT_NE(first_screen.find("<span class=\"bad\">Said solved, was wrong:</span> <code>caught</code> on 1 of 600"),
            std::string::npos);
  EXPECT_NE(page_.find("<small class=\"bad\">but for 1 false claim</small>"), std::string::npos);
}

TEST_F(EndorsementTest, OneFalseClaimInAHundredIsNotReliable) {
  const auto clean = made_.solver("clean");
  const auto caught = made_.solver("caught");
  answers(0, 99, {{clean, {}}, {caught, {.time_s = 1e-5}}});
  answers(99, 100, {{clean, {}}, {caught, kLies}});
  write();
  expect_not_endorsed("caught", "false_claims", false);
  EXPECT_NE(page_.find("<li class=\"bad\"><code>caught</code>: said solved and was wrong on 1.0 %</li>"),
            std::string::npos);
}

/// A solver at the end of a long list, or on a set of no situation, is on the first screen all the same.
TEST_F(EndorsementTest, EveryFalseClaimIsOnTheFirstScreen) {
  std::vector<std::pair<std::int64_t, MadeAnswer>> all;
  for (int i = 0; i < 9; ++i) all.emplace_back(made_.solver("s" + std::to_string(i)), MadeAnswer{});
  const auto liar = made_.solver("liar");
  all.emplace_back(liar, kLies);
  answers(0, 40, all);
  const auto bare = made_.solver("bare");
  for (std::int64_t trial = 0; trial < 3; ++trial) made_.problem("file:bare", trial, {{bare, kLies}}, 0, "", "lcp");
  write();
  const std::string first_screen = page_.substr(0, page_.find("<details>"));
  EXPECT_NE(first_screen.find("<code>liar</code> on 40 of 40 problems"), std::string::npos);
  EXPECT_NE(first_screen.find("<code>bare</code> on 3 of 3 problems"), std::string::npos);
  EXPECT_EQ(page_.find("No solver here said solved and was wrong"), std::string::npos);
}

TEST_F(EndorsementTest, AStoreWithoutFalseClaimsSaysSo) {
  const auto clean = made_.solver("clean");
  answers(0, 40, {{clean, {}}});
  write();
  EXPECT_NE(page_.find("No solver here said solved and was wrong."), std::string::npos);
  EXPECT_EQ(page_.find("Said solved, was wrong:"), std::string::npos);
  EXPECT_EQ(record("clean")["reliable"], true);
}

/// Refused problems are no failures; who refuses some is neither ranked nor recommended without a word.
TEST_F(EndorsementTest, WhoRefusesIsJudgedByWhatItTook) {
  const auto takes_all = made_.solver("takes_all");
  const auto takes_half = made_.solver("takes_half");
  const auto takes_most = made_.solver("takes_most");
  answers(0, 60, {{takes_all, {}}, {takes_half, {.time_s = 1e-5}}, {takes_most, {.time_s = 1e-5}}});
  answers(60, 95, {{takes_all, {}}, {takes_half, kRefuses}, {takes_most, {.time_s = 1e-5}}});
  answers(95, 100, {{takes_all, {}}, {takes_half, kRefuses}, {takes_most, kRefuses}});
  write();
  expect_not_endorsed("takes_half", "refuses", nullptr);
  EXPECT_EQ(contender("takes_half").verdict, "refused 40 of 100; solved 60.0 % (60 of 100)");
  EXPECT_EQ(record("takes_most")["reliable"], true);
  EXPECT_NE(contender("takes_most").verdict.find("as reliable on what it takes, refused 5.0 %"), std::string::npos)
      << contender("takes_most").verdict;
  EXPECT_EQ(summary_.solvers[report::decide(summary_)[0].contenders[0].solver].name, "takes_all");
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
  write();
  EXPECT_EQ(contender("fc3d{cone=true}").verdict,
            "solves the round cone, another problem; of that solved 100 % (60 of 60)");
  expect_not_endorsed("fc3d", "other_model", nullptr);
  EXPECT_NE(contender("lemke{engine=dense}").reliability.ground, report::Ground::kBehindTheBest);
  // Its answers do not show that the pyramid has a solution: lemke's failures are open, not missed.
  for (const Cell& cell : summary_.cells) {
    const bool is_cone = summary_.solvers[cell.solver].name == "fc3d";
    EXPECT_EQ(cell.count(Verdict::kSolved), is_cone ? 60 : 56);
    EXPECT_EQ(cell.count(Verdict::kOpen), is_cone ? 0 : 4);
  }
  const std::string results = read_file(folder_ / "out/tables/results.csv");
  EXPECT_NE(results.find(",other_model,cone,3e-09,3e-09,,\n"), std::string::npos) << results;
  EXPECT_NE(results.find(",pyramid,2e-13,0.25,30,lcpbench generate "), std::string::npos) << results;
}

/// Without friction the cone and the pyramid are one.
TEST_F(EndorsementTest, ASolverOfTheRoundConeIsRankedWhereThereIsNoFriction) {
  const auto cone = made_.solver("fc3d", "cone=true");
  answers(0, 40, {{cone, {.time_s = 1e-6}}, {made_.solver("slow"), {}}});
  write();
  EXPECT_EQ(record("fc3d")["reliable"], true);
  EXPECT_EQ(summary_.solvers[report::decide(summary_)[0].contenders[0].solver].name, "fc3d");
  EXPECT_EQ(compare_solvers(summary_)[0].times.size(), 2U);
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
  write();
  expect_not_endorsed("engine", "no_time", nullptr);
  EXPECT_EQ(contender("engine").verdict, "not ranked: nobody measured its time; solved 100 % (200 of 200)");
  EXPECT_EQ(record("good")["reliable"], true) << "nobody without a time makes it fall behind";
  const auto situation = report::decide(summary_)[0];
  ASSERT_TRUE(situation.recommended.has_value());
  EXPECT_EQ(summary_.solvers[situation.contenders[*situation.recommended].solver].name, "good");
  const auto compared = compare_solvers(summary_);
  ASSERT_EQ(compared.size(), 1U);
  EXPECT_EQ(compared[0].times.size(), 1U);
}

TEST_F(EndorsementTest, TheRuleStandsOnThePageAndInTheSummaryWithItsNumbers) {
  answers(0, 40, {{made_.solver("clean"), {}}});
  write();
  for (const char* words : {"That takes 35 problems", "at least 90 % of what it takes", "is at most 1 %"}) {
    EXPECT_NE(page_.find(words), std::string::npos) << words;
  }
  const auto rule = nlohmann::json::parse(read_file(folder_ / "out/summary.json"))["reliability_rule"];
  EXPECT_EQ(rule["least_problems"], 35);
  EXPECT_EQ(rule["solved_low_at_least"], 0.9);
}

}  // namespace
}  // namespace lcpbench
