#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>

#include <gtest/gtest.h>

#include "study/report/report.h"
#include "study/report/hard.h"
#include "study/report/page.h"
#include "tests/support/synthetic_store.h"

namespace lcpbench {
namespace {

using report::HardOutcome;

/// Along the mass ratio of a stack `good` is right, `liar` breaks at 2^30 and says nothing, `shy` gives up there,
/// `denier` finds no solution, and `picky` refuses; one more case has no solution, which `denier` proves.
class HardReportTest : public testing::Test {
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
                  {{liar, {.error = 1e-12}},
                   {shy, {.claim = Claim::kIterationLimit, .error = kNan}},
                   {denier, {.claim = Claim::kUnsolvable, .error = kNan, .proves_unsolvable = true}}},
                  0, "", "lcp");
    made_.problem("paper/monotone/exp1", 0, {{good, {}}});
  }

  static constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

  HardOutcome outcome(const report::HardStudy& study, const Summary& summary, const std::string& set,
                      const std::string& solver) const {
    for (const report::HardCaseRow& row : study.rows) {
      if (summary.sets[row.set].name != set) continue;
      for (std::size_t column = 0; column < study.solvers.size(); ++column) {
        if (summary.solvers[study.solvers[column]].text() == solver) return row.cells[column].outcome;
      }
    }
    ADD_FAILURE() << set << ", " << solver;
    return HardOutcome::kNotRun;
  }

  ScratchFolder folder_;
  SyntheticStore made_;
};

TEST_F(HardReportTest, EachAnswerIsCalledWhatItIs) {
  const Summary summary = summarize(made_.store());
  const report::HardStudy study = report::hard_study(summary);
  const auto is = [&](const std::string& set, const std::string& solver) {
    return outcome(study, summary, set, solver);
  };
  EXPECT_EQ(is("hard/contact/stack{ratio=30}", "good"), HardOutcome::kSolved);
  EXPECT_EQ(is("hard/contact/stack{ratio=30}", "liar"), HardOutcome::kFalseClaim);
  EXPECT_EQ(is("hard/contact/stack{ratio=30}", "shy"), HardOutcome::kMissed);
  EXPECT_EQ(is("hard/contact/stack{ratio=30}", "denier"), HardOutcome::kWronglyUnsolvable);
  EXPECT_EQ(is("hard/contact/stack{ratio=30}", "picky"), HardOutcome::kRefused);
  EXPECT_EQ(is("hard/ray/infeasible", "good"), HardOutcome::kNotRun);
  EXPECT_EQ(is("hard/ray/infeasible", "liar"), HardOutcome::kFalseClaim);
  EXPECT_EQ(is("hard/ray/infeasible", "shy"), HardOutcome::kGaveUpUnsolvable);
  EXPECT_EQ(is("hard/ray/infeasible", "denier"), HardOutcome::kRightlyUnsolvable);
}

TEST_F(HardReportTest, ADialIsWhatVariesAlone) {
  const Summary summary = summarize(made_.store());
  const report::HardStudy study = report::hard_study(summary);
  ASSERT_EQ(study.dials.size(), 1U);
  EXPECT_EQ(study.dials[0].dial, "ratio");
  EXPECT_EQ(study.dials[0].values, (std::vector<std::string>{"5", "20", "30"}));
}

TEST_F(HardReportTest, TablesSayWhereAndHowEachBreaks) {
  const Summary summary = summarize(made_.store());
  const auto tables = report::hard_tables(summary, report::hard_study(summary));
  std::map<std::string, std::string> breaks;
  for (const auto& record : tables["hard_dials"]) {
    breaks[record["solver"].get<std::string>()] =
        record["right"].get<std::string>() + " | " + record["not_right"].get<std::string>() + " | " +
        record["refused"].get<std::string>() + " | " + record["worst"].get<std::string>();
  }
  EXPECT_EQ(breaks["good"], "5 20 30 |  |  | solved");
  EXPECT_EQ(breaks["liar"], "5 20 | 30 |  | false_claim");
  EXPECT_EQ(breaks["shy"], "5 20 | 30 |  | missed");
  EXPECT_EQ(breaks["denier"], "5 20 | 30 |  | wrongly_unsolvable");
  EXPECT_EQ(breaks["picky"], " |  | 5 20 30 | refused");
  EXPECT_EQ(tables["hard_cases"].size(), 4U * 5U + 3U);
}

TEST_F(HardReportTest, ThePageShowsThemInTheirOwnSectionOnly) {
  write_report(made_.store(), folder_ / "out");
  std::ostringstream page;
  page << std::ifstream(folder_ / "out/report.html").rdbuf();
  const std::string text = page.str();
  const std::size_t section = text.find("<section id=\"hard\">");
  ASSERT_NE(section, std::string::npos);
  EXPECT_NE(text.find("<a href=\"#hard\">"), std::string::npos);
  EXPECT_GT(text.find("hard/contact/stack{ratio=30}"), section);
  EXPECT_NE(text.find("<span class=\"bad\">✗</span>", section), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/tables/hard_cases.csv"));
}

TEST(HardReportAloneTest, AStoreOfHardCasesAloneRecommendsNothingAndSaysWhy) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "hard.db");
  const auto solver = made.solver("lemke");
  for (const char* name : {"hard/contact/stack", "hard/ray/infeasible"}) made.problem(name, 0, {{solver, {}}});
  write_report(made.store(), folder / "out");
  std::ostringstream page;
  page << std::ifstream(folder / "out/report.html").rdbuf();
  EXPECT_NE(page.str().find("This store holds 2 hard cases"), std::string::npos);
  EXPECT_NE(page.str().find("they show where a solver breaks, not how often"), std::string::npos);
  for (const char* empty :
       {"<table class=\"decision\">", "#speed-error", "\"sets\"", "\"comparison\"", "Random problems"}) {
    EXPECT_EQ(page.str().find(empty), std::string::npos) << empty;
  }
}

TEST_F(HardReportTest, TheTerminalNamesEveryFalseClaim) {
  const std::string text = table_text(summarize(made_.store()), 100);
  EXPECT_NE(text.find("  liar: contact/stack{ratio=30,order=growing}, contact/stack{ratio=30}, ray/infeasible\n"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("hard/contact/stack"), std::string::npos);
}

TEST(HardReportEmptyTest, AStoreWithoutHardCasesHasNoSection) {
  EXPECT_EQ(report::hard_section(report::Report{}), "");
  EXPECT_EQ(report::hard_text(Summary{}, 100), "");
}

}  // namespace
}  // namespace lcpbench
