#pragma once

#include <string>
#include <vector>

#include "study/report/summary.h"

namespace lcpbench::report {

/// A member of a run's record as text; "not recorded" where it has none.
std::string recorded_value(const RunSummary& run, const char* name);
/// The distinct values of all runs, in the order of their first use.
std::vector<std::string> recorded_values(const Summary& summary, const char* name);

/// #provenance: machine, compiler, source, time and size of the study in a short table, the solvers left out, and the
/// full record of the latest run, folded.
std::string provenance_section(const Summary& summary);

}  // namespace lcpbench::report
