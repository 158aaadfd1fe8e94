#pragma once

#include <cstddef>
#include <vector>

#include "core/contact_problem.h"

namespace lcpbench::exact {

// Where other solutions of a contact problem are looked for.

/// The bases of all combinations of what each contact may do: part (with and without a slip bound at work), slide along
/// one friction column, or stick between two neighbouring ones (one, where there are but two). None when there would be
/// more than `limit`.
std::vector<std::vector<Index>> contact_modes(const ContactProblem& problem, std::size_t limit);

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
