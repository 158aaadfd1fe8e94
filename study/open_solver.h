#pragma once

#include <memory>
#include <string>

#include "core/registry.h"
#include "core/timed_solve.h"

namespace lcpbench {

/// Why the solver cannot run here: its library was not found when this was built, or its worker program is
/// missing; "" when it can run.
std::string why_unavailable(const RegisteredSolver& solver);

/// Any registered solver, under the clock: native ones in this process, foreign ones in their worker.
/// @throws InputError for an unknown name, bad settings, or a solver that cannot run here (with the reason).
std::unique_ptr<TimedSolver> open_solver(const Spec& spec);

}  // namespace lcpbench
