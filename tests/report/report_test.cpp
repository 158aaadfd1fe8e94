#include "study/report/report.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>

#include "core/error.h"
#include "study/report/sql_functions.h"
#include "tests/support/checks.h"
#include "tests/support/page_document.h"
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

class ReportTest : public ::testing::Test {
 protected:
  ScratchFolder folder_;
};

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
  EXPECT_EQ(document_of(read_file(folder / "report.html")), document);
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
          const std::string spec = cell["solver"].get<std::string>() + (settings.empty() ? "" : "{" + settings + "}");
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
  const Json document = document_of(page);
  bool found = false;
  for (const Json& each : document["sets"]) found |= each["name"] == set;
  EXPECT_TRUE(found);
}

TEST_F(ReportTest, WhatCannotBeSeenInANameIsShownAsAnEscape) {
  SyntheticStore made(folder_ / "s.db");
  made.problem("paper/monotone/exp1", 0, {{made.solver("lem\u202eke"), {}}});
  write_report(made.store(), folder_ / "out");
  const std::string page = read_file(folder_ / "out/report.html");
  EXPECT_EQ(document_of(page)["solvers"][0]["spec"], "lem\\u202eke");
  EXPECT_NE(page.find("script-src 'sha256-"), std::string::npos) << "the browser runs the page's own script alone";
}

TEST_F(ReportTest, AnEmptyStoreStillGivesAReport) {
  SyntheticStore made(folder_ / "s.db");
  expect_first_screen(made.store(), folder_ / "out");
}

/// The commands of the worst problems, the false claims first.
TEST_F(ReportTest, TheWorstProblemsStandWithTheirCommands) {
  SyntheticStore made(folder_ / "s.db");
  fill(made);
  write_report(made.store(), folder_ / "out");
  const Json document = document_of(read_file(folder_ / "out/report.html"));
  int of_the_liar = 0;
  for (const Json& worst : rows_in(document, "worst")) {
    if (worst["solver"] != "liar") continue;
    ++of_the_liar;
    EXPECT_EQ(worst["verdict"], "wrong");
    EXPECT_EQ(worst["error"], 0.3);
    EXPECT_NE(worst["command"].get<std::string>().find("lcpbench solve 'paper/"), std::string::npos);
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
    return input_error([&] { ask(sql); });
  }

  ScratchFolder folder_;
  SyntheticStore made_;
};

TEST_F(QueryTest, FunctionsAreTheStatistics) {
  const Json row =
      ask("SELECT wilson_low(9, 10) AS low, wilson_high(9, 10) AS high, mcnemar(1, 9) AS p, "
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
  EXPECT_EQ(complaint("SELECT 1 -- one;\n;;"), "no InputError");
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
  made_.problem("paper/copositive/exp1", 4, {{automatic, {.error = 0.5, .time_s = 1e-6}}, {rough, {.error = 1e-5}}},
                20);
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
  const std::vector<int> solved{1, 2, 2, 2, 1, 1, 1, 1, 0, 0, 0, 0, 0};
  const std::vector<int> wrong{1, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i]["solved"], solved[i]) << i;
    EXPECT_EQ(rows[i]["wrong"], wrong[i]) << i;
  }
}

}  // namespace
}  // namespace lcpbench::report_test
