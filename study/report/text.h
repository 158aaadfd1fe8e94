#pragma once

#include <string>
#include <vector>

#include "study/summary/summary.h"
#include "study/statistics/statistics.h"

namespace lcpbench::report {

// Numbers as text for people: 2 or 3 significant digits, with their unit; "–" for one that is not finite.

/// "33.3 %"; never rounded to 0 % or 100 % unless exactly that.
std::string percent(double share);
/// "98.1–100 %"
std::string percent_range(const Interval& interval);
/// "281 µs"
std::string duration(double seconds);
/// A ratio: "40.1", "0.0089"
std::string factor(double value);
/// "3.2e-11"; "no number" for infinity, "–" for NaN.
std::string scientific(double value);
/// "1 problem", "200 problems".
std::string counted(std::int64_t count, const std::string& noun);

/// A file name made from any set name: letters, digits, '.', '-', '_' only.
std::string file_stem(const std::string& name);

/// How many problems are nearly solvable, and what that means; and how often a solver said unsolvable of a solvable
/// problem. Sentences, "" where neither happened.
std::string truth_text(const Summary& summary);

/// "11 %" of a plan: in whole percent, rounded down, so that only a whole plan has 100 %; "<1 %" for less.
std::string plan_share_text(double share);

/// What a store lacks of what its runs planned, for the terminal: whole lines; "" for a store that holds all.
std::string coverage_text(const Coverage& coverage);

/// In what captured problems differ from the steps that their engines took, and how often. A sentence, "" for none.
std::string difference_text(const Summary& summary);

/// Notes at the top of report.html: soft_engine_note() (study/report/sets.h), truth_text() and difference_text(), each
/// unless empty.
std::vector<std::string> notes(const Summary& summary);

}  // namespace lcpbench::report
