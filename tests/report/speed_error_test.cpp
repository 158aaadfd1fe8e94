#include "study/report/speed_error.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "study/report/report.h"
#include "tests/support/synthetic_store.h"

namespace lcpbench {
namespace {

using report::ErrorMeasure;
using report::SpeedError;
using report::SpeedErrorPoint;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t kTrials = 40;
constexpr const char* kSet = "paper/monotone/exp1";

std::string read_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// What `lcpbench certify --store` leaves behind: the only velocity of a problem, and forward errors.
class Certified {
 public:
  explicit Certified(SyntheticStore& made) : made_(made) { execute("INSERT OR IGNORE INTO vectors VALUES (1, x'00')"); }

  void unique_velocity(const std::string& set, std::int64_t trial) {
    execute(fmt::format("INSERT INTO certificates VALUES ({}, 'solution', 'exact_basis', 1, 1, NULL, '', 0)",
                        problem_id(set, 1, trial)));
  }
  void forward(const std::string& set, std::int64_t trial, std::int64_t solver, double error) {
    execute(fmt::format("UPDATE verdicts SET forward_velocity = {:.17g} WHERE problem_id = {} AND solver_id = {}",
                        error, problem_id(set, 1, trial), solver));
  }

 private:
  void execute(const std::string& sql) { made_.store().database().execute(sql); }
  SyntheticStore& made_;
};

/// Eight solvers on forty problems; times are 1/32 to 1 of the reference's, which takes 8 ms.
///
/// | solver    | time | forward error         | and                                |
/// | lemke     | 8 ms | 1e-9                  | the reference                      |
/// | quad      | 4 ms | 1e-15                 |                                    |
/// | slow      | 2 ms | 1e-5                  | slower than `fast`, and less exact |
/// | fast      | 1 ms | 1e-6                  |                                    |
/// | twin      | 1.5 ms | 1e-6                |                                    |
/// | wavering  | 0.5 ms | 1e-13, once 1e-3    |                                    |
/// | broken    | 0.25 ms | 1e-15, once no number |                                 |
/// | liar      | 0.1 ms | 1e-15               | wrong on eight, and said solved    |
class SpeedErrorTest : public testing::Test {
 protected:
  SpeedErrorTest() : made_(folder_ / "made.db"), certified_(made_) {}

  void fill(const std::string& set, std::int64_t certified_problems, std::int64_t trials = kTrials) {
    const auto reference = made_.solver("lemke");
    const auto quad = made_.solver("lemke", "precision=quad");
    const auto slow = made_.solver("slow");
    const auto fast = made_.solver("fast");
    const auto twin = made_.solver("twin");
    const auto wavering = made_.solver("wavering");
    const auto broken = made_.solver("broken");
    const auto liar = made_.solver("liar");
    for (std::int64_t trial = 0; trial < trials; ++trial) {
      const bool last = trial + 1 == trials;
      made_.problem(set, trial,
                    {{reference, {.error = 1e-8, .time_s = 8e-3}},
                     {quad, {.error = 1e-14, .time_s = 4e-3}},
                     {slow, {.error = 1e-7, .time_s = 2e-3}},
                     {fast, {.error = 1e-7, .time_s = 1e-3}},
                     {twin, {.error = 1e-7, .time_s = 1.5e-3}},
                     {wavering, {.error = 1e-12, .time_s = 0.5e-3}},
                     {broken, {.error = last ? kNone : 1e-14, .criterion = !last, .time_s = 0.25e-3}},
                     {liar, {.error = trial < 8 ? 0.3 : 1e-14, .criterion = false, .time_s = 0.1e-3}}});
      if (trial >= certified_problems) continue;
      certified_.unique_velocity(set, trial);
      certified_.forward(set, trial, reference, 1e-9);
      certified_.forward(set, trial, quad, 1e-15);
      certified_.forward(set, trial, slow, 1e-5);
      certified_.forward(set, trial, fast, 1e-6);
      certified_.forward(set, trial, twin, 1e-6);
      certified_.forward(set, trial, wavering, last ? 1e-3 : 1e-13);
      if (!last) certified_.forward(set, trial, broken, 1e-15);
      certified_.forward(set, trial, liar, 1e-15);
    }
  }

