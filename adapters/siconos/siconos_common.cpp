#include "adapters/siconos/siconos_common.h"

#include <cstdlib>
#include <memory>

extern "C" {
#include <LinearComplementarityProblem.h>
#include <NonSmoothDrivers.h>
#include <NumericsMatrix.h>
#include <SolverOptions.h>
}

namespace lcpbench {
namespace {

Claim claim_of(int info, int iterations, std::int64_t max_iterations) {
  if (info == 0) return Claim::kSolved;
  return iterations >= max_iterations ? Claim::kIterationLimit : Claim::kNumericalFailure;
}

}  // namespace

void FreeOptions::operator()(SolverOptions* options) const {
  solver_options_delete(options);
  std::free(options);
}

void FreeView::operator()(NumericsMatrix* view) const {
  view->matrix0 = nullptr;
  NM_clear(view);
  std::free(view);
}

void run_siconos(const Lcp& lcp, const SiconosRequest& request, Answer& answer) {
  const int n = static_cast<int>(lcp.size());
  if (n == 0) {
    answer.claim = Claim::kSolved;
    return;
  }
  // The interface takes pointers to data that may change; some solvers work in place.
  Matrix M = lcp.M;
  Vector q = lcp.q;
  Vector w = Vector::Zero(n);
  const std::unique_ptr<NumericsMatrix, FreeView> view(NM_create_from_data(NM_DENSE, n, n, M.data()));
  LinearComplementarityProblem problem{n, view.get(), q.data()};
  const std::unique_ptr<SolverOptions, FreeOptions> options(solver_options_create(request.solver));
  options->dparam[SICONOS_DPARAM_TOL] = request.tolerance;
  options->iparam[SICONOS_IPARAM_MAX_ITER] = static_cast<int>(request.max_iterations);
  const int info = linearComplementarity_driver(&problem, answer.z.data(), w.data(), options.get());
  const int iterations = options->iparam[SICONOS_IPARAM_ITER_DONE];
  answer.counters.iterations = iterations;
  answer.claim = claim_of(info, iterations, request.max_iterations);
  if (info != 0) answer.detail = "Siconos info " + std::to_string(info);
}

}  // namespace lcpbench
