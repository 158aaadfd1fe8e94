#pragma once

#include "core/contact_problem.h"

namespace lcpbench {

/// Powers of two S for which S G S has a diagonal within [1, 4), where that of G spans more than 2^50; else empty. The
/// bounds on rounding in the engines of contact_lemke are norms over all coordinates.
Vector coordinate_units(const Inertia& inertia);

/// The same problem for the velocity S^-1 v, bit for bit the same M and q: products with powers of two are exact.
/// @param units S, as coordinate_units gives them; not empty
ContactProblem contact_in_units(const ContactProblem& contact, const Vector& units);

}  // namespace lcpbench
