// The paper's study: intervals, grids, and the tables as their queries give them.

#include <cmath>
#include <cstdlib>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "study/report/report.h"
#include "study/report/sql_functions.h"
#include "tests/report/paper_support.h"
#include "tests/support/program_run.h"
#include "tests/support/solvability.h"
#include "tests/support/study_support.h"

namespace lcpbench::paper_tables_test {
namespace {

using Json = nlohmann::ordered_json;

/// The first row with these members.
Json row_with(const Json& rows, const Json& members) {
  for (const Json& row : rows) {
    bool fits = true;
    for (const auto& [name, value] : members.items()) fits = fits && row.at(name) == value;
    if (fits) return row;
  }
  ADD_FAILURE() << "no row with " << members;
  return Json::object();
}

// --- statistics ---

TEST(PaperSolvabilityTest, WendelsCountsAndTheGeneratorsAverage) {
  EXPECT_DOUBLE_EQ(paper::wendel(3, 3), 1);      // no more half-spaces than dimensions: always a common point
  EXPECT_DOUBLE_EQ(paper::wendel(3, 2), 0.75);   // three half-planes
  EXPECT_DOUBLE_EQ(paper::wendel(4, 1), 0.125);  // four signs alike
  EXPECT_DOUBLE_EQ(paper::solvable_chance(20, 6, 6), 1);
  EXPECT_NEAR(paper::solvable_share_of_exp3(), 0.8492, 5e-5);
  EXPECT_GT(paper::solvable_share_of_exp4(), paper::solvable_share_of_exp3());
  for (const double share : {paper::solvable_share_of_exp3(), paper::solvable_share_of_exp4()}) {
    EXPECT_NE(paper::kQueries.find(fmt::format("THEN {:.12f}", share)), std::string_view::npos) << share;
  }
}

TEST(PaperCellsTest, NamesOfSetsAndSolversAreTakenApart) {
  MadeSummary made;
  made.single("paper/copositive/exp5-1e8{redundancy=combination,edges=per_contact}", "lemke", "cap=3n", {true});
  made.single("paper/monotone/exp3", "regularized", "solver=primal_dual{eps=1e-8}", {true});
  made.single("paper/monotone/exp3", "regularized", "test=tried", {true});
  made.single("paper/monotone/exp7", "lemke", "", {true});
  made.single("paper/monotone/exp2", "bullet_lemke", "", {true});
  made.single("paper/monotone/exp3", "regularized", "solver=lemke{cap=3n}", {true});
  made.swept("paper/monotone/exp1", "lemke", "paper{cap=3n}", "zero_tolerance=1e-3,cap=3n", {});
  made.swept("paper/monotone/exp1", "lemke", "fine", "zero_tolerance=1e-5", {});
  const Json rows = ask(made.summary, "SELECT * FROM paper_cells");
  ASSERT_EQ(rows.size(), 7U) << "there is no Experiment 7";
  const auto expect = [&](std::size_t row, const Json& members) {
    for (const auto& [name, value] : members.items()) EXPECT_EQ(rows[row].at(name), value) << row << " " << name;
  };
  expect(0, {{"kind", "copositive"},
             {"experiment", "exp5-1e8"},
             {"redundancy", "combination"},
             {"other_readings", "edges=per_contact"},
             {"paper_solver", "Lemke"},
             {"wrapped", ""}});
  expect(1, {{"redundancy", ""},
             {"reading", "multiple"},
             {"other_readings", ""},
             {"paper_solver", "IP"},
             {"wrapped", "primal_dual{eps=1e-8}"}});
  expect(2, {{"paper_solver", "Lemke"}, {"wrapped", "lemke"}});
  expect(3, {{"paper_solver", nullptr}, {"redundancy", "multiple"}});
  expect(4, {{"wrapped", "lemke{cap=3n}"}});
  expect(5, {{"label", "lemke{cap=3n}"}, {"grid", "paper"}, {"zero_tolerance", 1e-3}});
  expect(6, {{"label", "lemke (sweep fine)"}, {"base", "lemke"}, {"grid", "fine"}});
  EXPECT_TRUE(rows[5]["pivot_tolerance"].is_number()) << "a default counts";
}

TEST(PaperTablesTest, BestIsChosenOnEvenTrialsAndReportedOnOddOnes) {
  MadeSummary made;
  made.grid("paper/monotone/exp1", "lemke", {.criterion = 1800}, {.criterion = 1800}, "paper", 2);
  Cell& lucky = made.summary.cells[1];
  lucky.halves[0].criterion = 1000;
  lucky.halves[1].criterion = 700;
  const Json row = row_with(rows_of(made.summary, "paper-IV.1"), {{"solver", "lemke"}, {"solved_by", "criterion"}});
  EXPECT_EQ(row["held_out"], 0.7);
  EXPECT_EQ(row["best_settings"], "tolerance=0") << "the first of equals over all trials";
  EXPECT_DOUBLE_EQ(row["best_low"], wilson(1800, 2000).low);
}

TEST(PaperTablesTest, SpreadsPoolAllParameterisations) {
  MadeSummary made;
  const std::vector<std::vector<double>> parts{{1, 2, 4}, {8}, {}, {3, 9, 9, 10}};
  std::vector<double> whole;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    made.swept("paper/monotone/exp6-1e5", "lemke", "paper", "a=" + std::to_string(i), {});
    made.summary.cells.back().all_time = spread(parts[i]);
    whole.insert(whole.end(), parts[i].begin(), parts[i].end());
  }
  const Json row =
      row_with(rows_of(made.summary, "paper-measurements"), {{"quantity", "time_all"}, {"solved_by", "criterion"}});
  const Spread expected = spread(whole);
  EXPECT_EQ(row["all.n"], expected.count);
  EXPECT_NEAR(row["all.mean"].get<double>(), expected.mean, 1e-14);
  EXPECT_NEAR(row["all.sigma"].get<double>(), expected.sigma, 1e-14);
  EXPECT_EQ(row["all.max"], expected.max);
  EXPECT_DOUBLE_EQ(row["all.problems"].get<double>(), 8.0 / 3);
  EXPECT_EQ(row["best.n"], 1000);
}

// --- tables ---

TEST(PublishedTest, RatesAreOrderedAndComplete) {
  int rates = 0;
  int measurements = 0;
  const Json published = ask(Summary{}, "SELECT * FROM published");
  for (const Json& row : published) {
    const auto number = [&row](const char* name) { return row[name].is_null() ? kNoNumber : row[name].get<double>(); };
    if (row["quantity"] == "rate") ++rates;
    if (!std::isnan(number("worst"))) {
      EXPECT_LE(number("worst"), number("average")) << row;
      EXPECT_LE(number("average"), number("best")) << row;
      EXPECT_LE(number("best"), 1) << row;
    }
    if (std::isnan(number("best_mean"))) continue;
    ++measurements;
    EXPECT_LE(number("best_mean"), number("best_max")) << row;
    if (!std::isnan(number("all_mean"))) {
      EXPECT_LE(number("all_mean"), number("all_max")) << row;
    }
    if (row["quantity"] == "violation") {
      EXPECT_LE(number("best_max"), 1e-3) << "the criterion allows no more";
    }
  }
  EXPECT_EQ(rates, 3 * 10 + 2 * 10 + 1);
  EXPECT_EQ(measurements, 18 + 12 + 9 + 6);
}

TEST(PaperTablesTest, AnswersThatAreNotClaimedCountApart) {
  MadeSummary made;
  const MadeCell silent{.criterion = 1000, .unclaimed = 600, .solved = 1500};
  made.grid("paper/copositive/exp1", "lemke", silent, silent, "paper{cap=3n}");
  const Json rows = rows_of(made.summary, "paper-IV.2");
  const auto best = [&rows](const char* count) {
    return row_with(rows, {{"solver", "lemke{cap=3n}"}, {"solved_by", count}})["best"].get<double>();
  };
  EXPECT_DOUBLE_EQ(best("criterion"), 0.5);
  EXPECT_DOUBLE_EQ(best("criterion_any"), 0.8);
  EXPECT_DOUBLE_EQ(best("verdict"), 0.75);
}

/// Provably unsolvable problems count against the paper's rate and not against ours.
TEST(PaperTablesTest, UnsolvableProblemsLowerTheCriterionOnly) {
  MadeSummary made;
  const MadeCell cell{.criterion = 1400, .solved = 1600, .unsolvable = 400};
  made.grid("paper/monotone/exp3", "lemke", cell, cell);
  const Json rows = rows_of(made.summary, "paper-IV.1");
  EXPECT_DOUBLE_EQ(row_with(rows, {{"experiment", "3"}, {"solved_by", "criterion"}})["average"], 0.7);
  EXPECT_DOUBLE_EQ(row_with(rows, {{"experiment", "3"}, {"solved_by", "verdict"}})["average"], 1);
}

/// Every published figure of Tables IV.1 to IV.6, and ours at its side: what the terminal and the page show.
TEST(PrintedTablesTest, EachExperimentIsARowWithThePublishedFigureAndOurs) {
  MadeSummary made;
  made.grid("paper/monotone/exp2", "lemke", {.criterion = 1600}, {.criterion = 2000}, "paper{cap=3n}");
  made.grid("paper/monotone/exp2", "lemke", {.trials = 100, .criterion = 0, .solved = 0},
            {.trials = 100, .criterion = 0, .solved = 0});
  made.grid("paper/monotone/exp2{redundancy=combination}", "lemke", {.criterion = 1000}, {.criterion = 1400});
  made.flat("paper/monotone/exp6-1e5", "regularized", 1, "paper{test=tried}", 2e-3);
  made.flat("paper/monotone/exp6-1e5", "regularized", 0.5, "paper", 1);
  std::map<std::string, Json> tables;
  for (const char* number : {"IV.1", "IV.2", "IV.3", "IV.4", "IV.5", "IV.6"}) {
    tables[number] = rows_of(made.summary, std::string("paper-table-") + number);
  }
  const auto e = [](std::string text) { return std::regex_replace(text, std::regex("e-0"), "e-"); };
  std::size_t figures = 0;
  for (const Json& published : ask(Summary{}, "SELECT *, replace(title, ' at ', ' ') AS exp FROM published")) {
    const Json& rows = tables.at(published["table"]);
    const auto number = [&published](const char* name) { return published[name].get<double>(); };
    const auto share = [&](const char* name) {
      return published[name].is_null() ? "-" : fmt::format("{:.4g}", 100 * number(name));
    };
    if (published["quantity"] == "rate") {
      const Json row = row_with(rows, {{"exp", published["exp"]}});
      EXPECT_EQ(row[published["solver"].get<std::string>() + "_published"],
                share("worst") + "/" + share("average") + "/" + share("best"));
      ++figures;
    }
    for (const std::string of : {"best", "all"}) {
      if (published[of + "_mean"].is_null()) continue;
      const char* const problems = published["quantity"] == "time_all" ? "all" : "solved";
      Json members{{"solver", published["solver"]}, {"exp", published["exp"]}, {"parameters", of}};
      if (published["quantity"] != "violation") members["problems"] = problems;
      EXPECT_EQ(row_with(rows, members)["published"],
                e(fmt::format("{:g} ({:g}) {:g}", number((of + "_mean").c_str()), number((of + "_sigma").c_str()),
                              number((of + "_max").c_str()))));
      ++figures;
    }
  }
  EXPECT_EQ(figures, 51U + 2 * 45 - 3);
  EXPECT_EQ(tables["IV.1"].size(), 10U + 1) << "one more for the other reading of Experiment 2";
  EXPECT_EQ(row_with(tables["IV.1"], {{"exp", "2"}})["Lemke_ours"], "80/90/100") << "of the sweep with most trials";
  EXPECT_EQ(row_with(tables["IV.1"], {{"exp", "2 c"}})["Lemke_ours"], "50/60/70");
  EXPECT_EQ(row_with(tables["IV.1"], {{"exp", "6 1e5"}})["Lemke_ours"], "100/100/100") << "by the paper's own test";
  EXPECT_TRUE(row_with(tables["IV.1"], {{"exp", "1"}})["Lemke_ours"].is_null());
  EXPECT_EQ(row_with(tables["IV.3"], {{"exp", "6 1e5"}, {"parameters", "all"}})["ours"], "0.002 (0.001) 0.02");
  EXPECT_EQ(row_with(tables["IV.1"], {{"exp", "2"}})["our_trials"], 2000);
  EXPECT_TRUE(row_with(tables["IV.1"], {{"exp", "1"}})["our_trials"].is_null());
  EXPECT_GT(row_with(tables["IV.3"], {{"exp", "6 1e5"}, {"parameters", "all"}})["our_answers"], 0);
}

TEST(PaperTablesTest, RefusalsStandInsteadOfShares) {
  MadeSummary made;
  const MadeCell path{.criterion = 1500, .solved = 1500, .refused = 500};
  made.grid("paper/monotone/exp1", "path", path, path);
  const Json row = row_with(rows_of(made.summary, "paper-IV.1"), {{"solver", "path"}, {"solved_by", "verdict"}});
  EXPECT_TRUE(row["best"].is_null());
  EXPECT_EQ(row["refused"], "refused 500 of 2000: no licence for this size");
}

TEST(ToleranceMapTest, CellsStandAtTheirTolerancesAlsoOfAWrappedSolver) {
  MadeSummary made;
  for (const char* pivot : {"1e-4", "1e-20"}) {
    for (const char* zero : {"1e-12", "1e-6", "1e-8"}) {
      MadeCell cell;
      cell.solved = (pivot[3] == '4' ? 1000 : 0) + (zero[3] == '6' ? 500 : 100);
      made.swept("paper/monotone/exp6-1e5", "regularized", "paper",
                 std::string("solver=lemke{pivot_tolerance=") + pivot + ",zero_tolerance=" + zero + "}", cell);
    }
  }
  const Json rows = rows_of(made.summary, "tolerance-map");
  ASSERT_EQ(rows.size(), 6U);
  EXPECT_DOUBLE_EQ(row_with(rows, {{"pivot_tolerance", 1e-4}, {"zero_tolerance", 1e-6}})["verdict.share"], 0.75);
  EXPECT_DOUBLE_EQ(row_with(rows, {{"pivot_tolerance", 1e-20}, {"zero_tolerance", 1e-12}})["verdict.share"], 0.05);
}

TEST(ReadingsTest, OptionsAreComparedWithTheSameSetAtItsDefaults) {
  MadeSummary made;
  made.flat("paper/monotone/exp2", "lemke", 0.9);
  made.flat("paper/monotone/exp2{placement=random}", "lemke", 0.7);
  made.flat("paper/copositive/exp2{placement=random}", "lemke", 0.5);
  const Json rows = rows_of(made.summary, "readings");
  ASSERT_EQ(rows.size(), 12U);  // one per count and share; the copositive set has nothing to be compared with
  const Json row = row_with(rows, {{"solved_by", "criterion"}, {"statistic", "average"}});
  EXPECT_NEAR(row["difference"], -0.2, 1e-12);
  EXPECT_LT(row["difference_high"].get<double>(), -0.15);
}

TEST(ReadingsTest, WhatIsNotReproducedFollowsFromTheNumbers) {
  MadeSummary made;
  const auto count = [](double share) { return static_cast<std::int64_t>(std::lround(2000 * share)); };
  MadeCell worst;
  MadeCell best;
  worst.criterion = count(0.9271);
  best.criterion = 2000;
  made.grid("paper/monotone/exp1", "lemke", worst, best);
  worst.criterion = count(0.50);
  made.grid("paper/monotone/exp2", "lemke", worst, best);
  const Json rows = rows_of(made.summary, "reproduction");
  ASSERT_EQ(rows.size(), 6U);
  const auto result = [&rows](const char* set, const char* statistic) {
    return row_with(rows, {{"set", set}, {"statistic", statistic}})["result"];
  };
  EXPECT_EQ(result("paper/monotone/exp1", "worst"), "reproduced");  // the published number itself
  EXPECT_EQ(result("paper/monotone/exp1", "best"), "reproduced");
  EXPECT_EQ(result("paper/monotone/exp2", "worst"), "too few trials");  // 50 % of 2000, +- 2.3 points
  EXPECT_EQ(result("paper/monotone/exp2", "best"), "reproduced");
}

TEST(ReadingsTest, FewTrialsAndRefusalsReproduceNothing) {
  const auto agreement = [](const MadeCell& cell) {
    MadeSummary made;
    made.grid("paper/monotone/exp1", "path", cell, cell);
    return row_with(rows_of(made.summary, "reproduction"), {{"statistic", "worst"}})["result"];
  };
  EXPECT_EQ(agreement({.trials = 20, .criterion = 20, .solved = 20}), "too few trials");
  EXPECT_EQ(agreement({.trials = 20000, .criterion = 19500, .solved = 19500}), "reproduced");
  EXPECT_EQ(agreement({.trials = 20000, .criterion = 10000, .solved = 10000}), "differs");
  EXPECT_EQ(agreement({.trials = 20000, .criterion = 19500, .solved = 19500, .refused = 300}), "refused");
}

// --- a store of a real run ---

/// Every set that the tables distinguish, few problems, all native solvers that have a grid.
class PaperStoreTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new ScratchFolder;
    const std::string sets =
        " --set paper/monotone/exp1 --set paper/monotone/exp3 --set 'paper/monotone/exp5-1e8{redundancy=combination}'"
        " --set paper/monotone/exp5-1e8 --set paper/monotone/exp6-1e8";
    const std::string solvers = " --solver lemke --solver regularized --solver 'regularized{test=tried}'";
    const std::string command = std::string("'") + LCPBENCH_PROGRAM + "' run --sweep paper" + sets + solvers +
                                " --trials 20 --jobs 1 --store '" + file().string() + "' >/dev/null 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
  }
  static void TearDownTestSuite() { delete folder_; }

  static std::filesystem::path file() { return *folder_ / "paper.db"; }
  static std::filesystem::path path(const char* name) { return *folder_ / name; }

  static ScratchFolder* folder_;
};
ScratchFolder* PaperStoreTest::folder_ = nullptr;

