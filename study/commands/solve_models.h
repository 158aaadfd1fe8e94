#pragma once

#include <string>
#include <vector>

namespace lcpbench {

/// `solve --max-velocity-error`: solves each island of each file by the first model of kClimbed (study/models/ladder.h)
/// whose measured error suffices, and prints it.
/// @param time_limit_s  of each solve
/// @returns the exit code: kExitCheckFailed where the answer to a problem, as a whole, misses the error, unless an
/// input was bad or an interrupt came
int solve_by_models(const std::vector<std::string>& files, double error_m_per_s, double time_limit_s, bool json);

}  // namespace lcpbench
