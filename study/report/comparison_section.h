#pragma once

#include <string>
#include <vector>

#include "study/report/solver_comparison.h"
#include "study/report/page.h"

namespace lcpbench::report {

/// #comparison: the solvers of each set against each other on the same problems, one collapsed part per set, and the
/// queries that repeat its counts. "" where there is none.
std::string comparison_section(const Summary& summary, const std::vector<SetComparison>& comparisons,
                               const Figures& figures);

}  // namespace lcpbench::report
