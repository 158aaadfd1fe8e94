#include "study/evaluation/mixed_errors.h"

#include <algorithm>

#include "core/mixed_lcp.h"
#include "core/quad.h"

namespace lcpbench {

Errors mixed_errors(const Lcp& lcp, const Vector& z) {
  const MixedError<Quad> error = mixed_error(lcp, std::vector<Quad>(z.begin(), z.end()));
  Errors errors;
  errors.usable = true;
  errors.natural_residual = to_double(error.natural);
  errors.backward_row_norm = to_double(error.backward);
  errors.decide(kSolvedBackwardError);
  if (error.row >= 0) errors.worst = {.row = error.row, .z = z(error.row), .w = to_double(error.w)};
  return errors;
}

bool has_friction(const Lcp& lcp) {
  const std::vector<int>& of = lcp.bounds.friction_of;
  return std::any_of(of.begin(), of.end(), [](int row) { return row >= 0; });
}

}  // namespace lcpbench
