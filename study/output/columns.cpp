#include "study/output/columns.h"

#include "core/spec.h"

namespace lcpbench {

JsonCell field(const std::string& path, std::string (*format)(double)) {
  return [pointer = Json::json_pointer("/" + path), format](const Json& row) -> std::string {
    const Json& value = row.at(pointer);
    if (value.is_string()) return value.get<std::string>();
    if (value.is_null()) return "-";
    return format != nullptr ? format(value.get<double>()) : format_count(value.get<std::int64_t>());
  };
}

std::string solver_label(const std::string& spec, const std::string& engine) {
  constexpr std::string_view kEngine = "engine";
  if (!engine.empty() && spec.substr(0, spec.find('{')) == kEngine) {
    return printable(engine) + spec.substr(kEngine.size());
  }
  if (!spec.starts_with("external{")) return spec;
  for (const auto& [setting, value] : parse_spec(spec).options) {
    if (setting == "name") return value;
  }
  return spec;
}

std::string solver_text(const Json& row) {
  const std::string settings = row.at("settings").get<std::string>();
  return solver_label(row.at("solver").get<std::string>() + (settings.empty() ? "" : "{" + settings + "}"));
}

std::string table_text(const std::vector<JsonColumn>& columns, const Json& rows, int width) {
  std::vector<TextTable::Column> headings;
  for (const JsonColumn& each : columns) headings.push_back(each.column);
  TextTable table(std::move(headings));
  for (const Json& row : rows) {
    std::vector<std::string> cells;
    for (const JsonColumn& each : columns) cells.push_back(each.cell(row));
    table.add_row(std::move(cells));
  }
  return table.text(width);
}

}  // namespace lcpbench