/// The counts of the tables are those of the view `judged_cells`.
TEST_F(PaperStoreTest, TheRatesAreThoseOfTheStoresRows) {
  Store store = Store::open_for_reading(file());
  report::fill_tables(store, report::read_report(store));
  const auto ask = [&store](const std::string& sql) {
    return Json(report::records_of(report::run_query(store.database(), "test", sql)));
  };
  const Json counted = ask(
      "WITH counts AS (SELECT s.name AS \"set\", v.name AS solver, v.sweep, j.cell, COUNT(*) AS trials, "
      "SUM(j.claim = 'solved' AND r.criterion = 1) AS criterion FROM judged_cells j JOIN verdicts r USING (problem_id, "
      "solver_id, part) JOIN sets s ON s.id = j.set_id JOIN solvers v ON v.id = j.solver_id WHERE v.sweep <> '' "
      "GROUP BY j.set_id, j.solver_id, j.cell) SELECT \"set\", solver || substr(sweep, 6) AS solver, COUNT(*) AS "
      "cells, "
      "MIN(1.0 * criterion / trials) AS worst, MAX(1.0 * criterion / trials) AS best FROM counts GROUP BY 1, 2");
  const Json rates = ask("SELECT * FROM paper_rates WHERE solved_by = 'criterion'");
  ASSERT_EQ(counted.size(), 15U);
  ASSERT_EQ(rates.size(), counted.size());
  for (const Json& row : counted) {
    const Json rate = row_with(rates, {{"set", row["set"]}, {"solver", row["solver"]}});
    EXPECT_EQ(rate["parameterisations"], row["cells"]);
    EXPECT_DOUBLE_EQ(rate["worst.share"], row["worst"]);
    EXPECT_DOUBLE_EQ(rate["best.share"], row["best"]);
  }
}

