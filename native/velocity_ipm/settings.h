#pragma once

#include "core/settings.h"

namespace lcpbench {

/// How the Newton matrix is factored; kAuto: sparse for block inertia with a sparse N, which every scene has.
enum class Algebra { kAuto, kDense, kSparse };

void visit_algebra(auto&& field, Algebra& algebra) {
  field("algebra", algebra,
        Choices<Algebra>{{{"auto", Algebra::kAuto}, {"dense", Algebra::kDense}, {"sparse", Algebra::kSparse}}},
        "Cholesky of the Newton matrix; auto: sparse for block inertia with a sparse N; sparse needs block inertia");
}

/// Visits two settings that solvers share, bounds of the velocity residual relative to the scale of the island (see
/// ContactScale): `tolerance` ends the iteration, and only up to `accept_residual` is an answer claimed as solved.
void visit_residuals(auto&& field, double& tolerance, double& accept_residual) {
  field("tolerance", tolerance, RealRange{.min = 0},
        "stop when the velocity residual of every island is at most this times the scale of the island");
  field("accept_residual", accept_residual, RealRange{.min = 0},
        "claim solved only when the velocity residual of every island, evaluated in double, is at most this times "
        "the scale of the island");
}

/// Settings of the interior-point method, whatever factors its systems.
struct InteriorPointSettings {
  double tolerance = 1e-9;
  double accept_residual = 3e-5;
  bool finish = true;
  std::int64_t max_iterations = 100;

  void visit(auto&& field) {
    visit_residuals(field, tolerance, accept_residual);
    field("finish", finish, "go on from the pressed contacts to full accuracy");
    field("max_iterations", max_iterations, IntegerRange{.min = 0}, "predictor-corrector steps");
  }
};

}  // namespace lcpbench
