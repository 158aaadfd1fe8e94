#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "study/summary/summary.h"
#include "study/statistics/statistics.h"

namespace lcpbench::report {

// Numbers as a reader takes them in: 2 or 3 significant digits, with their unit; "–" where there is none.

/// "33.3 %"; never rounded to 0 % or 100 % unless exactly that.
std::string percent(double share);
/// "98.1–100 %"
std::string percent_range(const Interval& interval);
/// "281 µs"
std::string duration(double seconds);
/// "270–290 µs", or "51.0 µs–2.74 ms" where one unit would cost the lower end its digits.
std::string duration_range(double low_s, double high_s);
/// "40.1", "0.0089"
std::string factor(double value);
/// A time relative to a reference's: "40.1× faster", "2.5× slower", "same time" within 5 %.
std::string speed(double time_ratio);
/// The same before the name of what it is compared with: "40.1× faster than", "in the same time as".
std::string speed_against(double time_ratio);
/// "3.2e-11"; "no number" for infinity.
std::string scientific(double value);
/// "1 problem", "200 problems".
std::string counted(std::int64_t count, const std::string& noun);

/// The text as well-formed UTF-8 that XML allows: broken bytes and control characters become U+FFFD.
std::string mended(std::string_view text);
/// Mended, and escaped for element content and quoted attributes of HTML and XML.
std::string escape(std::string_view text);
/// <code>text</code>, escaped.
std::string code(std::string_view text);
/// A solver's name that a narrow column breaks before its settings, not within a word.
std::string breakable_name(const SolverRow& solver);

/// How many problems are nearly solvable, and what that means; and how often a solver said unsolvable of a solvable
/// problem. Sentences, "" where neither happened.
std::string truth_text(const Summary& summary);
/// What a set is, in words a roboticist uses: "Frictional contacts, inertia condition number 1e8".
std::string describe(const SetSummary& set);
/// A file name made from any set name: letters, digits, '.', '-', '_' only.
std::string file_stem(std::string_view name);

/// Where a picture stands below the report's folder, made unique: different names may differ only in characters that
/// file_stem() leaves out.
std::string figure_file(const std::string& stem, const std::string& ending, std::set<std::string>& taken);

/// One column of a table; `number` columns are set to the right.
struct Column {
  std::string heading;  ///< HTML
  bool number = false;
};

/// Opens a table in a box that scrolls. Tables of class "cells" sort by their headings. kTableEnd closes it.
/// @param cls  "" for none
/// @param columns  none: a table without headings
/// @param caption  HTML
std::string table_head(const std::string& cls, const std::vector<Column>& columns, const std::string& caption = {});
inline constexpr const char* kTableEnd = "</tbody></table></div>\n";

/// A numeric cell that sorts by `value`; `detail` is a second, smaller line, already HTML; `attributes` of the cell,
/// each after a blank.
std::string number_cell(double value, const std::string& text, const std::string& detail = {},
                        const std::string& attributes = {});

}  // namespace lcpbench::report
