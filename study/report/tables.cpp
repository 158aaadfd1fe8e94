#include "study/report/tables.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <sqlite3.h>

#include "core/error.h"
#include "study/output/csv.h"

namespace lcpbench::report {

namespace {

constexpr std::string_view kOnlyInTables = "only in tables/";

void bind_json(sqlite::Statement& statement, int parameter, const Json& value, std::vector<std::string>& texts) {
  if (value.is_boolean()) return statement.bind(parameter, static_cast<int>(value.get<bool>()));
  if (value.is_number_integer()) return statement.bind(parameter, value.get<std::int64_t>());
  if (value.is_number()) return statement.bind(parameter, value.get<double>());
  if (value.is_null()) return statement.bind(parameter, std::optional<double>());
  texts.push_back(value.is_string() ? value.get<std::string>() : value.dump());
  statement.bind(parameter, std::string_view(texts.back()));
}

/// SQLite has no unsigned integers: a column named `seed` is taken to hold the 64 bits of one, as that of the store's
/// table `problems` does.
Json integer_of(sqlite3_stmt* statement, int column) {
  const std::int64_t value = sqlite3_column_int64(statement, column);
  const bool is_seed = std::string_view(sqlite3_column_name(statement, column)) == "seed";
  return is_seed ? Json(static_cast<std::uint64_t>(value)) : Json(value);
}

Json value_of(sqlite3_stmt* statement, int column) {
  switch (sqlite3_column_type(statement, column)) {
    case SQLITE_INTEGER: return integer_of(statement, column);
    case SQLITE_FLOAT: return sqlite3_column_double(statement, column);
    case SQLITE_NULL: return nullptr;
    default: break;
  }
  const void* bytes = sqlite3_column_blob(statement, column);
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement, column));
  return std::string(static_cast<const char*>(bytes), size);
}

/// What a name tells: "s" of median_time_s, "m/s" of error_m_per_s.
const char* unit_of(const std::string& column) {
  if (column.ends_with("_m_per_s")) return "m/s";
  return column.ends_with("_s") ? "s" : "";
}

}  // namespace

const TableQuery* find_table(std::string_view name) {
  const auto found = std::ranges::find(kTableQueries, name, &TableQuery::name);
  return found == kTableQueries.end() ? nullptr : &*found;
}

void fill_table(sqlite::Database& database, const std::string& name, const Json& records, const Json& example) {
  std::vector<Json> flat;
  Json columns = flattened(example);
  for (const Json& record : records) {
    flat.push_back(flattened(record));
    for (const auto& [column, value] : flat.back().items()) columns[column] = nullptr;
  }
  std::string names;
  std::string places;
  for (const auto& [column, value] : columns.items()) {
    names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", column);
    places += places.empty() ? "?" : ", ?";
  }
  database.execute(fmt::format("CREATE TEMP TABLE {} ({})", name, names));
  sqlite::Statement insert(database, fmt::format("INSERT INTO temp.{} VALUES ({})", name, places));
  for (const Json& record : flat) {
    std::vector<std::string> texts;
    texts.reserve(columns.size());
    int parameter = 0;
    for (const auto& [column, value] : columns.items()) {
      const auto found = record.find(column);
      bind_json(insert, ++parameter, found == record.end() ? Json() : *found, texts);
    }
    insert.run();
  }
}

QueryResult run_query(sqlite::Database& database, const std::string& name, std::string_view sql) {
  sqlite3* const handle = database.handle();
  const std::string text(sql);
  sqlite3_stmt* raw = nullptr;
  const char* rest = nullptr;
  const auto bad = [&](const std::string& cause) { return InputError(name + ": " + cause); };
  if (text.find('\0') != std::string::npos) throw bad("not a text");
  sqlite3_limit(handle, SQLITE_LIMIT_ATTACHED, 0);
  if (sqlite3_prepare_v2(handle, text.c_str(), -1, &raw, &rest) != SQLITE_OK) throw bad(sqlite3_errmsg(handle));
  const auto finalize = [](sqlite3_stmt* statement) { sqlite3_finalize(statement); };
  const std::unique_ptr<sqlite3_stmt, decltype(finalize)> statement(raw, finalize);
  if (raw == nullptr) throw bad("no query in it");
  const int count = sqlite3_column_count(raw);
  if (sqlite3_stmt_readonly(raw) == 0 || count == 0) throw bad("a query must be a SELECT: it changes nothing");
  while (*rest != '\0') {  // blanks, comments and semicolons may follow
    sqlite3_stmt* next = nullptr;
    const bool blank = sqlite3_prepare_v2(handle, rest, -1, &next, &rest) == SQLITE_OK && next == nullptr;
    sqlite3_finalize(next);
    if (!blank) throw bad("more than one query in it");
  }
  QueryResult result;
  for (int column = 0; column < count; ++column) result.columns.emplace_back(sqlite3_column_name(raw, column));
  int code = SQLITE_ROW;
  while ((code = sqlite3_step(raw)) == SQLITE_ROW) {
    Json& row = result.rows.emplace_back(Json::array());
    for (int column = 0; column < count; ++column) row.push_back(value_of(raw, column));
  }
  if (code != SQLITE_DONE) throw bad(sqlite3_errmsg(handle));
  return result;
}

Json records_of(const QueryResult& result) {
  Json records = Json::array();
  for (const Json& row : result.rows) {
    Json record = Json::object();
    for (std::size_t i = 0; i < result.columns.size(); ++i) record[result.columns[i]] = row[i];
    records.push_back(std::move(record));
  }
  return records;
}

Json page_value(Json value) {
  constexpr std::uint64_t kLargestExact = std::uint64_t{1} << 53;
  if (value.is_array()) {
    for (Json& element : value) element = page_value(std::move(element));
  }
  if (value.is_number_unsigned() && value.get<std::uint64_t>() > kLargestExact) return value.dump();
  if (!value.is_number_float()) return value;
  const double number = value.get<double>();
  return std::isfinite(number) ? Json(std::strtod(fmt::format("{:.6g}", number).c_str(), nullptr)) : Json();
}

Json table_json(const TableQuery& query, const QueryResult& result) {
  std::string title;
  std::string about;
  bool embedded = true;
  std::string_view sql = query.sql;
  while (sql.starts_with("-- ")) {
    const std::size_t end = sql.find('\n');
    const std::string_view line = sql.substr(3, end - 3);
    if (line == kOnlyInTables) {
      embedded = false;
    } else if (title.empty()) {
      title = line;
    } else {
      about += (about.empty() ? "" : " ") + std::string(line);
    }
    sql.remove_prefix(end + 1);
  }
  Json columns = Json::array();
  for (const std::string& column : result.columns) columns.push_back({{"name", column}, {"unit", unit_of(column)}});
  Json json{{"name", query.name}, {"title", title}, {"about", about}, {"columns", columns}};
  if (embedded) json["rows"] = page_value(result.rows);
  json["sql"] = sql;
  return json;
}

}  // namespace lcpbench::report
