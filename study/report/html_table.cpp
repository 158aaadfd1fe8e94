#include "study/report/html_table.h"

#include <cmath>

#include <fmt/format.h>

namespace lcpbench::report {

std::string table_head(const std::string& cls, std::span<const Column> columns) {
  std::string head = "<div class=\"scroll\" tabindex=\"0\"><table class=\"" + cls + "\"><thead><tr>";
  for (const Column& column : columns) {
    head += fmt::format("<th scope=\"col\"{}>{}</th>", column.number ? " class=\"number\"" : "", column.heading);
  }
  return head + "</tr></thead><tbody>\n";
}

std::string number_cell(double value, const std::string& text, const std::string& detail,
                        const std::string& attributes) {
  const std::string key = std::isfinite(value) ? fmt::format("{:.5g}", value) : "";
  return fmt::format("<td data-value=\"{}\"{}>{}{}</td>", key, attributes, text,
                     detail.empty() ? "" : "<small>" + detail + "</small>");
}

}  // namespace lcpbench::report
