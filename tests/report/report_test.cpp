#include "study/report/report.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>

#include "core/error.h"
#include "study/report/sql_functions.h"
#include "tests/support/program_run.h"
#include "tests/support/synthetic_store.h"

namespace lcpbench::report_test {
namespace {

using Json = nlohmann::json;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kHeadlineSet = "paper/copositive/exp5-1e8";

/// A store with the three situations: `good` is exact and fast, `lemke` exact and slow, `liar` wrong on a third.
void fill(SyntheticStore& made, const std::string& extra_set = "") {
  const auto reference = made.solver("lemke");
  const auto good = made.solver("good", "engine=kernel");
  const auto liar = made.solver("liar", "", "", "Some library");
  const auto silent = made.solver("silent");
  const auto refusing = made.solver("refusing");
  std::vector<std::string> sets{"paper/monotone/exp1", "paper/copositive/exp1", kHeadlineSet};
  if (!extra_set.empty()) sets.push_back(extra_set);
  for (const std::string& set : sets) {
    const int friction_rows = set.find("monotone") == std::string::npos ? 20 : 0;
    for (std::int64_t trial = 0; trial < 60; ++trial) {
      const double size = 1 + 0.1 * static_cast<double>(trial % 7);
      const bool lie = trial % 3 == 0;
      made.problem(set, trial,
                   {{reference, {.error = 1e-11 * size, .time_s = 4e-3 * size}},
                    {good, {.error = 1e-12 * size, .time_s = 1e-4 * size}},
                    {liar, {.error = lie ? 0.3 : 1e-13, .criterion = false, .time_s = 5e-5 * size}},
                    {silent, {.claim = Claim::kIterationLimit, .error = kNone, .time_s = 1e-3}},
                    {refusing, {.claim = Claim::kUnsupported, .error = kNone, .detail = "only frictionless"}}},
                   friction_rows);
    }
  }
}

std::vector<std::string> split_csv_line(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') {
      fields.back() += '"';
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

Json at_path(const Json& record, const std::string& column) {
  Json value = record;
  std::istringstream names(column);
  for (std::string name; std::getline(names, name, '.');) value = value.at(name);
  return value;
}

/// What the terminal shows of all results.
std::string results_of(SyntheticStore& made, int width) {
  const report::Report report = report::read_report(made.store());
  report::fill_tables(made.store(), report);
  return results_text(made.store(), report.summary, width);
}

class ReportTest : public ::testing::Test {
 protected:
  void write(const std::string& extra_set = "") {
    SyntheticStore made(folder_ / "s.db");
    fill(made, extra_set);
    write_report(made.store(), folder_ / "out");
    page_ = read_file(folder_ / "out/report.html");
  }

  ScratchFolder folder_;
  std::string page_;
};

/// The document in the page.
Json document_in(const std::string& page) {
  const std::string begin = "<script type=\"application/json\" id=\"report\">";
  const std::size_t at = page.find(begin) + begin.size();
  return Json::parse(page.substr(at, page.find("</script>", at) - at));
}

/// The rows of a table in the document.
Json rows_in(const Json& document, const std::string& name) {
  Json rows = Json::array();
  for (const Json& table : document["tables"]) {
    for (const Json& row : table["name"] == name ? table["rows"] : Json::array()) {
      rows.push_back(Json::object());
      for (std::size_t i = 0; i < row.size(); ++i) rows.back()[table["columns"][i]["name"].get<std::string>()] = row[i];
    }
  }
  return rows;
}

/// A number of the page, beside its counterpart elsewhere.
void expect_same(const Json& shown, const Json& other, const std::string& what) {
  if (shown.is_boolean() && other.is_number()) {
    EXPECT_EQ(shown.get<bool>() ? 1 : 0, other.get<int>()) << what;
  } else if (shown.is_number() && other.is_number()) {
    EXPECT_EQ(shown.get<double>(), other.get<double>()) << what;
  } else {
    EXPECT_EQ(shown, other) << what;
  }
}

/// Every number of the first screen is the one of summary.json and of the query beside it.
void expect_first_screen(Store& store, const std::filesystem::path& folder) {
  write_report(store, folder);
  const Json document = Json::parse(read_file(folder / "report.json"));
  const Json summary = Json::parse(read_file(folder / "summary.json"));
  EXPECT_EQ(document_in(read_file(folder / "report.html")), document);
  report::fill_tables(store, report::read_report(store));
  const auto query = [&](const std::string& sql) {
    return Json(report::records_of(report::run_query(store.database(), "test", sql)));
  };
  const Json decision = query("SELECT * FROM decision");
  ASSERT_EQ(decision.size(), summary["decision"].size());
  for (std::size_t row = 0; row < decision.size(); ++row) {
    const Json told = summary["decision"][row].flatten();
    for (const auto& [path, value] : told.items()) {
      std::string column = path.substr(1);
      std::replace(column.begin(), column.end(), '/', '.');
      expect_same(value, decision[row].at(column), path);
    }
    // The share is what the cells of summary.json add up to, and the recommended solver is the page's.
    for (const Json& situation : document["situations"]) {
      if (situation["title"] != told["/contacts"]) continue;
      std::int64_t solved = 0;
      for (const Json& index : situation["sets"]) {
        for (const Json& cell : summary["cells"]) {
          const bool here = cell["set"] == document["sets"].at(index.get<std::size_t>())["name"];
          const std::string settings = cell["settings"];
          const std::string spec =
              cell["solver"].get<std::string>() + (settings.empty() ? "" : "{" + settings + "}");
          if (here && spec == told["/solver"] && cell["sweep"] == "") solved += cell["solved"].get<std::int64_t>();
        }
      }
      EXPECT_EQ(told["/solved/part"], solved) << told;
      if (told["/recommended"] != true) continue;
      EXPECT_EQ(document["solvers"].at(situation["recommended"].get<std::size_t>())["spec"], told["/solver"]);
    }
  }
  const Json caught = query("SELECT SUM(false_claims) AS n FROM cells WHERE sweep = ''");
  std::int64_t wrong = 0;
  for (const Json& each : rows_in(document, "caught")) wrong += each["false_claims"].get<std::int64_t>();
  EXPECT_EQ(wrong, caught[0]["n"].is_null() ? 0 : caught[0]["n"].get<std::int64_t>());
  expect_same(document["plan"]["cells_planned"], summary["coverage"]["planned"], "plan");
  expect_same(document["plan"]["cells_done"], summary["coverage"]["done"], "plan");
  expect_same(document["plan"]["share"], summary["coverage"]["share"], "plan");
  EXPECT_EQ(document["rule"], summary["reliability_rule"]);
}

TEST_F(ReportTest, TheFirstScreenIsTheSummaryAndTheQuery) {
  SyntheticStore made(folder_ / "s.db");
  fill(made);
  expect_first_screen(made.store(), folder_ / "out");
  const Json document = Json::parse(read_file(folder_ / "out/report.json"));
  const Json& frictional = document["situations"][1];
  EXPECT_EQ(document["solvers"].at(frictional["recommended"].get<std::size_t>())["spec"], "good{engine=kernel}");
  ASSERT_EQ(rows_in(document, "caught").size(), 1U);
  EXPECT_EQ(rows_in(document, "caught")[0]["false_claims"], 60);
  EXPECT_EQ(rows_in(document, "caught")[0]["of"], 180);
}

/// A run that planned 60 problems of a set and came to 25.
TEST_F(ReportTest, TheFirstScreenOfATruncatedStoreIsTheSummaryAndTheQuery) {
  SyntheticStore made(folder_ / "s.db", R"({"cells": 60, "seed": 1, "sets": [{"set": "paper/monotone/exp1", "trials":
    60}], "solvers": [{"solver": "lemke", "sweep": "", "cells": 1, "on": [{"every": [1], "sets": [0]}]}]})");
  const auto solver = made.solver("lemke");
  for (std::int64_t trial = 0; trial < 25; ++trial) made.problem("paper/monotone/exp1", trial, {{solver, {}}});
  expect_first_screen(made.store(), folder_ / "out");
  const Json document = Json::parse(read_file(folder_ / "out/report.json"));
  EXPECT_EQ(document["plan"]["cells_planned"], 60);
  EXPECT_EQ(document["plan"]["cells_done"], 25);
  EXPECT_EQ(document["sets"][0]["planned"], 60);
}

