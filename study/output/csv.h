#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "study/output/json_output.h"

namespace lcpbench {

/// A text as a cell of a CSV table, quoted where it must be. Control characters become '?'. A text that a spreadsheet
/// would take for a formula, since it begins with = + - or @, gets an apostrophe in front, unless it is a number.
std::string csv_text(std::string_view text);

/// The members of a record and of the objects in it, by names with dots: "outer.inner". An empty object has none.
Json flattened(const Json& record);

/// A CSV table (RFC 4180, but lines end in LF). Numbers are written as in JSON and read back to the same doubles; null
/// is empty; texts are cells of csv_text(). @param rows  arrays
std::string csv_table(const std::vector<std::string>& columns, const std::vector<Json>& rows);

/// The same of records with the same members. @pre there is one
std::string csv_table(const Json& records);

}  // namespace lcpbench
