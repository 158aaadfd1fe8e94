#pragma once

#include <string>

#include "study/summary/coverage.h"

// What a reader is told of a store that does not hold all that its runs planned. A whole store has nothing to tell.

namespace lcpbench::report {

/// "11 %": in whole percent, rounded down, so that only a whole plan has 100 %; "<1 %" for less.
std::string plan_share_text(double share);

/// The box at the top of the page, HTML; "" for a store that holds its whole plan.
std::string coverage_html(const Coverage& coverage);

/// The same for the terminal: whole lines; "" for a store that holds its whole plan.
std::string coverage_text(const Coverage& coverage);

/// "11 % of its planned cells are done", of one set; "" where it holds all of them, or nobody knows.
std::string set_coverage(const Coverage& coverage, const std::string& set);

}  // namespace lcpbench::report
