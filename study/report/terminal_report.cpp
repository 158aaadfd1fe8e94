#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "study/output/text_table.h"
#include "study/report/report.h"
#include "study/report/text.h"
#include "study/report/worst.h"

namespace lcpbench {
namespace {

using Align = TextTable::Align;

constexpr int kMostDetail = 3;            ///< of a situation: see the view terminal_answer
constexpr std::size_t kHardSolvers = 8;   ///< that are right on the most hard cases
constexpr std::size_t kCaughtByName = 4;  ///< solvers with false claims

Json ask(Store& store, const std::string& sql) {
  return report::records_of(report::run_query(store.database(), "terminal", sql));
}

std::string shown(const Json& value) {
  return value.is_string() ? value.get<std::string>() : value.is_null() ? "–" : value.dump();
}

/// The rows of a view of study/report/views.sql, at most so many. Its first column is the heading of a group. A row
/// that is NULL from the third column on is text.
TextTable table_of(Store& store, const std::string& sql, const std::vector<TextTable::Column>& columns,
                   std::size_t most = static_cast<std::size_t>(-1)) {
  TextTable table(columns);
  Json heading;
  const report::QueryResult result = report::run_query(store.database(), "terminal", sql);
  for (std::size_t i = 0; i < std::min(most, result.rows.size()); ++i) {
    const Json& row = result.rows[i];
    if (row[0] != heading) {
      heading = row[0];
      table.add_line(shown(heading));
    }
    std::vector<std::string> cells;
    for (std::size_t column = 1; column < row.size(); ++column) cells.push_back(shown(row[column]));
    const bool words = std::all_of(row.begin() + 2, row.end(), [](const Json& value) { return value.is_null(); });
    words ? table.add_line(cells[0]) : table.add_row(std::move(cells));
  }
  return table;
}

std::string situations_table(Store& store, int detail, int width) {
  const TextTable table = table_of(
      store,
      fmt::format("SELECT NULL, contacts, part, solver, solved, range, wrong, time, factor, error FROM terminal_answer "
                  "WHERE detail <= {}",
                  detail),
      {{"contacts", Align::kLeft, 0, 12},
       {"", Align::kLeft, 0, 8},
       {"solver", Align::kLeft, 0, 14},
       {"solved"},
       {"95 %"},
       {"wrong", Align::kRight, 2},
       {"time", Align::kRight, 1},
       {"times as long", Align::kLeft, 0, 12},
       {"error 99 %", Align::kRight, 3}});
  if (table.empty()) return "";
  return table.text(width) +
         folded(fmt::format("solved: of what it took. wrong: said solved, and was not. time: geometric mean. times as "
                            "long: as the solver to use, on the n problems that both solved (95 %); none below {}.\n",
                            report::least_problems()),
                width);
}

/// A table with a row for each of at most so many solvers: on how many hard cases it came to each outcome. Those that
/// are right on the most cases come first.
std::string hard_text(Store& store, int width, std::size_t solvers = static_cast<std::size_t>(-1)) {
  const std::int64_t cases = store.database().integer("SELECT COUNT(*) FROM set_facts WHERE hard");
  const TextTable table = table_of(store, "SELECT * FROM terminal_hard",
                                   {{report::counted(cases, "hard case"), Align::kLeft},
                                    {"solved"},
                                    {"to 1e-9", Align::kRight, 2},
                                    {"no sol.", Align::kRight, 1},
                                    {"WRONG"},
                                    {"denied", Align::kRight, 2},
                                    {"missed"},
                                    {"unsaid", Align::kRight, 5},
                                    {"gave up", Align::kRight, 4},
                                    {"unknown", Align::kRight, 3},
                                    {"refused", Align::kRight, 6}},
                                   solvers);
  if (table.empty()) return "";
  const auto all = static_cast<std::size_t>(store.database().integer("SELECT COUNT(*) FROM terminal_hard"));
  const std::string more = all > solvers ? fmt::format("and {} more solvers: --long shows them\n", all - solvers) : "";
  return table.text(width) + more;
}

/// Who said solved of which case and was wrong, and what the headings of hard_text() mean.
std::string hard_words(Store& store, int width) {
  std::string text;
  for (const Json& row : ask(store,
                             "SELECT solver, group_concat(substr(\"set\", 6), ', ') AS cases FROM hard_cases "
                             "WHERE outcome = 'false_claim' GROUP BY solver")) {
    text += "  " + shown(row["solver"]) + ": " + shown(row["cases"]) + "\n";
  }
  text = text.empty() ? "no solver said solved what is not\n" : "said solved, and is not:\n" + text;
  return folded(
      text +
          "no sol.: rightly said to have no solution. WRONG: said solved, and is not. denied: said to have no "
          "solution, has one. unsaid: right, but not claimed. gave up: on what has no solution.\n",
      width);
}

std::string caught_text(Store& store, const Summary& summary, int width) {
  const Json caught = ask(store, std::string(report::find_table("caught")->sql));
  std::string text = "said solved, and was wrong:";
  const std::int64_t swept =
      store.database().integer("SELECT COUNT(*) FROM cells WHERE sweep <> '' AND false_claims > 0");
  if (caught.empty()) text += swept > 0 ? " no solver at single settings" : " nobody";
  for (std::size_t i = 0; i < std::min(caught.size(), kCaughtByName); ++i) {
    text += fmt::format("{} {} on {} of {}", i > 0 ? ";" : "", shown(caught[i]["solver"]),
                        format_count(caught[i]["false_claims"].get<std::int64_t>()),
                        format_count(caught[i]["of"].get<std::int64_t>()));
  }
  if (caught.size() > kCaughtByName) text += fmt::format("; and {} more solvers", caught.size() - kCaughtByName);
  if (swept > 0) text += fmt::format("; {} of sweeps, counted on each set", report::counted(swept, "parameterisation"));
  for (const std::string& note : report::notes(summary)) text += "\n" + note;
  return folded(text + "\n", width);
}

/// For people: fractional numbers to six digits; null as "-".
std::string text_of(const Json& value) {
  if (value.is_string()) return printable(value.get<std::string>());  // say() would keep its line ends
  if (value.is_null()) return "-";
  return value.is_number_float() ? fmt::format("{:.6g}", value.get<double>()) : value.dump();
}

}  // namespace

std::string report::query_text(const QueryResult& result, int width) {
  std::vector<TextTable::Column> columns;
  for (std::size_t i = 0; i < result.columns.size(); ++i) {
    const bool has_numbers = std::ranges::any_of(result.rows, [i](const Json& row) { return row[i].is_number(); });
    columns.push_back({printable(result.columns[i]), has_numbers ? Align::kRight : Align::kLeft});
  }
  TextTable table(columns);
  for (const Json& row : result.rows) {
    std::vector<std::string> cells;
    for (const Json& value : row) cells.push_back(text_of(value));
    table.add_row(std::move(cells));
  }
  return table.empty() ? "no rows\n" : table.text(width);
}

std::string answer_text(Store& store, const report::Report& report, int width, std::size_t lines) {
  if (report.summary.cells.empty()) return "no answers yet\n";
  std::string end;
  for (const report::Situation& situation : report.situations) {
    if (!situation.withheld.empty()) end += situation.title + ": " + situation.withheld + "\n";
  }
  const bool end_says_why = !end.empty();
  end = folded(end, width) + caught_text(store, report.summary, width);
  if (situations_table(store, 0, width).empty()) {
    const std::string none =
        end_says_why ? "" : folded("no solver is recommended: that takes random contact problems or captured scenes\n", width);
    return fitting_text(kHardSolvers, lines,
                        [&](std::size_t rows) { return hard_text(store, width, rows) + none + end; });
  }
  return fitting_text(kMostDetail, lines, [&](std::size_t detail) {
    return situations_table(store, static_cast<int>(detail), width) + end;
  });
}

std::string results_text(Store& store, const Summary& summary, int width) {
  if (summary.cells.empty()) return "no answers yet\n";
  const TextTable table = table_of(store, "SELECT * FROM terminal_results",
                                   {{"", Align::kLeft, 0, 20},
                                    {"solved"},
                                    {"95 %", Align::kLeft, 3, 12},
                                    {"wrong"},
                                    {"gave up"},
                                    {"refused", Align::kRight, 4},
                                    {"median"},
                                    {"ratio", Align::kLeft, 2},
                                    {"err 99%", Align::kRight, 1}});
  std::string hard = hard_text(store, width);
  if (!hard.empty()) hard += hard_words(store, width);
  if (table.empty()) return hard;
  std::string words =
      "solved: verified here. wrong: said solved, was not. refused: of those given up, outside what the solver takes. "
      "median: set-up and solve, CPU. err 99%: of the answers said to be solved; none: too many of them are not "
      "finite, or not of the right length.\n";
  if (!summary.reference.empty()) {
    words += fmt::format("ratio: time over that of {}, on the n problems that both solved; none below {}.\n",
                         summary.reference, report::least_problems());
  }
  return table.text(width) + hard + folded(words, width);
}

std::string paper_text(Store& store, int width) {
  std::string text;
  std::string about;
  for (const report::TableQuery& query : report::kTableQueries) {
    if (!std::string_view(query.name).starts_with("paper-table-")) continue;
    report::QueryResult result = report::run_query(store.database(), query.name, query.sql);
    const Json words = report::table_json(query, result);
    bool has_ours = false;
    for (std::size_t i = result.columns.size(); i-- > 0;) {
      const auto absent = [i](const Json& row) { return row[i].is_null(); };
      if (!std::ranges::all_of(result.rows, absent)) {
        has_ours = has_ours || result.columns[i].ends_with("ours");
        std::ranges::replace(result.columns[i], '_', ' ');
        continue;
      }
      result.columns.erase(result.columns.begin() + static_cast<std::ptrdiff_t>(i));
      for (Json& row : result.rows) row.erase(i);
    }
    if (!has_ours) continue;
    if (words["about"] != about) text += folded(about = words["about"], width) + "\n\n";
    text += folded(words["title"], width) + "\n" + report::query_text(result, width) + "\n";
  }
  return text;
}

std::string worst_text(Store& store, std::size_t rows, int width) {
  const Json worst =
      ask(store,
          "SELECT command, verdict, error FROM (SELECT *, ROW_NUMBER() OVER (PARTITION BY solver ORDER BY "
          "verdict <> 'wrong', error IS NOT NULL, error DESC) AS number FROM worst) WHERE number = 1 "
          "ORDER BY verdict <> 'wrong', error IS NOT NULL, error DESC");
  if (worst.empty() || rows == 0) return "";
  std::string commands;
  std::size_t count = 0;
  for (const Json& each : worst) {
    if (count == rows) break;
    if (each["command"] == "") continue;
    const double error = each["error"].is_null() ? kNoNumber : each["error"].get<double>();
    const report::Failure failure{each["verdict"] == "wrong", error};
    commands += report::command_text(each["command"].get<std::string>(), failure.text(), width);
    ++count;
  }
  const std::string more =
      count < worst.size() ? fmt::format("and {} more: see the report\n", worst.size() - count) : "";
  return (count > 0 ? "each solver's worst problem:\n" + commands : "") + folded(more, width);
}

}  // namespace lcpbench