TEST_F(ReportTest, HostileNamesStayText) {
  const std::string set = "<script>alert('x')</script>&\"copositive\"/../../e\n]]>\x01vil@report@";
  SyntheticStore made(folder_ / "s.db");
  fill(made, set);
  const auto solver = made.solver("</script><b>'\"\n");
  made.problem(set, 100, {{solver, {}}}, 20);
  expect_first_screen(made.store(), folder_ / "out");
  const std::string page = read_file(folder_ / "out/report.html");
  EXPECT_EQ(page.find("<script>alert"), std::string::npos);
  EXPECT_EQ(page.find("</script><b>"), std::string::npos);
  const Json document = document_in(page);
  bool found = false;
  for (const Json& each : document["sets"]) found |= each["name"] == set;
  EXPECT_TRUE(found);
}

TEST_F(ReportTest, WhatCannotBeSeenInANameIsShownAsAnEscape) {
  SyntheticStore made(folder_ / "s.db");
  made.problem("paper/monotone/exp1", 0, {{made.solver("lem\u202eke"), {}}});
  write_report(made.store(), folder_ / "out");
  const std::string page = read_file(folder_ / "out/report.html");
  EXPECT_EQ(document_in(page)["solvers"][0]["spec"], "lem\\u202eke");
  EXPECT_NE(page.find("script-src 'sha256-"), std::string::npos) << "the browser runs the page's own script alone";
}

