#include "study/report/regret.h"

#include <cmath>

#include <gtest/gtest.h>

#include "study/report/report.h"
#include "tests/support/program_run.h"
#include "tests/support/synthetic_store.h"

namespace lcpbench {
namespace {

using report::methods_of;
using report::RegretStudy;

TEST(MethodsOfTest, LeavesCountsAndPrecisionOut) {
  EXPECT_EQ(methods_of("contact_lemke, double"), "contact_lemke");
  EXPECT_EQ(methods_of("contact_lemke, friction_ipm, quad"), "contact_lemke + friction_ipm");
  EXPECT_EQ(methods_of("7 islands, 3 at rest, 12 of 40 contacts left out, 1 brought back; active_set 3, "
                       "contact_lemke 1; double"),
            "several islands: active_set + contact_lemke");
  EXPECT_EQ(methods_of("1 island, 12 of 80 contacts left out; psor 1; double"), "psor");
  EXPECT_EQ(methods_of("7 islands, 7 at rest"), "at rest");
  EXPECT_EQ(methods_of(""), "no method");
  EXPECT_EQ(methods_of("ray"), "ray");
}

class RegretTest : public testing::Test {
 protected:
  RegretTest() : made_(folder_ / "s.db") {}

  RegretStudy study() { return report::regret_study(made_.store(), summarize(made_.store())); }

