#include <filesystem>
#include <set>
#include <system_error>

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

/// @throws InputError where two columns have the same name: a JSON object would lose one of them
void require_different_names(const std::vector<std::string>& columns, const std::string& file) {
  std::set<std::string> names;
  for (const std::string& name : columns) {
    if (names.insert(name).second) continue;
    throw InputError(fmt::format("{}: two columns are named '{}', and JSON needs different names: use AS", file, name));
  }
}

/// The query in a file; where no such file exists, that of the report's table of this name.
std::string query_of(const std::string& name) {
  std::error_code error;
  const report::TableQuery* const table = std::filesystem::exists(name, error) ? nullptr : report::find_table(name);
  return table != nullptr ? std::string(table->sql) : read_text(name, "query");
}

int run_query_command(const QueryArguments& arguments) {
  const std::string sql = query_of(arguments.file);
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
    say(stdout, "{}",
        arguments.format == "csv" ? csv_table(result.columns, result.rows) : report::query_text(result, text_width()));
  }
  return kExitDone;
}

}  // namespace

Action add_query_command(CLI::App& command) {
  const auto arguments = std::make_shared<QueryArguments>();
  command.add_option("STORE", arguments->store, "store that `lcpbench run` wrote")->required();
  command
      .add_option(
          "FILE", arguments->file,
          "file with one SELECT, like the .sql files in study/report/tables, or the name of one of these tables")
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