TEST_F(ReportTest, EmptyStoreStillGivesAReport) {
  SyntheticStore made(folder_ / "s.db");
  expect_first_screen(made.store(), folder_ / "out");
  EXPECT_EQ(results_of(made, 100), "no answers yet\n");
}

/// The commands of the worst problems, the false claims first.
TEST_F(ReportTest, TheWorstProblemsStandWithTheirCommands) {
  write();
  const Json document = document_in(page_);
  int of_the_liar = 0;
  for (const Json& worst : rows_in(document, "worst")) {
    if (worst["solver"] != "liar") continue;
    ++of_the_liar;
    EXPECT_EQ(worst["verdict"], "wrong");
    EXPECT_EQ(worst["error"], 0.3);
    EXPECT_NE(worst["command"].get<std::string>().find("lcpbench generate paper/"), std::string::npos);
  }
  EXPECT_EQ(of_the_liar, 3 * 3);  // on each of three sets
}

// ------------------------------------------------------------------------------------------- queries and functions

class QueryTest : public ::testing::Test {
 protected:
  QueryTest() : made_(folder_ / "s.db") {}
  Json ask(const std::string& sql) {
    report::fill_tables(made_.store(), report::read_report(made_.store()));
    return report::records_of(report::run_query(made_.store().database(), "q.sql", sql));
  }
  Json ask_table(std::string_view name) {
    for (const report::TableQuery& query : report::kTableQueries) {
      if (query.name == name) return ask(std::string(query.sql));
    }
    throw std::logic_error("no such table");
  }
  std::string complaint(const std::string& sql) {
    try {
      ask(sql);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  ScratchFolder folder_;
  SyntheticStore made_;
};

TEST_F(QueryTest, TheDocumentNamesTheVersionThatRan) {
  made_.store().begin();
  made_.store().add_run("2026-02-01T00:00:00Z", R"({"lcpbench": "9.8.7"})");
  made_.store().commit();
  const report::Report report = report::read_report(made_.store());
  report::fill_tables(made_.store(), report);
  EXPECT_EQ(report::report_json(made_.store(), report)["made"]["version"][0], "9.8.7");
}

TEST_F(QueryTest, FunctionsAreTheStatistics) {
  const Json row = ask("SELECT wilson_low(9, 10) AS low, wilson_high(9, 10) AS high, mcnemar(1, 9) AS p, "
                       "(SELECT median(x) FROM (SELECT 3 AS x UNION ALL SELECT 1 UNION ALL SELECT NULL)) AS m, "
                       "(SELECT quantile(x, 0.5) FROM (SELECT 3 AS x UNION ALL SELECT 1)) AS q, "
                       "(SELECT exp(AVG(ln(x))) FROM (SELECT 4 AS x UNION ALL SELECT 1)) AS g, "
                       "(SELECT median(x) FROM (SELECT 1 AS x) WHERE x = 2) AS none, wilson_low(0, 0) AS nan, "
                       "difference_low(0.5, 100, 0.4, 100) AS d")[0];
  EXPECT_EQ(row["low"], wilson(9, 10).low);
  EXPECT_EQ(row["high"], wilson(9, 10).high);
  EXPECT_EQ(row["p"], mcnemar_exact(1, 9));
  EXPECT_EQ(row["m"], 2.0);
  EXPECT_EQ(row["q"], 1.0);
  EXPECT_NEAR(row["g"].get<double>(), 2, 1e-12);
  EXPECT_TRUE(row["none"].is_null() && row["nan"].is_null());
  EXPECT_LT(row["d"].get<double>(), 0.1);
}

TEST_F(QueryTest, TheLargestSeedIsNoNegativeNumber) {
  constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();
  made_.problem("paper/monotone/exp1", 0, {{made_.solver("liar"), {.error = 0.5}}}, 0, "solvable", "contact", kLargest);
  EXPECT_EQ(ask_table("worst")[0]["seed"], kLargest);
  const auto result = report::run_query(made_.store().database(), "q.sql", "SELECT seed, 7 AS x FROM judged");
  EXPECT_EQ(result.rows[0][0], kLargest);
  EXPECT_EQ(report::table_json({"q", "-- Seeds\n"}, result)["rows"][0], Json::array({std::to_string(kLargest), 7}));
}

TEST_F(QueryTest, ABadQueryIsOneLineAndChangesNothing) {
  EXPECT_EQ(complaint("SELECT 1; SELECT 2"), "q.sql: more than one query in it");
  EXPECT_EQ(complaint("-- nothing\n"), "q.sql: no query in it");
  for (const char* sql : {"DELETE FROM answers", "CREATE TEMP TABLE x(a)", "ATTACH 'x.db' AS y", "DROP TABLE cells"}) {
    EXPECT_EQ(complaint(sql), "q.sql: a query must be a SELECT: it changes nothing") << sql;
  }
  EXPECT_EQ(complaint("SELEC 1"), "q.sql: near \"SELEC\": syntax error");
  EXPECT_EQ(complaint("SELECT wilson_low(3, 2)"), "q.sql: wilson: successes must lie in 0 .. trials");
  EXPECT_EQ(complaint(std::string("SELECT 1\0 + 1", 12)), "q.sql: not a text");
  EXPECT_EQ(complaint("SELECT 1 -- one;\n;;"), "");
}

TEST_F(QueryTest, PairsAreTestedAndCorrected) {
  const auto a = made_.solver("a");
  const auto b = made_.solver("b");
  const auto c = made_.solver("c");
  const MadeAnswer gives_up{.claim = Claim::kIterationLimit, .error = kNone};
  const MadeAnswer refuses{.claim = Claim::kUnsupported, .error = kNone};
  for (std::int64_t trial = 0; trial < 20; ++trial) {
    made_.problem("paper/monotone/exp1", trial,
                  {{a, {}}, {b, trial < 8 ? gives_up : MadeAnswer{}}, {c, trial < 10 ? refuses : MadeAnswer{}}});
  }
  const Json rows = ask_table("pairs");
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0]["only_a"], 8);
  EXPECT_EQ(rows[0]["p"], mcnemar_exact(8, 0));
  EXPECT_NEAR(rows[0]["p_holm"].get<double>(), 3 * mcnemar_exact(8, 0), 1e-15);
  EXPECT_EQ(rows[1]["both_took"], 10) << "refused problems are no pairs";
  EXPECT_EQ(rows[1]["p_holm"], 1);
  EXPECT_TRUE(rows[1]["time_factor"].is_null()) << "fewer than 35 problems carry no factor";
}

