#pragma once

#include "core/settings.h"

namespace lcpbench {

/// Visits the setting that solvers share: the velocity residual, relative to the scale of the island (see ContactScale),
/// at which the iteration ends.
void visit_tolerance(auto&& field, double& tolerance) {
  field("tolerance", tolerance, RealRange{.min = 0},
        "stop when the velocity residual of every island is at most this times the scale of the island");
}

/// Settings of the interior-point method, whatever factors its systems.
struct InteriorPointSettings {
  double tolerance = 1e-9;
  bool finish = true;
  std::int64_t max_iterations = 100;

  void visit(auto&& field) {
    visit_tolerance(field, tolerance);
    field("finish", finish, "go on from the pressed contacts to full accuracy");
    field("max_iterations", max_iterations, IntegerRange{.min = 0}, "predictor-corrector steps");
  }
};

}  // namespace lcpbench
