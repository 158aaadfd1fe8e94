#include "study/output/csv.h"

#include <charconv>
#include <cmath>
#include <map>
#include <system_error>
#include <utility>
#include <vector>

#include "core/utf8.h"

namespace lcpbench {

namespace {

using Json = nlohmann::ordered_json;

/// Name and cell of each column.
using Fields = std::vector<std::pair<std::string, std::string>>;

std::string enclosed(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + "\"";
}

bool is_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double ignored = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), ignored);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(ignored);
}

std::string cell_of(const Json& value) {
  if (value.is_null() || (value.is_number_float() && !std::isfinite(value.get<double>()))) return "";
  return value.is_string() ? csv_text(value.get<std::string>()) : enclosed(value.dump());
}

void flatten(const std::string& name, const Json& value, Fields& fields) {
  if (!value.is_object()) {
    fields.emplace_back(csv_text(name), cell_of(value));
    return;
  }
  for (const auto& [key, member] : value.items()) flatten(name.empty() ? key : name + "." + key, member, fields);
}

template <class Pick>
std::string line_of(const Fields& fields, Pick pick) {
  std::string line;
  for (const auto& field : fields) line += pick(field) + ",";
  if (!line.empty()) line.pop_back();
  return line + "\n";
}

}  // namespace

std::string csv_text(std::string_view text) {
  std::string shown = printable(text);
  const bool formula = !shown.empty() && std::string_view("=+-@").find(shown.front()) != std::string_view::npos;
  if (formula && !is_number(shown)) shown.insert(0, 1, '\'');
  return enclosed(shown);
}

std::string csv_table(const Json& example, const Json& records) {
  Fields columns;
  flatten("", example, columns);
  std::string table = line_of(columns, [](const auto& field) { return field.first; });
  for (const Json& record : records) {
    Fields fields;
    flatten("", record, fields);
    const std::map<std::string, std::string> values(fields.begin(), fields.end());
    table += line_of(columns, [&values](const auto& column) {
      const auto value = values.find(column.first);
      return value == values.end() ? std::string() : value->second;
    });
  }
  return table;
}

}  // namespace lcpbench