TEST_F(QueryTest, RegretComparesAutoWithTheFastestThatReachedTheTarget) {
  const auto automatic = made_.solver("auto");
  const auto older = made_.store().add_solver({"rough", "", "engine=dense", "native", "0.9", "baseline", ""});
  const auto rough = made_.solver("rough");
  const auto cone = made_.solver("cone_ipm", "cone=true");
  for (std::int64_t trial = 0; trial < 4; ++trial) {
    made_.problem("paper/copositive/exp1", trial,
                  {{automatic, {.error = 1e-12, .time_s = 4e-3}},
                   {rough, {.error = 1e-5, .time_s = 1e-3}},
                   {older, {.error = 1e-12, .time_s = 1e-6}},
                   {cone, {.error = 1e-12, .time_s = 1e-6}}},
                  20);
  }
  made_.problem("paper/copositive/exp1", 4, {{automatic, {.error = 0.5, .time_s = 1e-6}}, {rough, {.error = 1e-5}}}, 20);
  const Json rows = ask_table("regret");
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[0]["target"], 1e-9);
  EXPECT_NEAR(rows[0]["mean"].get<double>(), 1, 1e-12);
  EXPECT_EQ(rows[3]["problems"], 5);
  EXPECT_NEAR(rows[3]["mean"].get<double>(), 4, 1e-12);
  EXPECT_EQ(rows[3]["large"], 4);
  EXPECT_EQ(rows[3]["missed"], 1) << "a false claim at the target does not reach it";
}

