#pragma once

#include <span>
#include <string>

namespace lcpbench::report {

/// One column of a table; `number` columns are set to the right.
struct Column {
  const char* heading;
  bool number;
};

/// Opens a table in a box that scrolls. Tables of class "cells" sort by their headings. kTableEnd closes it.
std::string table_head(const std::string& cls, std::span<const Column> columns);
inline constexpr const char* kTableEnd = "</tbody></table></div>\n";

/// A numeric cell that sorts by `value`; `detail` is a second, smaller line, already HTML; `attributes` of the cell, each
/// after a blank.
std::string number_cell(double value, const std::string& text, const std::string& detail = {},
                        const std::string& attributes = {});

}  // namespace lcpbench::report
