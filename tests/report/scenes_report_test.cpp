#include <map>
#include <regex>

#include <gtest/gtest.h>

#include "core/io/scenes_file.h"
#include "study/report/decision.h"
#include "study/report/report.h"
#include "study/report/sets.h"
#include "tests/support/program_run.h"
#include "tests/support/synthetic_store.h"

namespace lcpbench::scenes_report_test {
namespace {

class ScenesReportTest : public ::testing::Test {
 protected:
  ScenesReportTest() : made_(folder_ / "s.db"), good_(made_.solver("good")), liar_(made_.solver("liar")) {}

  /// @param lies  whether `liar` answers wrongly; it is fast
  void add(const std::string& set, const std::string& kind, int steps, bool lies = true) {
    for (int step = 0; step < steps; ++step) {
      made_.problem(set, step, {{good_, {.time_s = 2e-3}}, {liar_, {.error = lies ? 0.5 : 1e-12, .time_s = 1e-5}}}, 20,
                    "solvable", kind);
    }
  }

  ScratchFolder folder_;
  SyntheticStore made_;
  std::int64_t good_;
  std::int64_t liar_;
};

TEST_F(ScenesReportTest, ScenesAreTheFirstRowsAndNoRandomProblems) {
  add("scene/stack/ode", "scene", 40);
  add("scene/box-pile/bullet", "scene", 40);
  add("scene/hand/dart", "contact", 40);
  add("scene/wedge/ode", "scene", 40);
  add("paper/copositive/exp1", "contact", 40, false);
  const report::Report report = report::read_report(made_.store());
  const Summary& summary = report.summary;
  const auto& situations = report.situations;
  std::vector<std::string> titles;
  for (const auto& situation : situations) titles.push_back(situation.title);
  EXPECT_EQ(titles, (std::vector<std::string>{"A robot's step", "Stacks and walls", "Piles", "Other scenes",
                                              "Frictionless", "Frictional", "Ill-conditioned"}));
  for (std::size_t i = 0; i < 4; ++i) {
    ASSERT_EQ(situations[i].sets.size(), 1U);
    ASSERT_TRUE(situations[i].choice.recommended);
    EXPECT_EQ(summary.solvers[situations[i].choice.contenders[0].solver].name, "good") << titles[i];
  }
  EXPECT_EQ(summary.sets[situations[0].sets[0]].name, "scene/hand/dart");
  ASSERT_EQ(situations[5].sets.size(), 1U);
  EXPECT_EQ(summary.solvers[situations[5].choice.contenders[0].solver].name, "liar");
}

TEST_F(ScenesReportTest, AStoreWithoutScenesHasTheRowsOfRandomProblemsAlone) {
  add("paper/copositive/exp1", "contact", 40);
  EXPECT_EQ(report::read_report(made_.store()).situations.size(), 3U);
}

TEST_F(ScenesReportTest, IllConditionedSetsWithAndWithoutFrictionHaveARowEach) {
  add("paper/copositive/exp5-1e8", "contact", 40);
  for (int trial = 0; trial < 40; ++trial) made_.problem("paper/monotone/exp5-1e8", trial, {{good_, {}}});
  std::map<std::string, std::string> sets;
  const report::Report report = report::read_report(made_.store());
  for (const report::Situation& each : report.situations) {
    for (const std::size_t set : each.sets) sets[each.title] += report.summary.sets[set].name;
  }
  EXPECT_EQ(sets, (std::map<std::string, std::string>{{"Ill-conditioned, frictional", "paper/copositive/exp5-1e8"},
                                                      {"Ill-conditioned, frictionless", "paper/monotone/exp5-1e8"}}));
}

/// A step that is not proven solvable, as where an offset is negative, must not push its set out of the table.
TEST_F(ScenesReportTest, SetsThatAreNotAllProvenSolvableCount) {
  add("scene/stack/ode", "scene", 40);
  made_.problem("scene/stack/bullet", 0, {{good_, {}}, {liar_, {}}}, 20, "", "scene");
  made_.problem("scene/stack/bullet", 1, {{good_, {.error = 0.5}}, {liar_, {.error = 0.5}}}, 20, "", "scene");
  EXPECT_EQ(report::read_report(made_.store()).situations[0].sets.size(), 2U);
}

TEST(SetsTest, ConditionNumbersAreReadFromNamesAndNowhereElse) {
  const auto family = [](const char* name) { return report::family_of({.name = name}); };
  const auto is_dial = [](const char* name) {
    return report::kind_of({.name = name, .contact = true}) == report::SetKind::kDial;
  };
  EXPECT_EQ(family("paper/monotone/exp2{condition=1e4}"), "paper/monotone/exp2{condition=*}");
  EXPECT_EQ(family("rigid/exp2{condition=2.5,redundancy=copy}"), "rigid/exp2{condition=*,redundancy=copy}");
  EXPECT_TRUE(is_dial("paper/monotone/exp2{condition=1e4}"));
  EXPECT_EQ(family("paper/copositive/exp5-1e8"), "paper/copositive/exp5-*");
  EXPECT_EQ(family("paper/copositive/exp6-1e10{redundancy=copy}"), "paper/copositive/exp6-*{redundancy=copy}");
  EXPECT_FALSE(is_dial("paper/copositive/exp5-1e8"));
  EXPECT_FALSE(is_dial("hard/contact/stack{condition=1e4}"));
  EXPECT_EQ(family("planted/pile{condition=1e4}"), "planted/pile{condition=1e4}");
  EXPECT_EQ(family("paper/monotone/exp2{condition=x}"), "paper/monotone/exp2{condition=x}");
  EXPECT_FALSE(is_dial("paper/monotone/exp2{condition=x}"));
  EXPECT_EQ(family("file:a{b"), "file:a{b");
}

}  // namespace
}  // namespace lcpbench::scenes_report_test