/// The share within an error counts what the verdict's threshold does not.
TEST_F(QueryTest, AnswersCountWithinEachError) {
  const auto rough = made_.solver("rough");
  made_.problem("paper/monotone/exp1", 0, {{rough, {.error = 1e-3}}});
  made_.problem("paper/monotone/exp1", 1, {{rough, {.error = 1e-7}}});
  const Json rows = ask_table("within_error");
  ASSERT_EQ(rows.size(), report::kErrors);
  const std::vector<int> solved{1, 2, 1, 1, 0, 0, 0, 0};
  const std::vector<int> wrong{1, 0, 1, 1, 1, 1, 1, 1};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i]["solved"], solved[i]) << i;
    EXPECT_EQ(rows[i]["wrong"], wrong[i]) << i;
  }
}

TEST_F(QueryTest, TheModelThatAStepNeedsIsTheFirstWithinTheError) {
  const auto automatic = made_.solver("auto");
  const auto cone = made_.solver("cone_ipm", "cone=true");
  const auto older = made_.store().add_solver({"auto", "", "engine=dense", "native", "0.9", "baseline", ""});
  made_.problem("scene/stack/ode", 0,
                {{automatic, {.time_s = 1, .model_error_m_per_s = 1e-4}}, {cone, {.model_error_m_per_s = 1e-9}}}, 20);
  const MadeAnswer coarse{.time_s = 1, .model_error_m_per_s = 0.1};
  made_.problem("scene/stack/ode", 1,
                {{automatic, coarse}, {cone, {.time_s = 2, .model_error_m_per_s = 1e-9}},
                 {older, {.time_s = 5, .model_error_m_per_s = 0.1}}}, 20);
  made_.problem("scene/stack/ode", 2,
                {{automatic, coarse}, {cone, {.time_s = 2, .model_error_m_per_s = 0.2}}}, 20);
  const Json rows = ask_table("model_choice");
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[0]["solver"], "auto");
  EXPECT_EQ(rows[0]["spent_s"], 1.0);
  EXPECT_EQ(rows[1]["version"], "0.9");
  EXPECT_EQ(rows[1]["spent_s"], 5.0);
  EXPECT_EQ(rows[2]["solver"], "cone_ipm{cone=true}");
  EXPECT_EQ(rows[2]["spent_s"], 3.0) << "without the time of the other build";
  EXPECT_EQ(rows[3]["solver"], "auto");
  EXPECT_EQ(rows[3]["met"], 0);
}

// ------------------------------------------------------------------------------------------------ files and words

TEST_F(ReportTest, TablesReadBackToTheNumbersOfTheSummary) {
  write();
  const auto summary = Json::parse(read_file(folder_ / "out/summary.json"));
  std::istringstream csv(read_file(folder_ / "out/tables/cells.csv"));
  std::string line;
  std::getline(csv, line);
  const std::vector<std::string> columns = split_csv_line(line);
  ASSERT_GT(columns.size(), 30U);
  std::size_t row = 0;
  for (; std::getline(csv, line); ++row) {
    const std::vector<std::string> fields = split_csv_line(line);
    ASSERT_EQ(fields.size(), columns.size());
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (columns[i] == "label") break;  // what follows is beside the cells of summary.json
      const Json expected = at_path(summary["cells"].at(row), columns[i]);
      const std::string text = expected.is_string() ? expected.get<std::string>() : fields[i];
      EXPECT_EQ(fields[i], text);
      EXPECT_EQ(fields[i].empty(), expected.is_null() || text.empty()) << columns[i];
      if (expected.is_number()) {
        EXPECT_EQ(std::strtod(fields[i].c_str(), nullptr), expected.get<double>()) << columns[i];
      }
    }
  }
  EXPECT_EQ(row, summary["cells"].size());
}

