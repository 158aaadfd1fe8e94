#pragma once

#include <vector>

#include "core/contact_problem.h"

namespace lcpbench::exact {

/// A contact problem with its contacts in another order.
struct ContactOrder {
  ContactProblem problem;
  std::vector<Index> from;  ///< entry i of its z is entry from[i] of the original's

  /// z of the original problem.
  Vector original(const Vector& z) const;
};

/// The contacts backwards from number `shift` - 1, cyclically: another order for each shift
/// in [0, nc).
ContactOrder rotated(const ContactProblem& problem, Index shift);

}  // namespace lcpbench::exact
