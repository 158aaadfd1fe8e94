#pragma once

#include <string>
#include <vector>

#include "study/report/page.h"

namespace lcpbench::report {

/// #speed-error: of each set one point per solver and rung, the frontier, the cheapest solver that meets an error, and
/// how all that moves with conditioning. Steps along a dial of conditioning stand in the latter alone. "" for no set.
std::string speed_error_section(const Summary& summary, const SpeedErrorStudy& study, const Figures& figures);

}  // namespace lcpbench::report
