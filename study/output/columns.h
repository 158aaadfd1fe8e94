#pragma once

#include <functional>
#include <string>
#include <vector>

#include "study/output/json_output.h"
#include "study/output/terminal.h"

namespace lcpbench {

/// What a table shows of one row of a JSON document.
using JsonCell = std::function<std::string(const Json& row)>;

/// A column of a table over the rows of a JSON document.
struct JsonColumn {
  TextTable::Column column;
  JsonCell cell;
};

/// Shows a field: "time/solve_s" is one inside another. Texts are shown as they are, null as "-", numbers by `format`,
/// without it as counts.
JsonCell field(const std::string& path, std::string (*format)(double) = nullptr);

/// "name" or "name{settings}" of the fields `solver` and `settings`.
std::string solver_text(const Json& row);

/// The table of a document's rows. @param width  characters of a line; kUnlimited: no end
std::string table_text(const std::vector<JsonColumn>& columns, const Json& rows, int width = text_width());

}  // namespace lcpbench
