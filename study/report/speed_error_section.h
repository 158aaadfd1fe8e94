#pragma once

#include <string>
#include <vector>

#include "study/report/page.h"

namespace lcpbench::report {

/// #speed-error: one row per set; per set, folded, one point and one row per solver and rung, the frontier, the cheapest
/// solver that meets an error, and the sweeps; then how all that moves with conditioning. The hard cases have a section
/// of their own, and "" is returned where there is nothing else.
std::string speed_error_section(const Summary& summary, const SpeedErrorStudy& study, const Figures& figures);

}  // namespace lcpbench::report
