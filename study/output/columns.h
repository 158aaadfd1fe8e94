#pragma once

#include <functional>
#include <string>
#include <vector>

#include "study/output/json_output.h"
#include "study/output/terminal.h"

namespace lcpbench {

/// The text of a cell, made of one object of a JSON array: the row of the table.
using JsonCell = std::function<std::string(const Json& row)>;

/// A column of a table that has a row for each object of a JSON array.
struct JsonColumn {
  TextTable::Column column;
  JsonCell cell;
};

/// Shows the field at a path: "time/solve_s" is the field `solve_s` of the field `time`. Strings are shown as they are,
/// null as "-", numbers by `format`. Without it they have to be integers and are shown by format_count(). The cell
/// throws Json::out_of_range if the field is missing.
JsonCell field(const std::string& path, std::string (*format)(double) = nullptr);

/// What a solver is called, whose spec is "name" or "name{settings}": the setting `name` of an external one, else the
/// spec. @param engine  name and version, in place of the name of the solver `engine`; "": not known
std::string solver_label(const std::string& spec, const std::string& engine = "");

/// solver_label() of the fields `solver` and `settings`.
std::string solver_text(const Json& row);

/// The text of a TextTable with these columns.
/// @param rows  an array of objects
/// @param width  characters of a line, or kUnlimited
std::string table_text(const std::vector<JsonColumn>& columns, const Json& rows, int width = text_width());

}  // namespace lcpbench
