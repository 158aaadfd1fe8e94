#include <algorithm>
#include <set>

#include "core/error.h"
#include "core/io/whole_file.h"
#include "study/commands/commands.h"
#include "study/commands/stores.h"
#include "study/output/csv.h"
#include "study/report/report.h"

namespace lcpbench {
namespace {

struct QueryArguments {
  std::filesystem::path store;
  std::string file;
  std::string format = "text";
};

/// For people: fractional numbers to six digits; null as "-".
std::string text_of(const Json& value) {
  if (value.is_string()) return printable(value.get<std::string>());  // say() would keep its line ends
  if (value.is_null()) return "-";
  return value.is_number_float() ? fmt::format("{:.6g}", value.get<double>()) : value.dump();
}

std::string table_of(const report::QueryResult& result) {
  std::vector<TextTable::Column> columns;
  for (std::size_t i = 0; i < result.columns.size(); ++i) {
    const bool has_numbers = std::any_of(result.rows.begin(), result.rows.end(),
                                         [&](const Json& row) { return row[i].is_number(); });
    columns.push_back({printable(result.columns[i]), has_numbers ? TextTable::Align::kRight : TextTable::Align::kLeft});
  }
  TextTable table(columns);
  for (const Json& row : result.rows) {
    std::vector<std::string> cells;
    for (const Json& value : row) cells.push_back(text_of(value));
    table.add_row(std::move(cells));
  }
  return table.empty() ? "no rows\n" : table.text(text_width());
}

/// @throws InputError where two columns have the same name: a JSON object would lose one of them
void require_different_names(const std::vector<std::string>& columns, const std::string& file) {
  std::set<std::string> names;
  for (const std::string& name : columns) {
    if (names.insert(name).second) continue;
    throw InputError(fmt::format("{}: two columns are named '{}', and JSON needs different names: use AS", file, name));
  }
}

int run_query_command(const QueryArguments& arguments) {
  const std::string sql = read_text(arguments.file, "query");
  Store store = open_checked(arguments.store);
  const sqlite::ReadSnapshot snapshot(store.database());
  const report::Report report = report::read_report(store);
  report::fill_tables(store, report);
  report::fill_slow_tables(store, report.summary);
  const report::QueryResult result = report::run_query(store.database(), arguments.file, sql);
  if (arguments.format == "json") {
    require_different_names(result.columns, arguments.file);
    print_json(report::records_of(result));
  } else {
    say(stdout, "{}", arguments.format == "csv" ? csv_table(result.columns, result.rows) : table_of(result));
  }
  return kExitDone;
}

}  // namespace

Action add_query_command(CLI::App& command) {
  const auto arguments = std::make_shared<QueryArguments>();
  command.add_option("STORE", arguments->store, "store that `lcpbench run` wrote")->required();
  command.add_option("FILE", arguments->file, "file with one SELECT, like the .sql files in study/report/tables")
      ->required();
  command.add_flag_callback("--wide", lift_text_width, "break no text, however wide the lines become");
  command.add_option("--format", arguments->format, "text, csv or json")
      ->check(CLI::IsMember({"text", "csv", "json"}))
      ->capture_default_str();
  command.footer(
      "The query reads the store's tables and views and the tables of the report (cells, pairs, contenders, ...), "
      "and has its statistics as functions (wilson_low, mcnemar, median, ...). It changes nothing. See "
      "docs/howto/report.md.");
  return [arguments] { return run_query_command(*arguments); };
}

}  // namespace lcpbench
