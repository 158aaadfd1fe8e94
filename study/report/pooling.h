#pragma once

#include <span>

#include "study/report/choice.h"
#include "study/summary/summary.h"

namespace lcpbench::report {

/// Adds the statistics of one set's solvers at single settings. Hard cases have no pairs: each is one problem, chosen
/// to break solvers. O(pairs x problems).
/// @param problems  of the set
/// @param cells     of the set, with their outcomes
void add_statistics(const Summary& summary, std::size_t problems, std::span<const Cell> cells, Statistics& statistics);

/// Takes the plans from the summary's coverage.
void complete_statistics(const Summary& summary, Statistics& statistics);

}  // namespace lcpbench::report
