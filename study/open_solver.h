#pragma once

#include <memory>

#include "core/registry.h"
#include "core/timed_solve.h"

namespace lcpbench {

/// Any registered solver, under the clock: native ones in this process, foreign ones in their worker.
/// @throws InputError for an unknown name, bad settings, or a solver that cannot run here (with the reason).
std::unique_ptr<TimedSolver> open_solver(const Spec& spec);

}  // namespace lcpbench
