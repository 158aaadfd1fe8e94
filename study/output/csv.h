#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace lcpbench {

/// A text as a cell of a CSV table, quoted where it must be. Control characters become '?'. A text that a spreadsheet
/// would take for a formula, since it begins with = + - or @, gets an apostrophe in front, unless it is a number.
std::string csv_text(std::string_view text);

/// A CSV table (RFC 4180, LF) of JSON records, one row each. Nested members become columns "outer.inner"; numbers are
/// written as in the JSON, so both read back to the same doubles; null is empty; texts are cells of csv_text().
/// @param example  a record with the members that all have: its names are the header, which stands also over no rows;
/// what a record lacks is empty
std::string csv_table(const nlohmann::ordered_json& example, const nlohmann::ordered_json& records);

}  // namespace lcpbench
