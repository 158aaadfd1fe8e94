#pragma once

// Shared by the adapters of Siconos: owners of what its C interface allocates, options, and what a return value claims.

#include <cstdlib>
#include <memory>

extern "C" {
#include <NonSmoothDrivers.h>
#include <NumericsMatrix.h>
#include <SolverOptions.h>
}

#include "core/solver.h"

namespace lcpbench {

struct FreeOptions {
  void operator()(SolverOptions* options) const {
    solver_options_delete(options);
    std::free(options);
  }
};

/// The options of a solver by its number in Siconos's list, with a tolerance and a limit on iterations.
inline auto siconos_options(int solver, double tolerance, std::int64_t max_iterations) {
  std::unique_ptr<SolverOptions, FreeOptions> options(solver_options_create(solver));
  options->dparam[SICONOS_DPARAM_TOL] = tolerance;
  options->iparam[SICONOS_IPARAM_MAX_ITER] = static_cast<int>(max_iterations);
  return options;
}

struct FreeMatrix {
  void operator()(NumericsMatrix* matrix) const {
    NM_clear(matrix);
    std::free(matrix);
  }
};

struct FreeView {
  void operator()(NumericsMatrix* view) const {
    view->matrix0 = nullptr;
    FreeMatrix{}(view);
  }
};

/// A matrix without entries, to which NM_entry adds.
inline NumericsMatrix* siconos_sparse(Index rows, Index columns) {
  NumericsMatrix* matrix = NM_create(NM_SPARSE, static_cast<int>(rows), static_cast<int>(columns));
  NM_triplet_alloc(matrix, 0);
  return matrix;
}

/// Siconos's view of a square matrix that stays ours: columns one after the other, as Eigen has them.
inline std::unique_ptr<NumericsMatrix, FreeView> siconos_view(Matrix& M) {
  const int n = static_cast<int>(M.rows());
  return std::unique_ptr<NumericsMatrix, FreeView>(NM_create_from_data(NM_DENSE, n, n, M.data()));
}

/// What an adapter claims after `info`, the word of a driver.
inline Claim siconos_claim(int info, std::int64_t iterations, std::int64_t max_iterations) {
  if (info == 0) return Claim::kSolved;
  return iterations >= max_iterations ? Claim::kIterationLimit : Claim::kNumericalFailure;
}

}  // namespace lcpbench
