#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>

#include <gtest/gtest.h>
#include <libxml/parser.h>

#include "study/paper/intervals.h"
#include "study/paper/published.h"
#include "study/paper/readings.h"
#include "study/paper/tables.h"
#include "study/report/paper.h"
#include "study/report/report.h"
#include "tests/report/paper_support.h"
#include "tests/support/study_support.h"

namespace lcpbench {
namespace {

using paper::Kind;
using paper::Measure;
using Json = nlohmann::ordered_json;

const Json& record(const paper::Table& table, const std::string& experiment, const std::string& solver,
                   const std::string& redundancy) {
  for (const Json& row : table.records) {
    if (row["experiment"] == experiment && row["solver"] == solver && row["redundancy"] == redundancy) return row;
  }
  static const Json none;
  ADD_FAILURE() << experiment << " " << solver << " " << redundancy << ": no record";
  return none;
}

/// Text of the row that begins with these labels, in the column of that name.
std::string entry(const paper::Layout& layout, const std::vector<std::string>& labels, const std::string& column) {
  const auto at = std::find(layout.columns.begin(), layout.columns.end(), column);
  EXPECT_NE(at, layout.columns.end()) << column;
  for (const auto& row : layout.rows) {
    bool fits = true;
    for (std::size_t i = 0; i < labels.size(); ++i) fits = fits && row[i].text == labels[i];
    if (fits) return row[static_cast<std::size_t>(at - layout.columns.begin())].text;
  }
  ADD_FAILURE() << "no row " << labels.front();
  return "";
}

// --- statistics ---

TEST(PaperIntervalsTest, ProportionGivesWilsonsInterval) {
  for (const auto& [successes, trials] : {std::pair{0, 10}, {3, 10}, {10, 10}, {1999, 2000}}) {
    const Interval ours = paper::Proportion{double(successes), double(trials)}.interval();
    EXPECT_NEAR(ours.low, wilson(successes, trials).low, 1e-12);
    EXPECT_NEAR(ours.high, wilson(successes, trials).high, 1e-12);
  }
  EXPECT_TRUE(std::isnan(paper::Proportion{}.interval().low));
}

/// Newcombe 1998, Statistics in Medicine 17:873, Table II, method 10: 56/70 against 48/80 and others.
TEST(PaperIntervalsTest, DifferenceGivesNewcombesInterval) {
  const auto check = [](double a, double m, double b, double n, double low, double high) {
    const Interval interval = paper::difference({a, m}, {b, n}).interval();
    EXPECT_NEAR(interval.low, low, 5e-5);
    EXPECT_NEAR(interval.high, high, 5e-5);
  };
  check(56, 70, 48, 80, 0.0524, 0.3339);
  check(9, 10, 3, 10, 0.1705, 0.8090);
  check(10, 10, 0, 20, 0.6791, 1.0);
  check(0, 10, 0, 20, -0.1611, 0.2775);
}

TEST(PaperIntervalsTest, NormalQuantilesAreThoseOfTheTables) {
  EXPECT_NEAR(paper::normal_quantile(0.05), 1.959963984540054, 1e-12);
  EXPECT_NEAR(paper::normal_quantile(0.01), 2.5758293035489, 1e-11);
}

TEST(PaperIntervalsTest, PoolingPartsIsPoolingTheirValues) {
  const std::vector<double> first{1, 2, 4};
  const std::vector<double> second{8};
  const std::vector<double> third{3, 9, 9, 10};
  std::vector<double> whole = first;
  whole.insert(whole.end(), second.begin(), second.end());
  whole.insert(whole.end(), third.begin(), third.end());
  const Spread pooled = paper::pooled({spread(first), spread(second), spread({}), spread(third)});
  const Spread expected = spread(whole);
  EXPECT_EQ(pooled.count, expected.count);
  EXPECT_NEAR(pooled.mean, expected.mean, 1e-14);
  EXPECT_NEAR(pooled.sigma, expected.sigma, 1e-14);
  EXPECT_EQ(pooled.max, expected.max);
}

TEST(PaperSolvabilityTest, WendelsCountsAndTheGeneratorsAverage) {
  EXPECT_DOUBLE_EQ(paper::wendel(3, 3), 1);      // no more half-spaces than dimensions: always a common point
  EXPECT_DOUBLE_EQ(paper::wendel(3, 2), 0.75);   // three half-planes
  EXPECT_DOUBLE_EQ(paper::wendel(4, 1), 0.125);  // four signs alike
  EXPECT_DOUBLE_EQ(paper::solvable_chance(20, 6, 6), 1);
  EXPECT_NEAR(paper::solvable_share_of_exp3(), 0.8492, 5e-5);
  EXPECT_GT(paper::solvable_share_of_exp4(), paper::solvable_share_of_exp3());
}

// --- published numbers ---

TEST(PublishedTest, RatesAreOrderedAndComplete) {
  int rates = 0;
  for (const Kind kind : paper::kKinds) {
    for (const paper::Experiment& experiment : paper::experiments()) {
      for (const paper::Family family : paper::kFamilies) {
        const auto rate = paper::published_rate(kind, experiment.name, family);
        if (!rate) continue;
        ++rates;
        EXPECT_LE(rate->best, 1);
        EXPECT_FALSE(rate->average > rate->best);
        EXPECT_FALSE(rate->worst > rate->average);
      }
    }
  }
  EXPECT_EQ(rates, 30 + 20 + 1);  // three solvers without friction, two with, and the raised ceilings
}

/// No mean exceeds its maximum, and no solved problem violates by 1e-3 m/s or more: slips of copying would.
TEST(PublishedTest, MeasurementsAreConsistent) {
  int spreads = 0;
  const auto check = [&spreads](const std::optional<paper::PublishedMeasurement>& measurement, double limit) {
    if (!measurement) return;
    for (const paper::PublishedSpread& spread : {measurement->best, measurement->all}) {
      if (std::isnan(spread.mean)) continue;
      ++spreads;
      EXPECT_LT(spread.mean, spread.max);
      EXPECT_LT(spread.sigma, spread.max);
      EXPECT_LT(spread.max, limit);
    }
  };
  for (const Kind kind : paper::kKinds) {
    for (const paper::Experiment& experiment : paper::experiments()) {
      for (const paper::Family family : paper::kFamilies) {
        check(paper::published_time(kind, experiment.name, family, true), 1e4);
        check(paper::published_time(kind, experiment.name, family, false), 1e4);
        check(paper::published_violation(kind, experiment.name, family), 1e-3);
      }
    }
  }
  EXPECT_EQ(spreads, 60 + 27);
}

// --- tables ---

TEST(PaperGridsTest, NamesOfSetsAndSolversAreTakenApart) {
  const auto set = paper::paper_set("paper/copositive/exp5-1e8{redundancy=combination,edges=per_contact}");
  ASSERT_TRUE(set);
  EXPECT_EQ(set->kind, Kind::kCopositive);
  EXPECT_EQ(set->experiment->name, "exp5-1e8");
  EXPECT_EQ(set->redundancy(), "combination");
  EXPECT_EQ(set->other_readings(), "edges=per_contact");
  EXPECT_FALSE(paper::paper_set("rigid/exp1"));
  EXPECT_FALSE(paper::paper_set("paper/monotone/exp7"));
  EXPECT_EQ(paper::family_of("lemke{cap=3n}"), paper::Family::kLemke);
  EXPECT_EQ(paper::family_of("regularized{test=tried}"), paper::Family::kLemke);
  EXPECT_EQ(paper::family_of("regularized{solver=primal_dual{eps=1e-8}}"), paper::Family::kInteriorPoint);
  EXPECT_FALSE(paper::family_of("bullet_lemke"));
  EXPECT_EQ(paper::wrapped_solver("regularized{solver=lemke{cap=3n}}"), "lemke{cap=3n}");
  EXPECT_EQ(paper::wrapped_solver("lemke"), "");
}

TEST(PaperTablesTest, WorstAverageBestStandBesideThePublishedOnes) {
  MadeSummary made;
  made.grid("paper/monotone/exp2", "lemke", {.criterion = 1600, .solved = 1500}, {.criterion = 2000, .solved = 1900});
  made.grid("paper/monotone/exp2{redundancy=combination}", "lemke", {.criterion = 1000, .solved = 900},
            {.criterion = 1400, .solved = 1000});
  const paper::Table table = rates_table(made.summary, paper::grids(made.summary), Kind::kMonotone);
  const paper::Layout& layout = table.layouts.front();
  EXPECT_EQ(entry(layout, {"2", "multiple", "paper’s criterion"}, "Lemke, published"), "79.73 / 93.13 / 100");
  EXPECT_EQ(entry(layout, {"2", "multiple", "paper’s criterion"}, "`lemke`"), "80.00 / 90.00 / 100");
  EXPECT_EQ(entry(layout, {"2", "multiple", "our verdict"}, "`lemke`"), "75.00 / 85.00 / 95.00");
  EXPECT_EQ(entry(layout, {"2", "combination", "paper’s criterion"}, "`lemke`"), "50.00 / 60.00 / 70.00");
  EXPECT_EQ(entry(layout, {"1", "–", "–"}, "`lemke`"), "not run");
  const Json& row = record(table, "exp2", "lemke", "multiple");
  EXPECT_DOUBLE_EQ(row["criterion"]["best"]["low"].get<double>(), wilson(2000, 2000).low);
  EXPECT_DOUBLE_EQ(row["verdict"]["worst"]["high"].get<double>(), wilson(1500, 2000).high);
  EXPECT_DOUBLE_EQ(row["published"]["worst"].get<double>(), 0.7973);
  EXPECT_EQ(row["criterion"]["best_settings"], "tolerance=2");
}

TEST(PaperTablesTest, AnswersThatAreNotClaimedCountApart) {
  MadeSummary made;
  const MadeCell silent{.criterion = 1000, .unclaimed = 600, .solved = 1500};
  made.grid("paper/copositive/exp1", "lemke", silent, silent, "paper{rules=2012}");
  made.grid("paper/copositive/exp6-1e5", "regularized", silent, silent);
  const auto grids = paper::grids(made.summary);
  const paper::Table rates = rates_table(made.summary, grids, Kind::kCopositive);
  const std::string label = "`lemke{rules=2012}`";
  EXPECT_EQ(entry(rates.layouts[0], {"1", "–", "paper’s criterion"}, label), "50.00 / 50.00 / 50.00");
  EXPECT_EQ(entry(rates.layouts[0], {"1", "–", "criterion, any answer"}, label), "80.00 / 80.00 / 80.00");
  EXPECT_EQ(entry(rates.layouts[0], {"1", "–", "our verdict"}, label), "75.00 / 75.00 / 75.00");
  EXPECT_DOUBLE_EQ(record(rates, "exp1", "lemke{rules=2012}", "–")["criterion_any"]["best"]["share"].get<double>(),
                   0.8);
  for (const paper::Table& table : {times_table(made.summary, grids, Kind::kCopositive),
                                    violations_table(made.summary, grids, Kind::kCopositive)}) {
    int any = 0;
    for (const auto& row : table.layouts.back().rows) any += row[1].text.ends_with("criterion, any answer") ? 1 : 0;
    EXPECT_GT(any, 0) << table.id;
  }
}

TEST(PaperTablesTest, RulesOf2012AreComparedByAnyAnswerAndTakeNoPartInClaims) {
  MadeSummary made;
  made.flat("paper/monotone/exp1", "lemke", 0.9, "paper{rules=2012}");
  made.flat("paper/monotone/exp2", "lemke", 0.8, "paper{rules=2012}");
  for (Cell& cell : made.summary.cells) cell.criterion_any = cell.trials;
  const auto grids = paper::grids(made.summary);
  EXPECT_TRUE(paper::follows_rules_2012(grids.front().solver));
  EXPECT_FALSE(paper::follows_rules_2012("regularized{solver=lemke{cap=3n}}"));
  EXPECT_TRUE(paper::follows_rules_2012("regularized{solver=lemke{rules=2012}}"));
  for (const paper::Reproduction& row : paper::reproductions(grids)) EXPECT_EQ(row.ours, 1);
  for (const paper::Claim& claim : paper::test_claims(made.summary, grids)) {
    EXPECT_EQ(claim.comparisons.size(), 0U) << claim.id;
  }
}

TEST(PaperTablesTest, PathStandsAsMeasuredApartUntilTheStoreHasIt) {
  MadeSummary made;
  made.flat("paper/monotone/exp1", "lemke", 1);
  const paper::Table apart = rates_table(made.summary, paper::grids(made.summary), Kind::kMonotone);
  EXPECT_EQ(entry(apart.layouts[0], {"1", "–", "paper’s criterion"}, "PATH, ours"), "24.00 / 69.47 / 99.85");
  EXPECT_EQ(entry(apart.layouts[0], {"1", "–", "criterion, any answer"}, "PATH, ours"), "99.95 / 99.95 / 99.95");
  EXPECT_DOUBLE_EQ(record(apart, "exp1", "", "–")["measured_apart"]["criterion"]["worst"].get<double>(), 0.24);
  made.flat("paper/monotone/exp1", "path", 0.5);
  const paper::Table run = rates_table(made.summary, paper::grids(made.summary), Kind::kMonotone);
  EXPECT_EQ(entry(run.layouts[0], {"1", "–", "paper’s criterion"}, "`path`"), "50.00 / 50.00 / 50.00");
}

/// Provably unsolvable problems count against the paper's rate and not against ours.
TEST(PaperTablesTest, UnsolvableProblemsLowerTheCriterionOnly) {
  MadeSummary made;
  const MadeCell cell{.criterion = 1400, .solved = 1600, .unsolvable = 400};
  made.grid("paper/monotone/exp3", "lemke", cell, cell);
  const paper::Table table = rates_table(made.summary, paper::grids(made.summary), Kind::kMonotone);
  EXPECT_EQ(entry(table.layouts.front(), {"3", "–", "paper’s criterion"}, "`lemke`"), "70.00 / 70.00 / 70.00");
  EXPECT_EQ(entry(table.layouts.front(), {"3", "–", "our verdict"}, "`lemke`"), "100 / 100 / 100");
}

TEST(PaperTablesTest, BestIsChosenOnEvenTrialsAndReportedOnOddOnes) {
  MadeSummary made;
  made.grid("paper/monotone/exp1", "lemke", {.criterion = 1800}, {.criterion = 1800}, "paper", 2);
  Cell& lucky = made.summary.cells[1];
  lucky.halves[0].criterion = 1000;
  lucky.halves[1].criterion = 700;
  const auto grids = paper::grids(made.summary);
  const paper::GridRange range = paper::range_of(grids.front(), Measure::kCriterion);
  EXPECT_EQ(range.chosen, &lucky);
  EXPECT_DOUBLE_EQ(range.chosen_even.value(), 1);
  EXPECT_DOUBLE_EQ(range.held_out.value(), 0.7);
  EXPECT_NEAR(range.held_out.interval().low, wilson(700, 1000).low, 1e-12);
}

TEST(PaperTablesTest, SolversThatDidNotRunSaySoWithTheRunsReason) {
  MadeSummary made;
  made.flat("paper/monotone/exp1", "lemke", 1);
  made.summary.runs.push_back({"2026-01-01", Json::parse(R"({"skipped": ["path: libpath50.so was not found"]})")});
  const paper::Table table = rates_table(made.summary, paper::grids(made.summary), Kind::kMonotone);
  const paper::Layout& layout = table.layouts.front();
  const auto path = std::find(layout.columns.begin(), layout.columns.end(), "PATH, ours") - layout.columns.begin();
  EXPECT_EQ(layout.rows.front()[static_cast<std::size_t>(path)].detail,
            "measured separately, 4.7.03; not run: path: libpath50.so was not found");
  EXPECT_EQ(record(table, "exp1", "", "–")["not_run"], "not run: path: libpath50.so was not found");
}

/// A solver nobody had thought of gets its rows in every table from the store alone.
TEST(PaperTablesTest, NewSolversHaveTheirRows) {
  MadeSummary made;
  for (const char* set : {"paper/monotone/exp1", "paper/monotone/exp6-1e5", "paper/copositive/exp6-1e5"}) {
    made.flat(set, "lemke", 1);
    made.flat(set, "brand_new", 0.5, "grid{mode=fast}");
  }
  const auto grids = paper::grids(made.summary);
  const std::string label = "brand_new{mode=fast} (sweep grid)";
  EXPECT_EQ(entry(rates_table(made.summary, grids, Kind::kMonotone).layouts.front(), {"1"}, "`" + label + "`"),
            "50.00 / 50.00 / 50.00");
  const paper::Table times = times_table(made.summary, grids, Kind::kCopositive);
  EXPECT_EQ(entry(times.layouts[0], {"`" + label + "` / `lemke`", "multiple", "all"}, "1e5, all parameters"), "1");
  const paper::Table violations = violations_table(made.summary, grids, Kind::kMonotone);
  EXPECT_EQ(entry(violations.layouts[0], {"`" + label + "`", "multiple, our verdict", "solved"}, "1e5, all parameters"),
            "1e-09 (5e-10) 1e-08");
}

TEST(PaperTablesTest, TimesAreComparedAsRatios) {
  MadeSummary made;
  made.flat("paper/monotone/exp6-1e8", "regularized", 1, "paper{test=tried}", 2e-3);
  made.flat("paper/monotone/exp6-1e8", "regularized", 1, "paper", 4e-3);
  made.flat("paper/monotone/exp6-1e8", "primal_dual", 1, "paper", 1e-1);
  const paper::Table table = times_table(made.summary, paper::grids(made.summary), Kind::kMonotone);
  const paper::Layout& ratios = table.layouts[0];
  const std::vector<std::string> tried{"`primal_dual` / `regularized{test=tried}`"};
  EXPECT_EQ(entry(ratios, {tried[0], "multiple, paper’s criterion", "solved"}, "1e8, best"), "50");
  EXPECT_EQ(entry(ratios, {"`primal_dual` / `regularized`", "multiple, paper’s criterion", "solved"}, "1e8, best"),
            "25");
  EXPECT_EQ(entry(ratios, {tried[0], "published", "solved"}, "1e8, best"), "2.02e+03");  // 0.384 / 1.90e-4
  EXPECT_EQ(entry(ratios, {tried[0], "published", "all"}, "1e8, best"), "1.38e+04");     // 2.59 / 1.88e-4
}

TEST(PaperTablesTest, PublishedTimesStandWithEveryDigit) {
  MadeSummary made;
  made.flat("paper/copositive/exp6-1e5", "regularized", 1);
  const paper::Table table = times_table(made.summary, paper::grids(made.summary), Kind::kCopositive);
  EXPECT_EQ(entry(table.layouts[1], {"Lemke", "published", "solved"}, "1e5, all parameters"), "1.41 (15.212) 1781.61");
  EXPECT_EQ(entry(table.layouts[1], {"PATH", "published", "all"}, "1e10, best"), "0.221 (1.867) 34.32");
}

TEST(PaperTablesTest, SpreadsPoolAllParameterisations) {
  MadeSummary made;
  MadeCell slow;
  slow.time_s = 3e-3;
  made.swept("paper/monotone/exp6-1e5", "lemke", "paper", "a=1", {});
  made.swept("paper/monotone/exp6-1e5", "lemke", "paper", "a=2", slow);
  const auto grids = paper::grids(made.summary);
  const Spread all = paper::over_all(grids.front(), paper::Quantity::kTimeAll, Measure::kCriterion).values;
  EXPECT_EQ(all.count, 4000);
  EXPECT_NEAR(all.mean, 2e-3, 1e-15);
  EXPECT_GT(all.sigma, 1e-3);
  EXPECT_DOUBLE_EQ(all.max, 3e-2);
  EXPECT_EQ(paper::at_best(grids.front(), paper::Quantity::kTimeAll, Measure::kCriterion).values.count, 1000);
  EXPECT_EQ(paper::over_all(grids.front(), paper::Quantity::kTimeAll, Measure::kCriterion).problems, 2000);
}

// --- maps and readings ---

TEST(ToleranceMapTest, FieldsStandAtTheirTolerancesAlsoOfAWrappedSolver) {
  MadeSummary made;
  for (const char* pivot : {"1e-4", "1e-20"}) {
    for (const char* zero : {"1e-12", "1e-6", "1e-8"}) {
      MadeCell cell;
      cell.solved = (pivot[3] == '4' ? 1000 : 0) + (zero[3] == '6' ? 500 : 100);
      made.swept("paper/monotone/exp6-1e5", "regularized", "paper",
                 std::string("solver=lemke{pivot_tolerance=") + pivot + ",zero_tolerance=" + zero + "}", cell);
    }
  }
  const auto grids = paper::grids(made.summary);
  const auto maps = paper::tolerance_maps(made.summary, grids);
  ASSERT_EQ(maps.size(), 1U);
  EXPECT_EQ(maps[0].pivot_tolerances, (std::vector<double>{1e-20, 1e-4}));
  EXPECT_EQ(maps[0].zero_tolerances, (std::vector<double>{1e-12, 1e-8, 1e-6}));
  ASSERT_NE(maps[0].at(1, 2), nullptr);
  EXPECT_EQ(maps[0].at(1, 2)->count(Verdict::kSolved), 1500);
  EXPECT_EQ(maps[0].at(0, 0)->count(Verdict::kSolved), 100);
}

TEST(ReadingsTest, OptionsAreComparedWithTheSameSetAtItsDefaults) {
  MadeSummary made;
  made.flat("paper/monotone/exp2", "lemke", 0.9);
  made.flat("paper/monotone/exp2{placement=random}", "lemke", 0.7);
  made.flat("paper/copositive/exp2{placement=random}", "lemke", 0.5);
  const auto grids = paper::grids(made.summary);
  const auto effects = paper::reading_effects(grids);
  ASSERT_EQ(effects.size(), 3U);  // one per count; the copositive set has nothing to be compared with
  EXPECT_NEAR(effects[0].with.average.value() - effects[0].without.average.value(), -0.2, 1e-12);
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
  const auto rows = paper::reproductions(paper::grids(made.summary));
  ASSERT_EQ(rows.size(), 6U);
  EXPECT_EQ(rows[0].agreement, paper::Agreement::kReproduced);  // Experiment 1, worst: the published number itself
  EXPECT_EQ(rows[2].agreement, paper::Agreement::kReproduced);
  EXPECT_EQ(rows[3].agreement, paper::Agreement::kTooFewTrials);  // Experiment 2, worst: 50 of 2000, +- 2.3 points
  EXPECT_EQ(rows[5].agreement, paper::Agreement::kReproduced);
}

TEST(ReadingsTest, FewTrialsAndRefusalsReproduceNothing) {
  const auto agreement = [](const MadeCell& cell) {
    MadeSummary made;
    made.grid("paper/monotone/exp1", "path", cell, cell);
    return paper::reproductions(paper::grids(made.summary)).at(0).agreement;
  };
  EXPECT_EQ(agreement({.trials = 20, .criterion = 20, .solved = 20}), paper::Agreement::kTooFewTrials);
  EXPECT_EQ(agreement({.trials = 20000, .criterion = 19500, .solved = 19500}), paper::Agreement::kReproduced);
  EXPECT_EQ(agreement({.trials = 20000, .criterion = 10000, .solved = 10000}), paper::Agreement::kDiffers);
  EXPECT_EQ(agreement({.trials = 20000, .criterion = 19500, .solved = 19500, .refused = 300}),
            paper::Agreement::kRefused);
}

TEST(PaperTablesTest, RefusalsStandInsteadOfShares) {
  MadeSummary made;
  const MadeCell path{.criterion = 1500, .solved = 1500, .refused = 500};
  made.grid("paper/monotone/exp1", "path", path, path);
  const paper::Table table = rates_table(made.summary, paper::grids(made.summary), Kind::kMonotone);
  EXPECT_EQ(entry(table.layouts.front(), {"1", "–", "our verdict"}, "`path`"), "refused 500 of 2000");
  EXPECT_EQ(record(table, "exp1", "path", "–")["not_run"], "refused 500 of 2000: no licence for this size");
}

TEST(PaperGridsTest, VersionsAreToldApart) {
  MadeSummary made;
  made.flat("paper/monotone/exp1", "lemke", 1);
  made.version = "2.0";
  made.flat("paper/monotone/exp1", "lemke", 0.5);
  const auto grids = paper::grids(made.summary);
  ASSERT_EQ(grids.size(), 2U);
  EXPECT_EQ(grids[0].label, "lemke of native 1.0");
  EXPECT_EQ(grids[1].label, "lemke of native 2.0");
  EXPECT_EQ(grids[1].cells.size(), 3U);
}

TEST(PaperReportTest, ProvenanceNamesEveryCommitAndNoFolder) {
  MadeSummary made;
  made.flat("paper/monotone/exp1", "lemke", 1);
  made.summary.runs.push_back({"a", Json::parse(R"({"commit": "c0ffee", "command": "lcpbench run paper"})")});
  made.summary.runs.push_back(
      {"b",
       Json::parse(R"({"commit": "decade", "command": "/opt/x/lcpbench run --set paper/* --store '/tmp/a b/c.db'"})")});
  const report::PaperStudy study = report::paper_study(made.summary);
  const std::string page = paper_files(made.summary, study).at("paper.md");
  EXPECT_NE(page.find("`c0ffee`, `decade`"), std::string::npos);
  EXPECT_NE(page.find("`lcpbench run --set paper/* --store 'c.db'`"), std::string::npos);
}

// --- a store of a real run ---

/// Every set that the tables distinguish, few problems, all native solvers that have a grid.
class PaperStoreTest : public testing::Test {
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

/// A solver's label in the tables, from its name and sweep in the store.
std::string label_of(std::string_view solver, std::string_view sweep) {
  return std::string(solver) + std::string(sweep.substr(std::string("paper").size()));
}

TEST_F(PaperStoreTest, QueryOfRatesRepeatsTheTable) {
  Store store = Store::open_for_reading(file());
  const Summary summary = summarize(store);
  const paper::Table table = rates_table(summary, paper::grids(summary), Kind::kMonotone);
  sqlite::Statement query(store.database(), table.query);
  int compared = 0;
  while (query.step()) {
    for (const Json& row : table.records) {
      if (row["set"] != std::string(query.text(0)) || row["solver"] != label_of(query.text(1), query.text(2))) continue;
      ++compared;
      EXPECT_EQ(row["parameterisations"], query.integer(4));
      EXPECT_EQ(row["trials"], query.integer(5));
      EXPECT_NEAR(row["criterion"]["worst"]["share"].get<double>(), query.real(6), 1e-15);
      EXPECT_NEAR(row["criterion"]["average"].get<double>(), query.real(7), 1e-12);
      EXPECT_NEAR(row["criterion"]["best"]["share"].get<double>(), query.real(8), 1e-15);
      EXPECT_NEAR(row["verdict"]["worst"]["share"].get<double>(), query.real(9), 1e-15);
      EXPECT_NEAR(row["verdict"]["average"].get<double>(), query.real(10), 1e-12);
      EXPECT_NEAR(row["verdict"]["best"]["share"].get<double>(), query.real(11), 1e-15);
      EXPECT_NEAR(row["criterion_any"]["worst"]["share"].get<double>(), query.real(14), 1e-15);
      EXPECT_NEAR(row["criterion_any"]["average"].get<double>(), query.real(15), 1e-12);
      EXPECT_NEAR(row["criterion_any"]["best"]["share"].get<double>(), query.real(16), 1e-15);
    }
  }
  EXPECT_EQ(compared, 5 * 3);
}

TEST_F(PaperStoreTest, QueryOfMeasurementsRepeatsTheTables) {
  Store store = Store::open_for_reading(file());
  const Summary summary = summarize(store);
  const paper::Table table = measurements_table(summary, paper::grids(summary));
  EXPECT_EQ(table.query, times_table(summary, paper::grids(summary), Kind::kMonotone).query);
  sqlite::Statement query(store.database(), table.query);
  int compared = 0;
  const auto expect = [&](const Json& spread, int count, int mean, int max) {
    ++compared;
    if (count >= 0) {
      EXPECT_EQ(spread["count"], query.integer(count));
    }
    if (query.is_null(mean)) {
      EXPECT_TRUE(spread["mean"].is_null());
      return;
    }
    EXPECT_NEAR(spread["mean"].get<double>(), query.real(mean), 1e-9 * query.real(mean));
    EXPECT_DOUBLE_EQ(spread["max"].get<double>(), query.real(max));
  };
  while (query.step()) {
    for (const Json& row : table.records) {
      if (row["set"] != std::string(query.text(0)) || row["solver"] != label_of(query.text(1), query.text(2))) continue;
      const int measure = row["solved_by"] == "criterion" ? 0 : row["solved_by"] == "criterion_any" ? 1 : 2;
      const int first_time = std::array{7, 20, 10}[static_cast<std::size_t>(measure)];
      const int first_violation = std::array{14, 23, 16}[static_cast<std::size_t>(measure)];
      if (row["quantity"] == "time_of_all_s") expect(row["all"], 4, 5, 6);
      if (row["quantity"] == "time_of_solved_s") expect(row["all"], first_time, first_time + 1, first_time + 2);
      if (row["quantity"] == "violation_of_solved_m_per_s")
        expect(row["all"], measure == 0 ? 13 : -1, first_violation, first_violation + 1);
    }
  }
  EXPECT_EQ(compared, 5 * 3 * 9);
}

TEST_F(PaperStoreTest, QueriesOfCellsRepeatMapsAndClaims) {
  Store store = Store::open_for_reading(file());
  const Summary summary = summarize(store);
  std::map<std::string, const Cell*> cells;
  for (const Cell& cell : summary.cells) {
    const SolverRow& solver = summary.solvers[cell.solver];
    cells[summary.sets[cell.set].name + " " + solver.text() + " " + solver.sweep] = &cell;
  }
  EXPECT_EQ(cells.size(), 5U * 3 * 81);
  const auto find = [&cells](std::string_view set, std::string_view solver, std::string_view settings,
                             std::string_view sweep) {
    SolverRow row;
    row.name = solver;
    row.settings = settings;
    return cells.at(std::string(set) + " " + row.text() + " " + std::string(sweep));
  };
  std::size_t rows = 0;
  sqlite::Statement by_cell(store.database(), paper::cells_query());
  for (; by_cell.step(); ++rows) {
    const Cell* cell = find(by_cell.text(0), by_cell.text(1), by_cell.text(5), by_cell.text(2));
    EXPECT_EQ(by_cell.integer(6), cell->trials);
    EXPECT_EQ(by_cell.integer(7), cell->criterion);
    EXPECT_EQ(by_cell.integer(8), cell->count(Verdict::kSolved));
    EXPECT_EQ(by_cell.integer(9), cell->unsolvable_problems);
  }
  EXPECT_EQ(rows, cells.size());
  sqlite::Statement totals(store.database(), paper::totals_query());
  for (rows = 0; totals.step(); ++rows) {
    const Cell* cell = find(totals.text(0), totals.text(1), totals.text(3), totals.text(2));
    EXPECT_EQ(totals.integer(4), cell->trials);
    EXPECT_EQ(totals.integer(5), cell->criterion);
    EXPECT_EQ(totals.integer(8), cell->false_claims());
  }
  EXPECT_EQ(rows, cells.size());
}

/// Everything that a report writes of the study, by name.
std::map<std::string, std::string> files_of(const std::filesystem::path& store_file) {
  Store store = Store::open_for_reading(store_file);
  const Summary summary = summarize(store);
  const report::PaperStudy study = report::paper_study(summary);
  std::map<std::string, std::string> files = paper_files(summary, study);
  files["html"] = paper_sections(summary, study);
  return files;
}

TEST_F(PaperStoreTest, RegeneratingGivesTheSameBytes) {
  const auto files = files_of(file());
  EXPECT_EQ(files, files_of(file()));
  for (const char* name : {"paper.md", "tables/paper-IV.1.csv", "tables/paper-IV.6.csv",
                           "tables/paper-measurements.csv", "tables/claims-paper.csv", "tables/readings.csv",
                           "tables/tolerance-map.csv", "figures/tolerance-paper_monotone_exp1_lemke.svg"}) {
    EXPECT_TRUE(files.contains(name)) << name;
  }
}

/// Each row of a Markdown table has as many fields as its heading, and every picture and file it names is written.
TEST_F(PaperStoreTest, MarkdownPageIsWhole) {
  const auto files = files_of(file());
  std::istringstream lines(files.at("paper.md"));
  std::size_t fields = 0;
  std::size_t pictures = 0;
  for (std::string line; std::getline(lines, line);) {
    std::size_t bars = 0;
    for (std::size_t i = 0; i < line.size(); ++i) bars += line[i] == '|' && (i == 0 || line[i - 1] != '\\');
    if (line.starts_with("|")) {
      if (fields == 0) fields = bars;
      EXPECT_EQ(bars, fields) << line;
    } else {
      fields = 0;
    }
    const std::size_t link = line.find("](");
    if (!line.starts_with("![") || link == std::string::npos) continue;
    ++pictures;
    EXPECT_TRUE(files.contains(line.substr(link + 2, line.size() - link - 3))) << line;
  }
  EXPECT_EQ(pictures, 15U);
}

TEST_F(PaperStoreTest, ReportLinksToTheStudy) {
  Store store = Store::open_for_reading(file());
  const auto folder = path("report");
  write_report(store, folder);
  std::ifstream in(folder / "report.html");
  const std::string page((std::istreambuf_iterator<char>(in)), {});
  for (const char* anchor : {"paper-tables", "paper-claims", "tolerance-maps"}) {
    EXPECT_NE(page.find("href=\"#" + std::string(anchor) + "\""), std::string::npos);
    EXPECT_NE(page.find("id=\"" + std::string(anchor) + "\""), std::string::npos);
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "paper.md"));
}

/// The pictures are XML that others read, small enough to have one for each of a study's sets, and whole: a field and a
/// number for every cell by both measures.
TEST_F(PaperStoreTest, MapsAreWholeAndSmall) {
  int pictures = 0;
  for (const auto& [name, content] : files_of(file())) {
    if (!name.starts_with("figures/")) continue;
    ++pictures;
    xmlDocPtr document = xmlReadMemory(content.data(), static_cast<int>(content.size()), "map.svg", nullptr,
                                       XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING);
    EXPECT_NE(document, nullptr) << name;
    xmlFreeDoc(document);
    EXPECT_LT(content.size(), 40000U) << name;
    std::size_t fields = 0;
    for (std::size_t at = content.find("v30"); at != std::string::npos; at = content.find("v30", at + 1)) ++fields;
    EXPECT_EQ(fields, 2U * 81) << name;
  }
  EXPECT_EQ(pictures, 15);
}

TEST(PaperReportTest, StoresWithoutSweepsHaveNoPaperPage) {
  MadeSummary made;
  made.single("paper/monotone/exp1", "lemke", "", {true});
  const report::PaperStudy study = report::paper_study(made.summary);
  EXPECT_TRUE(study.empty());
  EXPECT_EQ(paper_sections(made.summary, study), "");
  EXPECT_TRUE(paper_files(made.summary, study).empty());
}

/// What a store holds is text of others: it neither becomes markup nor breaks a table.
TEST(PaperReportTest, TextsOfTheStoreAreEscaped) {
  MadeSummary made;
  made.flat("paper/monotone/exp1", "<b>|`x`", 1);
  const report::PaperStudy study = report::paper_study(made.summary);
  EXPECT_EQ(paper_sections(made.summary, study).find("<b>"), std::string::npos);
  const std::string page = paper_files(made.summary, study).at("paper.md");
  EXPECT_NE(page.find("`<b>\\|'x'`"), std::string::npos);
}

}  // namespace
}  // namespace lcpbench
