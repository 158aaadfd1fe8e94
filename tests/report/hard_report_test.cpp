#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>

#include <gtest/gtest.h>

#include "study/report/report.h"
#include "tests/support/synthetic_store.h"

namespace lcpbench::hard_report_test {
namespace {

/// Along the mass ratio of a stack `good` is right, `liar` breaks at 2^30 and says nothing, `shy` gives up there,
/// `denier` finds no solution, and `picky` refuses; one more case has no solution, which `denier` proves.
class HardReportTest : public ::testing::Test {
 protected:
  HardReportTest() : made_(folder_ / "hard.db") {
    const auto good = made_.solver("good");
    const auto liar = made_.solver("liar");
    const auto shy = made_.solver("shy");
    const auto denier = made_.solver("denier");
    const auto picky = made_.solver("picky");
    const auto stack = [&](const std::string& dials, bool breaks) {
      const MadeAnswer right{.error = 1e-15};
      made_.problem(
          "hard/contact/stack" + dials, 0,
          {{good, right},
           {liar, breaks ? MadeAnswer{.error = 0.5, .criterion = false} : right},
           {shy, breaks ? MadeAnswer{.claim = Claim::kIterationLimit, .error = 0.5, .criterion = false} : right},
           {denier, breaks ? MadeAnswer{.claim = Claim::kUnsolvable, .error = kNan, .criterion = false} : right},
           {picky, {.claim = Claim::kUnsupported, .error = kNan, .detail = "no stacks"}}});
    };
    stack("", false);
    stack("{ratio=30}", true);
    stack("{ratio=5}", false);
    stack("{ratio=30,order=growing}", true);
    made_.problem("hard/ray/infeasible", 0,
                  {{liar, {.error = 1e-2}},
                   {shy, {.claim = Claim::kIterationLimit, .error = kNan}},
                   {denier, {.claim = Claim::kUnsolvable, .error = kNan, .proves_unsolvable = true}}},
                  0, "", "lcp");
    made_.problem("paper/monotone/exp1", 0, {{good, {}}});
  }

  static constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

  void fill() {
    report_ = report::read_report(made_.store());
    report::fill_tables(made_.store(), report_);
  }
  std::string outcome(const std::string& set, const std::string& solver) {
    const auto rows =
        report::records_of(report::run_query(made_.store().database(), "test", "SELECT * FROM hard_cases"));
    for (const auto& row : rows) {
      if (row["set"] == set && row["solver"] == solver) return row["outcome"];
    }
    return "";
  }

  ScratchFolder folder_;
  SyntheticStore made_;
  report::Report report_;
};

TEST_F(HardReportTest, EachAnswerIsCalledWhatItIs) {
  fill();
  const auto is = [&](const std::string& set, const std::string& solver) { return outcome(set, solver); };
  EXPECT_EQ(is("hard/contact/stack{ratio=30}", "good"), "solved");
  EXPECT_EQ(is("hard/contact/stack{ratio=30}", "liar"), "false_claim");
  EXPECT_EQ(is("hard/contact/stack{ratio=30}", "shy"), "missed");
  EXPECT_EQ(is("hard/contact/stack{ratio=30}", "denier"), "wrongly_unsolvable");
  EXPECT_EQ(is("hard/contact/stack{ratio=30}", "picky"), "refused");
  EXPECT_EQ(is("hard/ray/infeasible", "good"), "");
  EXPECT_EQ(is("hard/ray/infeasible", "liar"), "false_claim");
  EXPECT_EQ(is("hard/ray/infeasible", "shy"), "gave_up_unsolvable");
  EXPECT_EQ(is("hard/ray/infeasible", "denier"), "rightly_unsolvable");
}

TEST_F(HardReportTest, TheTableHasEveryCaseAndSolver) {
  write_report(made_.store(), folder_ / "out");
  std::ostringstream table;
  table << std::ifstream(folder_ / "out/tables/hard_cases.csv").rdbuf();
  const std::string text = table.str();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1 + 4 * 5 + 3) << text;
  EXPECT_NE(text.find("hard/contact/stack{ratio=30},"), std::string::npos);
  EXPECT_NE(text.find(",liar,false_claim,"), std::string::npos) << text;
  EXPECT_NE(text.find(",denier,rightly_unsolvable,"), std::string::npos) << text;
}

TEST(HardReportAloneTest, AStoreOfHardCasesAloneRecommendsNothing) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "hard.db");
  const auto solver = made.solver("lemke");
  for (const char* name : {"hard/contact/stack", "hard/ray/infeasible"}) made.problem(name, 0, {{solver, {}}});
  const report::Report report = report::read_report(made.store());
  for (const report::Situation& situation : report.situations) EXPECT_TRUE(situation.sets.empty());
  EXPECT_TRUE(report.statistics.pairs.empty());
  report::fill_tables(made.store(), report);
  const std::string text = answer_text(made.store(), report, 100, 24);
  EXPECT_NE(text.find("2 hard cases"), std::string::npos) << text;
  EXPECT_NE(text.find("no solver is recommended"), std::string::npos) << text;
}

TEST_F(HardReportTest, TheTerminalNamesEveryFalseClaim) {
  fill();
  const std::string text = results_text(made_.store(), report_.summary, 100);
  EXPECT_NE(text.find("  liar: contact/stack{ratio=30,order=growing}, contact/stack{ratio=30}, ray/infeasible\n"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("hard/contact/stack"), std::string::npos);
}

}  // namespace
}  // namespace lcpbench::hard_report_test
