#pragma once

#include <vector>

#include "core/contact_problem.h"

namespace lcpbench::exact {

/// The same contacts in another order and in other units, each contact in its own: what changes the paths of pivoting
/// methods, and which of several solutions they end at.
struct ContactVariant {
  ContactProblem problem;
  std::vector<Index> from;  ///< entry i of its z is entry from[i] of the original's, divided by unit[i]
  std::vector<double> unit;

  /// z of the original problem.
  Vector original(const Vector& z) const;
};

/// Variant 0 has the contacts backwards. The others have them backwards from another one on, and contact i with N_i
/// times 2^a and D_i times 2^b, a and b pseudo-random whole numbers up to 6 in size, a function of `number` and i
/// alone.
ContactVariant contact_variant(const ContactProblem& problem, Index number);

}  // namespace lcpbench::exact
