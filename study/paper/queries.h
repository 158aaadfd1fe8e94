#pragma once

#include <string>

#include "study/paper/published.h"

namespace lcpbench::paper {

// SQL over the store's views that repeats what a table counts. Each is one SELECT.

/// Per set and swept solver: parameterisations, trials of the first, worst, average and best share by both measures.
std::string rates_query(Kind kind);
/// Per set and swept solver: counts, means and maxima of time and violation over all parameterisations.
std::string measurements_query();
/// Per set, swept solver and parameterisation: trials, solved by both measures, unsolvable.
std::string cells_query();
/// Per set and solver, swept or not: trials, solved by both measures, unsolvable, false claims.
std::string totals_query();

}  // namespace lcpbench::paper