/// The end of `run paper`: the tables that the store has figures for, on a terminal of 100 characters.
TEST_F(PaperStoreTest, TheTerminalHasThePapersTables) {
  Store store = Store::open_for_reading(file());
  report::fill_tables(store, report::read_report(store));
  const std::string text = paper_text(store, 100);
  EXPECT_NE(text.find("\nTable IV.1: "), std::string::npos) << text;
  EXPECT_NE(text.find("\nTable IV.3: "), std::string::npos) << text;
  EXPECT_NE(text.find("\nTable IV.5: "), std::string::npos) << text;
  EXPECT_EQ(text.find("\nTable IV.2: "), std::string::npos) << "nothing with friction was run";
  EXPECT_TRUE(std::regex_search(text, std::regex("\n1 +92\\.71/97\\.59/100 +[0-9.]+/[0-9.]+/[0-9.]+ +97\\.48/")))
      << text;
  EXPECT_TRUE(std::regex_search(text, std::regex("\nexp +Lemke published +Lemke ours +PATH published"))) << text;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(character_count(line), 100U) << line;
}

TEST_F(PaperStoreTest, TheReportHasTablesAndClaimsAndRegeneratingGivesTheSameBytes) {
  Store store = Store::open_for_reading(file());
  write_report(store, path("first"));
  write_report(store, path("second"));
  const std::string first = read_file(path("first") / "report.json");
  EXPECT_EQ(first, read_file(path("second") / "report.json"));
  const Json document = Json::parse(first);
  EXPECT_EQ(document["paper"]["claims"].size(), 16U);
  EXPECT_EQ(document["paper"]["tables"].size(), 15U) << document["paper"]["tables"];
  EXPECT_NE(read_file(path("first") / "tables/paper-IV.1.csv").find("regularized{test=tried}"), std::string::npos);
}

}  // namespace
}  // namespace lcpbench::paper_tables_test
