#include "study/open_solver.h"

#include "adapters/worker_client.h"
#include "core/error.h"

namespace lcpbench {

std::string why_unavailable(const RegisteredSolver& solver) {
  if (!solver.unavailable.empty() || solver.native()) return solver.unavailable;
  try {
    worker_executable(solver);
    return "";
  } catch (const InputError&) {
    return "its worker " + solver.worker + " is missing or not executable";
  }
}

std::unique_ptr<TimedSolver> open_solver(const Spec& spec) {
  const RegisteredSolver& solver = find_solver(spec.name);
  if (const std::string reason = why_unavailable(solver); !reason.empty()) {
    throw InputError("solver '" + spec.name + "' is not available: " + reason);
  }
  const Spec canonical = canonical_solver_spec(spec);
  if (solver.native()) return in_process(make_solver(canonical));
  return worker_solver(worker_executable(solver), canonical);
}

}  // namespace lcpbench
