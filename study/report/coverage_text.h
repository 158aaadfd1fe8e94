#pragma once

#include <string>

#include "study/summary/coverage.h"

// What a reader is told of a store that does not hold all that its runs planned. A whole store has nothing to tell.

namespace lcpbench::report {

/// "11 %": in whole percent, rounded down, so that only a whole plan has 100 %; "<1 %" for less.
std::string plan_share_text(double share);

/// What is missing, for the terminal: whole lines; "" for a store that holds its whole plan.
std::string coverage_text(const Coverage& coverage);

}  // namespace lcpbench::report