  SpeedError result(std::size_t set = 0) {
    summary_ = summarize(made_.store());
    return report::speed_error(summary_, set);
  }
  const SpeedErrorPoint& point(const SpeedError& set, const std::string& solver) const {
    for (const SpeedErrorPoint& each : set.points) {
      if (summary_.solvers[each.cell->solver].text() == solver) return each;
    }
    throw std::logic_error("no point of " + solver);
  }
  std::string name(const SpeedError& set, std::optional<std::size_t> place) const {
    return place ? summary_.solvers[set.points[*place].cell->solver].text() : "none";
  }
  void write() { write_report(made_.store(), folder_ / "out"); }

  ScratchFolder folder_;
  SyntheticStore made_;
  Certified certified_;
  Summary summary_;
};

TEST_F(SpeedErrorTest, PointsAreTimeRatioAgainstCertifiedError) {
  fill(kSet, kTrials);
  const SpeedError set = result();
  EXPECT_EQ(set.measure, ErrorMeasure::kForward);
  EXPECT_TRUE(set.relative);
  const SpeedErrorPoint& fast = point(set, "fast");
  EXPECT_NEAR(fast.cost.value, 1.0 / 8, 1e-12);
  EXPECT_DOUBLE_EQ(fast.median, 1e-6);
  EXPECT_DOUBLE_EQ(fast.p99, 1e-6);
  EXPECT_EQ(fast.answers, kTrials);
  EXPECT_EQ(fast.known, kTrials);
  EXPECT_DOUBLE_EQ(point(set, "wavering").median, 1e-13);
  EXPECT_DOUBLE_EQ(point(set, "wavering").p99, 1e-3);
}

TEST_F(SpeedErrorTest, FiveProblemsShowNobodyToBeReliable) {
  const auto idle = made_.solver("idle");
  const auto reference = made_.solver("lemke");
  for (std::int64_t trial = 0; trial < 5; ++trial) {
    made_.problem(kSet, trial, {{reference, {}}, {idle, {.claim = Claim::kIterationLimit, .error = 0.5}}});
  }
  const Summary summary = summarize(made_.store());
  for (const auto& record : report::speed_error_json(summary, report::speed_errors(summary))) {
    EXPECT_TRUE(record["reliable"].is_null()) << record;
    EXPECT_EQ(record["frontier"], false) << record;
  }
}

TEST_F(SpeedErrorTest, TheFrontierHoldsWhatNoReliableSolverBeatsInBoth) {
  fill(kSet, kTrials);
  const SpeedError set = result();
  for (const char* solver : {"wavering", "fast", "lemke{precision=quad}"}) {
    EXPECT_TRUE(point(set, solver).frontier) << solver;
  }
  for (const char* solver : {"lemke", "slow", "twin"}) {
    EXPECT_TRUE(point(set, solver).reliable()) << solver;
    EXPECT_FALSE(point(set, solver).frontier) << solver;
  }
  EXPECT_EQ(point(set, "liar").reliability.ground, report::Ground::kFalseClaims);
  EXPECT_FALSE(point(set, "liar").frontier);
}

TEST_F(SpeedErrorTest, AnAnswerThatIsNoNumberIsAnInfiniteErrorAndNeverOnTheFrontier) {
  fill(kSet, kTrials);
  const SpeedError set = result();
  const SpeedErrorPoint& broken = point(set, "broken");
  EXPECT_EQ(broken.known, kTrials);
  EXPECT_TRUE(std::isinf(broken.p99));
  EXPECT_DOUBLE_EQ(broken.median, 1e-15);
  EXPECT_EQ(broken.reliability.ground, report::Ground::kFalseClaims) << "an answer that is no number, said solved";
  EXPECT_FALSE(broken.frontier);
}

TEST_F(SpeedErrorTest, TheCheapestIsTheFastestReliableOneWithinTheError) {
  fill(kSet, kTrials);
  const SpeedError set = result();
  ASSERT_EQ(set.cheapest.size(), report::kErrorTargets.size());
  const char* const by_p99[] = {"fast", "fast", "lemke{precision=quad}", "lemke{precision=quad}"};
  for (std::size_t i = 0; i < set.cheapest.size(); ++i) {
    EXPECT_EQ(name(set, set.cheapest[i].by_p99), by_p99[i]) << report::kErrorTargets[i];
    EXPECT_EQ(name(set, set.cheapest[i].by_median), "wavering") << report::kErrorTargets[i];
  }
}

TEST_F(SpeedErrorTest, AnswersGivenAfterTheCertificatesHaveNoKnownError) {
  fill(kSet, kTrials);
  made_.store().database().execute("UPDATE verdicts SET forward_velocity = NULL WHERE solver_id = " +
                                   std::to_string(made_.solver("fast")));
  const SpeedError set = result();
  EXPECT_EQ(point(set, "fast").answers, kTrials);
  EXPECT_EQ(point(set, "fast").known, 0);
  EXPECT_TRUE(std::isnan(point(set, "fast").p99));
  EXPECT_FALSE(point(set, "fast").placed());
  EXPECT_TRUE(point(set, "twin").frontier);
}

TEST_F(SpeedErrorTest, HalfOfTheProblemsMustBeCertifiedElseTheResidualStandsAndThePageSaysSo) {
  fill("paper/monotone/exp1", 20);
  fill("paper/monotone/exp2", 19);
  fill("paper/monotone/exp3", 0);
  EXPECT_EQ(result(0).measure, ErrorMeasure::kForward);
  EXPECT_EQ(point(result(0), "fast").known, 20);
  EXPECT_EQ(result(1).measure, ErrorMeasure::kResidual);
  EXPECT_EQ(result(2).measure, ErrorMeasure::kResidual);
  EXPECT_DOUBLE_EQ(point(result(2), "lemke{precision=quad}").p99, 1e-14);
  write();
  const std::string page = read_file(folder_ / "out/report.html");
  EXPECT_NE(page.find("no problem of this set has a certified, unique velocity"), std::string::npos);
  EXPECT_NE(page.find("only 19 of 40 problems have a certified, unique velocity"), std::string::npos);
  EXPECT_NE(page.find(", of 20 of 40 problems"), std::string::npos);
}

TEST_F(SpeedErrorTest, WithoutTheReferenceCostsAreTimes) {
  const auto only = made_.solver("only");
  made_.problem(kSet, 0, {{only, {.time_s = 3e-3}}});
  const SpeedError set = result();
  EXPECT_FALSE(set.relative);
  EXPECT_DOUBLE_EQ(point(set, "only").cost.value, 3e-3);
  write();
  EXPECT_NE(read_file(folder_ / "out/report.html").find("times instead of ratios"), std::string::npos);
}

TEST_F(SpeedErrorTest, NothingIsMeasuredWhereKindsOfProblemsMix) {
  const auto only = made_.solver("only");
  made_.problem("file:mixed", 0, {{only, {}}});
  made_.problem("file:mixed", 1, {{only, {.error = 1e-12}}}, 0, "", "lcp");
  EXPECT_EQ(result().measure, ErrorMeasure::kNone);
  EXPECT_TRUE(result().points.empty());
  write();
}

TEST_F(SpeedErrorTest, ConditionNumbersAreReadFromNamesAndNowhereElse) {
  const auto dial = report::condition_dial("paper/monotone/exp2{redundancy=combination,condition=1e+06}");
  ASSERT_TRUE(dial.has_value());
  EXPECT_EQ(dial->family, "paper/monotone/exp2{redundancy=combination,condition=*}");
  EXPECT_EQ(dial->condition, 1e6);
  EXPECT_TRUE(dial->by_option);
  const auto paper = report::condition_dial("rigid/frictional/exp5-1e10{normals=axis}");
  ASSERT_TRUE(paper.has_value());
  EXPECT_EQ(paper->family, "rigid/frictional/exp5-*{normals=axis}");
  EXPECT_EQ(paper->condition, 1e10);
  EXPECT_FALSE(paper->by_option);
  for (const char* other : {"paper/monotone/exp1", "planted/definite{condition=100}", "hard/x/y{condition=10}",
                            "file:/tmp/exp5-1e5", "file:a{", "paper/x{condition=lots}", "paper/x{condition=0.5}"}) {
    EXPECT_FALSE(report::condition_dial(other).has_value()) << other;
  }
  EXPECT_EQ(report::condition_text(1), "1e0");
  EXPECT_EQ(report::condition_text(1e12), "1e12");
  EXPECT_EQ(report::condition_text(2.5e7), "2.5e7");
}

TEST_F(SpeedErrorTest, AFamilyIsInOrderOfConditionAndHasOneMeasure) {
  fill("paper/monotone/exp2{condition=1e+10}", kTrials);
  fill("paper/monotone/exp2{condition=1}", kTrials);
  fill("paper/monotone/exp5-1e5", kTrials);
  fill("paper/monotone/exp5-1e8", 0);
  fill("paper/monotone/exp6-1e8", kTrials);  // alone: no family
  summary_ = summarize(made_.store());
  const auto families = report::conditioning(summary_);
  ASSERT_EQ(families.size(), 2u);
  EXPECT_EQ(families[0].family, "paper/monotone/exp2{condition=*}");
  EXPECT_EQ(families[0].conditions, (std::vector<double>{1, 1e10}));
  EXPECT_EQ(families[0].measure, ErrorMeasure::kForward);
  EXPECT_EQ(families[1].measure, ErrorMeasure::kResidual);
  EXPECT_EQ(families[1].steps[0].measure, ErrorMeasure::kResidual);
  EXPECT_EQ(families[1].solvers.size(), 8u);
}

TEST_F(SpeedErrorTest, TablesPicturesAndPageSayTheSameTwice) {
  fill("paper/monotone/exp2{condition=1e+10}", kTrials);
  fill("paper/monotone/exp2{condition=1}", kTrials);
  fill(kSet, kTrials);
  write();
  const std::string points = read_file(folder_ / "out/tables/speed_error.csv");
  EXPECT_NE(points.find("set,solver,settings,isa,measure,trials,solved,false_claims,gave_up,answers,known,error.median,"
                        "error.p99,time_ratio.value,time_ratio.low,time_ratio.high,median_time_s,reliable,frontier,reliability\n"),
            std::string::npos);
  EXPECT_NE(points.find("paper/monotone/exp1,wavering,,baseline,forward_velocity,40,40,0,0,40,40,1e-13,0.001,0.0625,"
                        "0.0625,0.0625,0.0005,true,true,reliable\n"),
            std::string::npos);
  EXPECT_NE(
      points.find("paper/monotone/exp1,slow,,baseline,forward_velocity,40,40,0,0,40,40,1e-05,1e-05,0.25,0.25,0.25,"
                  "0.002,true,false,reliable\n"),
      std::string::npos);
  const std::string cheapest = read_file(folder_ / "out/tables/cheapest.csv");
  EXPECT_NE(
      cheapest.find("paper/monotone/exp1,forward_velocity,p99,1e-09,lemke,precision=quad,1e-15,0.5,0.5,0.5,0.004\n"),
      std::string::npos);
  const std::string page = read_file(folder_ / "out/report.html");
  EXPECT_NE(page.find("<section id=\"speed-error\">"), std::string::npos);
  EXPECT_NE(page.find("How it moves with conditioning"), std::string::npos);
  for (const char* number : {">nan", ">inf", " nan", "-nan"}) EXPECT_EQ(page.find(number), std::string::npos) << number;
  const std::string picture = read_file(folder_ / "out/figures/paper_monotone_exp2_condition.conditioning.svg");
  for (const char* word : {"lemke quad", "1e10", "condition number of the inertia"}) {
    EXPECT_NE(picture.find(word), std::string::npos) << word;
  }
  EXPECT_NE(
      read_file(folder_ / "out/tables/conditioning.csv").find("paper/monotone/exp2{condition=*},10000000000.0,fast"),
      std::string::npos);
  const std::string summary = read_file(folder_ / "out/summary.json");
  EXPECT_NE(summary.find("\"speed_against_error\""), std::string::npos);

  write();
  EXPECT_EQ(read_file(folder_ / "out/report.html"), page);
  EXPECT_EQ(read_file(folder_ / "out/summary.json"), summary);
  EXPECT_EQ(read_file(folder_ / "out/tables/speed_error.csv"), points);
}

}  // namespace
}  // namespace lcpbench
