#pragma once

#include <string>
#include <vector>

namespace lcpbench {

/// `solve --max-velocity-error`: solves each island of each file by the coarsest model of friction whose measured error
/// suffices, and prints it.
/// @returns the exit code: kExitCheckFailed where an island missed the error
int solve_by_models(const std::vector<std::string>& files, double error_m_per_s, double time_limit_s, bool json);

}  // namespace lcpbench
