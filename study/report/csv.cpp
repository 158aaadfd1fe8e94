#include "study/report/csv.h"

#include <cmath>
#include <map>
#include <utility>

namespace lcpbench::report {

namespace {

using Json = nlohmann::ordered_json;
using Fields = std::vector<std::pair<std::string, std::string>>;

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + "\"";
}

std::string field_text(const Json& value) {
  if (value.is_null() || (value.is_number_float() && !std::isfinite(value.get<double>()))) return "";
  return value.is_string() ? value.get<std::string>() : value.dump();
}

void flatten(const std::string& name, const Json& value, Fields& fields) {
  if (!value.is_object()) {
    fields.emplace_back(name, field_text(value));
    return;
  }
  for (const auto& [key, member] : value.items()) flatten(name.empty() ? key : name + "." + key, member, fields);
}

template <class Pick>
std::string line_of(const Fields& fields, Pick pick) {
  std::string line;
  for (const auto& field : fields) line += quoted(pick(field)) + ",";
  if (!line.empty()) line.pop_back();
  return line + "\n";
}

}  // namespace

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

}  // namespace lcpbench::report
