#include "study/report/report.h"

#include <span>
#include <string_view>

#include "core/error.h"
#include "core/io/whole_file.h"
#include "core/utf8.h"
#include "study/output/csv.h"
#include "study/view/view.h"

namespace lcpbench {

namespace {

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError(folder.string() + ": cannot make the folder: " + error.message());
}

std::string text_of(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

namespace report {

std::string page_html(const Json& document) {
  constexpr std::string_view kPlace = "@report@";
  const std::string text = visible(text_of(document, -1), "\\\\");  // the page shows the escape
  std::string escaped;
  escaped.reserve(text.size() + text.size() / 64);
  for (const char c : text) {
    if (c == '<') {
      escaped += "\\u003c";
    } else {
      escaped += c;
    }
  }
  std::string page(kPage);
  return page.replace(page.find(kPlace), kPlace.size(), escaped);
}

Report read_report(Store& store) {
  Report report;
  const auto collect = [&report](const Summary& summary, std::span<const ProblemKey> problems,
                                 std::span<const Cell> cells) {
    add_statistics(summary, problems.size(), cells, report.statistics);
    report.regrets.add(summary, problems.size(), cells);
    for (const Cell& cell : cells) report.worst.push_back(worst_problems(cell, problems, kWorst));
  };
  report.summary = summarize(store, collect);
  report.summary.engine = only_engine(report.summary);
  complete_statistics(report.summary, report.statistics);
  report.situations = decide(report.summary, report.statistics);
  return report;
}

}  // namespace report

Coverage write_report(Store& store, const std::filesystem::path& folder, const std::vector<ReplayedFiles>& replays) {
  const sqlite::ReadSnapshot snapshot(store.database());  // a run may be writing
  const report::Report report = report::read_report(store);
  report::fill_tables(store, report);
  report::fill_slow_tables(store, report.summary, replays);
  Json document = report::report_json(store, report);
  document["scenes"] = stored_step_views(store);
  for (const ReplayedFiles& each : replays) document["replays"].push_back(replay_view(each));
  make_folder(folder);
  make_folder(folder / "tables");
  WholeFile page(folder / "report.html");  // its lock keeps another report out of the folder
  for (const report::TableQuery& query : report::kTableQueries) {
    const report::QueryResult result = report::run_query(store.database(), query.name, query.sql);
    write_file(folder / "tables" / (std::string(query.name) + ".csv"), csv_table(result.columns, result.rows));
    if (Json table = report::table_json(query, result); table.contains("rows")) document["tables"].push_back(table);
    if (result.rows.empty() || !std::string_view(query.name).starts_with("paper-")) continue;
    document["paper"]["tables"].push_back(query.name);
    if (query.name == std::string_view("paper-claims")) document["paper"]["claims"] = report::records_of(result);
  }
  Json summary = report::report_summary_json(report);
  for (const ReplayedFiles& each : replays) summary["replay"].push_back(replay_json(each.scene));
  write_file(folder / "summary.json", text_of(summary, 1) + "\n");
  write_file(folder / "report.json", text_of(document, -1) + "\n");
  page.write(report::page_html(document));
  page.commit();
  return report.summary.coverage;
}

}  // namespace lcpbench