TEST_F(ReportTest, ThePapersClaimsCompareSingleSettingsInPairs) {
  SyntheticStore made(folder_ / "s.db");
  const auto lemke = made.solver("lemke");
  const auto rival = made.solver("primal_dual");
  const auto swept = made.solver("lemke", "zero_tolerance=1e-8", "paper");  // without one there are no claims
  for (std::int64_t trial = 0; trial < 60; ++trial) {
    const Claim claim = trial % 3 == 0 ? Claim::kIterationLimit : Claim::kSolved;
    const double error = claim == Claim::kSolved ? 1e-11 : kNone;
    made.problem("paper/monotone/exp1", trial,
                 {{lemke, {.error = 1e-11}}, {swept, {.error = 1e-11}}, {rival, {.claim = claim, .error = error}}});
  }
  write_report(made.store(), folder_ / "out");
  EXPECT_NE(read_file(folder_ / "out/tables/paper-claims.csv").find("single settings"), std::string::npos);
}

TEST_F(ReportTest, TerminalTableKeepsItsColumnsApartWhenAnErrorIsNoNumber) {
  SyntheticStore made(folder_ / "s.db");
  const auto solver = made.solver("lemke");
  made.problem("paper/monotone/exp3", 0, {{solver, {.error = kNone}}});
  const std::string text = results_of(made, 100);
  EXPECT_NE(text.find(" none\n"), std::string::npos) << text;
  EXPECT_EQ(text.find("no number"), std::string::npos) << text;
}

TEST_F(ReportTest, TerminalTableKeepsItsColumnsUnderLongNames) {
  SyntheticStore made(folder_ / "s.db");
  const auto brief = made.solver("lemke");
  const auto wordy = made.solver("velocity_ipm_cholmod", "factor=supernodal,refinements=3");
  made.problem("paper/monotone/exp3", 0, {{brief, {}}, {wordy, {}}});
  std::istringstream lines(results_of(made, 100));
  std::vector<std::size_t> columns;
  for (std::string line; std::getline(lines, line);) {
    if (line.find("100 %") != std::string::npos) columns.push_back(line.find("100 %"));
  }
  ASSERT_EQ(columns.size(), 2U);
  EXPECT_EQ(columns[0], columns[1]);
}

TEST_F(ReportTest, AFolderThatCannotBeMadeIsOneClearLine) {
  SyntheticStore made(folder_ / "s.db");
  std::ofstream(folder_ / "file") << "x";
  try {
    write_report(made.store(), folder_ / "file/out");
    FAIL() << "wrote into a file";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("file/out: cannot make the folder"), std::string::npos);
  }
}

TEST_F(ReportTest, TerminalTableFitsAndNamesEverySolver) {
  SyntheticStore made(folder_ / "s.db");
  fill(made);
  const std::string out = results_of(made, 100);
  std::istringstream lines(out);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(character_count(line), 100U) << line;
  for (const char* expected : {"good{engine=kernel}", "liar", "33.3 %", "does not take these", "130 µs"}) {
    EXPECT_NE(out.find(expected), std::string::npos) << expected;
  }
}

TEST_F(ReportTest, TablesWithoutRowsHaveTheSameHeaderAsThoseWithRows) {
  SyntheticStore none(folder_ / "none.db");
  SyntheticStore some(folder_ / "some.db");
  const auto solver = some.solver("lemke");
  const auto swept = some.solver("lemke", "zero_tolerance=1e-4", "paper");
  some.problem("paper/monotone/exp3", 0, {{solver, {}}, {swept, {}}});
  write_report(none.store(), folder_ / "none");
  write_report(some.store(), folder_ / "some");
  for (const char* table : {"cells.csv", "results.csv", "sweeps.csv", "claims.csv", "decision.csv"}) {
    const std::string rows = read_file(folder_ / "some/tables" / table);
    const std::string header = rows.substr(0, rows.find('\n') + 1);
    EXPECT_GT(header.size(), 20U) << table;
    EXPECT_GT(rows.size(), header.size()) << table;
    EXPECT_TRUE(read_file(folder_ / "none/tables" / table).starts_with(header)) << table;
  }
  EXPECT_EQ(read_file(folder_ / "none/tables/sweeps.csv").find('\n') + 1,
            read_file(folder_ / "none/tables/sweeps.csv").size());
}

}  // namespace
}  // namespace lcpbench::report_test
