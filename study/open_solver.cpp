#include "study/open_solver.h"

#include "adapters/worker_client.h"
#include "core/error.h"

namespace lcpbench {

std::unique_ptr<TimedSolver> open_solver(const Spec& spec) {
  const RegisteredSolver& solver = find_solver(spec.name);
  if (!solver.unavailable.empty()) {
    throw InputError("solver '" + spec.name + "' is not available: " + solver.unavailable);
  }
  const Spec canonical = canonical_solver_spec(spec);
  if (solver.native()) return in_process(make_solver(canonical));
  return worker_solver(worker_executable(solver), canonical);
}

}  // namespace lcpbench
