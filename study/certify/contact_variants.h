#pragma once

#include <cstddef>
#include <vector>

#include "core/contact_problem.h"

namespace lcpbench::exact {

// Where other solutions of a contact problem are looked for.

/// For each combination of what the contacts may do (open, stick, slide along a direction), the i whose z_i may be
/// positive. None when there would be more than `limit`.
std::vector<std::vector<Index>> contact_modes(const ContactProblem& problem, std::size_t limit);

/// The same contacts in another order and in other units, each contact in its own: what changes the paths of pivoting
/// methods, and which of several solutions they end at. Variant 0 has the contacts backwards. The others have them
/// backwards from another one on, and N_i times 2^a and D_i times 2^b, a and b whole numbers up to 6 in size, a
/// function of variant and contact.
struct ContactVariant {
  ContactVariant(const ContactProblem& original, Index number);
  /// z of the original problem.
  Vector of_original(const Vector& z) const;

  std::vector<Index> order;  ///< contact i is contact order[i] of the original
  Vector normal, friction;   ///< units of each contact
  ContactProblem problem;
};

}  // namespace lcpbench::exact
