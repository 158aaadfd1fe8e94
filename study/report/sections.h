#pragma once

#include <string>

#include "study/report/summary.h"

namespace lcpbench::report {

// The parts of the report behind its first screen, each an HTML section with its anchor, its
// details folded.

/// #claims: what each solver said against what was true.
std::string claims_section(const Summary& summary);
/// #times: what the parts of a time are, with their means.
std::string times_section(const Summary& summary);
/// #definitions
std::string definitions_section();
/// #limits
std::string limits_section(const Summary& summary);

}  // namespace lcpbench::report
