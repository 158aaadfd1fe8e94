// What the report says in "Comparing solvers": every count comes out of the store again by the query that stands with
// it.

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "study/report/report.h"
#include "study/report/tables.h"
#include "study/report/decision.h"
#include "tests/support/program_run.h"
#include "tests/support/synthetic_store.h"

namespace lcpbench {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Two sets with everything that counts differently: failures, false claims, refusals, an unsolvable problem, a solver
/// that met only some problems, one that takes none, a name with a quote, a cell of a sweep.
void fill(SyntheticStore& made) {
  const auto reference = made.solver("lemke");
  const auto quick = made.solver("o'quick", "engine=kernel");
  const auto sampled = made.solver("sampled");
  const auto refusing = made.solver("refusing");
  const auto swept = made.solver("lemke", "zero_tolerance=1e-4", "paper");
  for (const char* set : {"paper/monotone/exp1", "paper/monotone/exp3"}) {
    for (std::int64_t trial = 0; trial < 24; ++trial) {
      const bool unsolvable = std::string(set).ends_with("exp3") && trial % 8 == 1;
      const MadeAnswer fails{.claim = Claim::kIterationLimit, .error = kNone, .criterion = false, .time_s = 3e-3};
      const MadeAnswer proves{.claim = Claim::kUnsolvable, .error = kNone, .proves_unsolvable = true, .time_s = 2e-3};
      const MadeAnswer lies{.error = 0.3, .criterion = false, .time_s = 2e-4};
      const MadeAnswer refuses{.claim = Claim::kUnsupported, .error = kNone, .criterion = false, .detail = "too large"};
      const double size = 1 + 0.1 * static_cast<double>(trial % 5);
      const MadeAnswer slow{.error = 1e-11, .time_s = 1.5e-3 * size};
      const MadeAnswer fast{.error = trial % 2 == 0 ? 1e-13 : 1e-5, .time_s = trial % 6 == 0 ? 4e-3 : 1e-4 * size};
      std::vector<std::pair<std::int64_t, MadeAnswer>> answers{{reference, unsolvable       ? proves
                                                                           : trial % 7 == 2 ? fails
                                                                                            : slow},
                                                               {quick, trial % 5 == 3   ? lies
                                                                       : trial % 9 == 4 ? refuses
                                                                                        : fast},
                                                               {refusing, refuses},
                                                               {swept, slow}};
      if (trial % 4 == 0) answers.emplace_back(sampled, slow);
      made.problem(set, trial, answers, 0, unsolvable ? "" : "solvable");
    }
  }
}

/// The rows of a query; every value as text, by its column's name.
std::vector<std::map<std::string, std::string>> rows_of(Store& store, const std::string& sql,
                                                        const std::vector<std::string>& columns) {
  sqlite::Statement query(store.database(), sql);
  std::vector<std::map<std::string, std::string>> rows;
  while (query.step()) {
    std::map<std::string, std::string>& row = rows.emplace_back();
    for (std::size_t i = 0; i < columns.size(); ++i) row[columns[i]] = query.text(static_cast<int>(i));
  }
  return rows;
}

std::string text_of(const nlohmann::ordered_json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

class ComparisonReportTest : public testing::Test {
 protected:
  ComparisonReportTest() : made_(folder_ / "s.db") {
    fill(made_);
    summary_ = summarize(made_.store());
    comparisons_ = compare_solvers(summary_, report::recommended_by_set(report::decide(summary_)));
    tables_ = report::comparison_tables(summary_, comparisons_);
  }

  /// Every record of the table is a row of the query in the columns named. @returns the number of records
  std::size_t expect_repeated(const nlohmann::ordered_json& table, const report::CountQuery& query,
                              const std::vector<std::string>& all_columns, const std::vector<std::string>& compared) {
    const auto rows = rows_of(made_.store(), query.sql, all_columns);
    for (const auto& record : table) {
      std::int64_t found = 0;
      for (const auto& row : rows) {
        bool equal = true;
        for (const std::string& column : compared) equal = equal && row.at(column) == text_of(record.at(column));
        if (equal) ++found;
      }
      EXPECT_EQ(found, 1) << record.dump();
    }
    return table.size();
  }

  /// Records of a table that fit, with the values of another column under the name that the query gives it.
  nlohmann::ordered_json renamed(const char* table, const char* key, const nlohmann::ordered_json& value,
                                 const std::function<void(nlohmann::ordered_json&)>& rename) {
    nlohmann::ordered_json records = nlohmann::ordered_json::array();
    for (nlohmann::ordered_json record : tables_.at(table)) {
      if (record.at(key) != value) continue;
      rename(record);
      records.push_back(std::move(record));
    }
    return records;
  }

  ScratchFolder folder_;
  SyntheticStore made_;
  Summary summary_;
  std::vector<SetComparison> comparisons_;
  nlohmann::ordered_json tables_;
};

TEST_F(ComparisonReportTest, PairsAreRepeatedByTheirQuery) {
  const std::vector<std::string> columns{"set",  "first",      "second",      "problems",
                                         "both", "only_first", "only_second", "neither"};
  EXPECT_EQ(expect_repeated(tables_["mcnemar"], report::kPairCounts, columns, columns), 6U);
}

TEST_F(ComparisonReportTest, SolverCountsAreRepeatedByTheirQuery) {
  const std::vector<std::string> columns{"set", "solver", "isa", "problems", "solved", "within_1ms", "error_1e6"};
  const std::vector<std::string> compared{"set", "solver", "problems", "solved"};
  EXPECT_EQ(expect_repeated(tables_["solver_times"], report::kSolverCounts, columns, compared), 6U);
}

TEST_F(ComparisonReportTest, DistributionsAreRepeatedByTheirQuery) {
  const std::vector<std::string> columns{"set", "solver", "isa", "problems", "solved", "within_1ms", "error_1e6"};
  const auto count = [](const nlohmann::ordered_json& record) {
    return std::llround(record["share"].get<double>() * record["problems"].get<double>());
  };
  const auto at_target = [&](double target, const char* what, const char* name) {
    nlohmann::ordered_json records = nlohmann::ordered_json::array();
    for (nlohmann::ordered_json record : tables_["ecdf"]) {
      if (record["what"] != what || std::abs(record["target"].get<double>() / target - 1) > 1e-9) continue;
      record[name] = count(record);
      records.push_back(std::move(record));
    }
    return records;
  };
  EXPECT_EQ(expect_repeated(at_target(1e-3, "solved within a time [s]", "within_1ms"), report::kSolverCounts, columns,
                            {"set", "solver", "problems", "within_1ms"}),
            6U);
  EXPECT_EQ(expect_repeated(at_target(1e-6, "answered within an error", "error_1e6"), report::kSolverCounts, columns,
                            {"set", "solver", "problems", "error_1e6"}),
            6U);
}

TEST_F(ComparisonReportTest, ProfilesAreRepeatedByTheirQuery) {
  const std::vector<std::string> columns{"set", "solver", "against", "problems", "within_2"};
  const auto quick = std::find_if(summary_.solvers.begin(), summary_.solvers.end(),
                                  [](const SolverRow& solver) { return solver.name == "o'quick"; });
  const Recommendations recommended{{0, static_cast<std::size_t>(quick - summary_.solvers.begin())}};
  tables_ = report::comparison_tables(summary_, compare_solvers(summary_, recommended));
  const auto records = renamed("profiles", "factor", 2.0, [](nlohmann::ordered_json& record) {
    record["within_2"] = std::llround(record["solver_share"].get<double>() * record["problems"].get<double>());
  });
  EXPECT_EQ(expect_repeated(records, report::kProfileCounts, columns, columns), 6U);
}

TEST_F(ComparisonReportTest, PortfoliosAreRepeatedByTheirQuery) {
  const std::vector<std::string> columns{"set", "solver", "problems", "virtual_best", "solved", "alone"};
  const auto records = renamed("vbs", "scope", "all problems", [](nlohmann::ordered_json&) {});
  EXPECT_EQ(expect_repeated(records, report::kPortfolioCounts, columns, columns), 4U);
}

TEST_F(ComparisonReportTest, ChainsAreRepeatedByTheirQuery) {
  int chains = 0;
  for (const SetComparison& comparison : comparisons_) {
    for (const VirtualBest& best : comparison.virtual_bests) {
      if (best.common_only) continue;
      ASSERT_TRUE(best.chain.has_value());
      const auto rows = rows_of(made_.store(), report::chain_query(summary_, comparison.set, *best.chain), {"solved"});
      EXPECT_EQ(rows.at(0).at("solved"), std::to_string(best.solved));
      ++chains;
    }
  }
  EXPECT_EQ(chains, 2);
}

TEST_F(ComparisonReportTest, SweepsAndSolversThatTakeNothingHaveNoRows) {
  for (const auto& record : tables_["solver_times"]) {
    EXPECT_NE(record["solver"], "refusing");
    EXPECT_EQ(text_of(record["solver"]).find("zero_tolerance"), std::string::npos);
  }
}

TEST_F(ComparisonReportTest, TheReportHoldsSectionQueriesTablesAndPictures) {
  write_report(made_.store(), folder_ / "out");
  const std::string page = read_file(folder_ / "out/report.html");
  EXPECT_NE(page.find("<section id=\"comparison\">"), std::string::npos);
  EXPECT_NE(page.find("href=\"#comparison\""), std::string::npos);
  EXPECT_NE(page.find("SELECT sets.name AS &quot;set&quot;"), std::string::npos);
  for (const char* table : {"mcnemar", "solver_times", "ecdf", "profiles", "vbs", "chains"}) {
    const std::string csv = read_file(folder_ / "out/tables" / (std::string(table) + ".csv"));
    const auto lines = static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n'));
    EXPECT_EQ(lines, 1 + tables_[table].size()) << table;
  }
  for (const char* picture : {"paper_monotone_exp1.ecdf-time.svg", "paper_monotone_exp1.ecdf-error.svg"}) {
    EXPECT_NE(read_file(folder_ / "out/figures" / picture).find("quick{engine=kernel}"), std::string::npos) << picture;
  }
}

TEST_F(ComparisonReportTest, SummaryJsonKeepsItsKeysAndGainsOne) {
  write_report(made_.store(), folder_ / "out");
  const auto json = nlohmann::ordered_json::parse(read_file(folder_ / "out/summary.json"));
  for (const char* key : {"provenance", "cells", "sweeps", "comparison"}) EXPECT_TRUE(json.contains(key)) << key;
  const auto& comparison = json["comparison"];
  EXPECT_EQ(comparison["shift_s"], kTimeShift);
  EXPECT_TRUE(comparison["time_limit_s"].is_null());
  for (const char* table : {"mcnemar", "solver_times", "profiles", "vbs", "chains"}) {
    EXPECT_EQ(comparison[table].size(), tables_[table].size()) << table;
  }
}

}  // namespace
}  // namespace lcpbench