  ScratchFolder folder_;
  SyntheticStore made_;
};

TEST_F(RegretTest, ComparesAutoWithTheFastestThatReachedTheTarget) {
  const auto own = made_.solver("auto");
  const auto rough = made_.solver("rough");
  const auto exact = made_.solver("exact");
  const char* const detail = "contact_lemke, double";
  made_.problem("paper/monotone/exp1", 0,
                {{own, {.error = 1e-13, .time_s = 4e-3, .detail = detail}},
                 {rough, {.error = 5e-5, .time_s = 1e-3}},
                 {exact, {.error = 1e-10, .time_s = 2e-3}}});
  const RegretStudy regret = study();
  ASSERT_EQ(regret.regrets.size(), 4U);
  EXPECT_DOUBLE_EQ(regret.regrets[0].value(), 4);  // 1e-2
  EXPECT_DOUBLE_EQ(regret.regrets[1].value(), 4);  // 1e-4
  EXPECT_DOUBLE_EQ(regret.regrets[2].value(), 2);  // 1e-6
  EXPECT_DOUBLE_EQ(regret.regrets[3].value(), 2);  // 1e-9
  EXPECT_EQ(regret.regrets[0].methods, "contact_lemke");
  EXPECT_EQ(regret.targets[0].large.part, 1);
  EXPECT_EQ(regret.targets[2].large.part, 0);
}

TEST_F(RegretTest, TakesTheAutoWithTheLargestErrorUpToTheTarget) {
  const auto plain = made_.solver("auto");
  const auto loose = made_.solver("auto", "error=1e-4");
  const auto other = made_.solver("auto", "islands=false");
  made_.problem("paper/monotone/exp1", 0,
                {{plain, {.error = 1e-13, .time_s = 8e-3}},
                 {loose, {.error = 9e-5, .time_s = 1e-3}},
                 {other, {.error = 1e-13, .time_s = 2e-3}}});
  const RegretStudy regret = study();
  ASSERT_EQ(regret.regrets.size(), 4U);
  EXPECT_DOUBLE_EQ(regret.regrets[0].value(), 1);
  EXPECT_DOUBLE_EQ(regret.regrets[1].value(), 1);
  EXPECT_DOUBLE_EQ(regret.regrets[2].value(), 4);  // `plain` beside `other`, which it is not
  EXPECT_DOUBLE_EQ(regret.regrets[3].value(), 4);
}

TEST_F(RegretTest, CountsWhatAutoMissedAndLeavesFalseClaimsAtTheTargetOut) {
  const auto own = made_.solver("auto");
  const auto other = made_.solver("other");
  made_.problem("paper/monotone/exp1", 0,
                {{own, {.claim = Claim::kTimeLimit, .error = NAN}}, {other, {.error = 1e-12, .time_s = 1e-3}}});
  made_.problem("paper/monotone/exp1", 1,
                {{own, {.error = 1e-12, .time_s = 1e-3}}, {other, {.error = 0.5, .time_s = 1e-6}}});
  const RegretStudy regret = study();
  ASSERT_EQ(regret.regrets.size(), 8U);
  for (const auto& target : regret.targets) {
    EXPECT_EQ(target.problems, 2);
    EXPECT_EQ(target.missed.part, 1);
    EXPECT_EQ(target.large.whole, 1);
    EXPECT_DOUBLE_EQ(target.geometric_mean.value, 1);
  }
}

TEST_F(RegretTest, ConesSweepsAndUnsolvableProblemsTakeNoPart) {
  const auto own = made_.solver("auto");
  const auto cone = made_.solver("psor", "cone=true");
  const auto swept = made_.solver("lemke", "pivot_tolerance=1e-9", "paper");
  made_.problem("scene/stack/ode", 0, {{own, {.time_s = 1e-3}}, {cone, {.time_s = 1e-6}}, {swept, {.time_s = 1e-6}}},
                20, "solvable", "scene");
  made_.problem("scene/stack/ode", 1,
                {{own, {.claim = Claim::kUnsolvable, .error = 1, .time_s = 1e-3}},
                 {cone, {.claim = Claim::kUnsolvable, .proves_unsolvable = true}}},
                20, "", "scene");
  const RegretStudy regret = study();
  ASSERT_EQ(regret.regrets.size(), 4U);
  for (const auto& each : regret.regrets) EXPECT_DOUBLE_EQ(each.value(), 1);
}

TEST_F(RegretTest, TellsWhatEachListOfMethodsCosts) {
  const auto own = made_.solver("auto");
  const auto other = made_.solver("other");
  const auto add = [&](int trial, double ratio, const char* detail) {
    made_.problem("paper/monotone/exp1", trial,
                  {{own, {.time_s = ratio * 1e-3, .detail = detail}}, {other, {.time_s = 1e-3}}});
  };
  add(0, 2, "active_set, double");
  add(1, 2, "active_set, double");
  add(2, 4, "contact_lemke, friction_ipm, double");
  const RegretStudy regret = study();
  ASSERT_EQ(regret.methods.size(), 4U);
  ASSERT_EQ(regret.methods[0].size(), 2U);
  double shares = 0;
  for (const auto& cost : regret.methods[0]) shares += cost.share_of_loss;
  EXPECT_NEAR(shares, 1, 1e-15);
  EXPECT_NEAR(regret.methods[0][0].share_of_loss, 0.5, 1e-15);
  EXPECT_NEAR(regret.targets[0].geometric_mean.value, std::cbrt(16.0), 1e-14);
  EXPECT_DOUBLE_EQ(regret.targets[0].p99, 4);
}

TEST_F(RegretTest, TheReportHasASectionATableAndNumbersForMachines) {
  const auto own = made_.solver("auto");
  const auto other = made_.solver("other");
  for (int trial = 0; trial < 3; ++trial) {
    made_.problem("paper/monotone/exp1", trial,
                  {{own, {.time_s = 5e-3, .detail = "active_set, double"}}, {other, {.time_s = 1e-3}}});
  }
  write_report(made_.store(), folder_ / "out");
  const std::string page = read_file(folder_ / "out/report.html");
  EXPECT_NE(page.find("<a href=\"#regret\">Regret of auto</a>"), std::string::npos);
  EXPECT_NE(page.find("<section id=\"regret\">"), std::string::npos);
  EXPECT_NE(page.find("<td><code>auto</code></td>"), std::string::npos);
  const std::string table = read_file(folder_ / "out/tables/regret.csv");
  EXPECT_EQ(table.substr(0, table.find('\n')), "set,seed,trial,target,auto,methods,time_s,fastest,fastest_s,regret");
  EXPECT_NE(table.find("\npaper/monotone/exp1,1,2,0.01,auto,active_set,0.005,other,0.001,5.0\n"), std::string::npos)
      << table;
  const auto json = nlohmann::json::parse(read_file(folder_ / "out/summary.json"));
  EXPECT_EQ(json["regret"]["targets"].size(), 4U);
  EXPECT_DOUBLE_EQ(json["regret"]["targets"][0]["geometric_mean"]["value"].get<double>(), 5);
  EXPECT_EQ(json["regret"]["methods"][0]["methods"], "active_set");
}

TEST_F(RegretTest, WithoutAutoThereIsNoSection) {
  made_.problem("paper/monotone/exp1", 0, {{made_.solver("other"), {}}});
  write_report(made_.store(), folder_ / "out");
  EXPECT_EQ(read_file(folder_ / "out/report.html").find("id=\"regret\""), std::string::npos);
  EXPECT_TRUE(study().regrets.empty());
}

}  // namespace
}  // namespace lcpbench
