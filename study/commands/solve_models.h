#pragma once

#include <csignal>
#include <string>
#include <vector>

#include "study/commands/options.h"

namespace lcpbench {

/// What `solve --max-velocity-error` asks for.
struct ModelsRequest {
  std::vector<std::string> files;
  double error_m_per_s = 0;
  double time_limit_s = 10.0;
  bool json = false;
  Extent extent;
};

/// Solves each island of each file by the coarsest model of friction whose measured error suffices, and prints it.
/// @returns the exit code: kExitCheckFailed where an island missed the error
int solve_by_models(const ModelsRequest& request, const volatile std::sig_atomic_t* stop);

}  // namespace lcpbench
