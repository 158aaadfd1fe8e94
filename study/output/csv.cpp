#include "study/output/csv.h"

#include <cmath>
#include <vector>

#include "core/io/text_tokens.h"
#include "core/utf8.h"

namespace lcpbench {
namespace {

std::string enclosed(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + "\"";
}

std::string cell_of(const Json& value) {
  if (value.is_null() || (value.is_number_float() && !std::isfinite(value.get<double>()))) return "";
  return value.is_string() ? csv_text(value.get<std::string>()) : enclosed(value.dump());
}

void flatten(const std::string& name, const Json& value, Json& flat) {
  if (!value.is_object()) {
    flat[name] = value;
    return;
  }
  for (const auto& [key, member] : value.items()) flatten(name.empty() ? key : name + "." + key, member, flat);
}

}  // namespace

std::string csv_text(std::string_view text) {
  std::string shown = printable(text);
  const bool formula = !shown.empty() && std::string_view("=+-@").find(shown.front()) != std::string_view::npos;
  if (formula && !parse_decimal(shown)) shown.insert(0, 1, '\'');
  return enclosed(shown);
}

Json flattened(const Json& record) {
  Json flat = Json::object();
  flatten("", record, flat);
  return flat;
}

std::string csv_table(const std::vector<std::string>& columns, const std::vector<Json>& rows) {
  std::string table;
  const auto add_line = [&table](const Json& cells) {
    std::string line;
    for (std::size_t i = 0; i < cells.size(); ++i) line += (i == 0 ? "" : ",") + cell_of(cells[i]);
    table += (line.empty() ? "\"\"" : line) + "\n";  // readers skip an empty line
  };
  add_line(columns);
  for (const Json& row : rows) add_line(row);
  return table;
}

std::string csv_table(const Json& records) {
  std::vector<std::string> columns;
  for (const auto& [name, value] : records.at(0).items()) columns.push_back(name);
  std::vector<Json> rows;
  for (const Json& record : records) {
    Json& row = rows.emplace_back(Json::array());
    for (const auto& [name, value] : record.items()) row.push_back(value);
  }
  return csv_table(columns, rows);
}

}  // namespace lcpbench
