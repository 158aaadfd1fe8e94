#pragma once

#include "core/contact_problem.h"

namespace lcpbench {

/// Mean number of bodies whose removal cuts the bodies of an island in two, as coordinates: those of a level of a
/// breadth-first search over contacts, from a body at an end. A sparse factorization of the island has a dense block of
/// about this order, and costs about its cube. A stack has 6, a wall grows with the root of its bodies, a pile with the
/// power 2/3. O(bodies and contacts). @pre BlockInertia
double separator_size(const ContactProblem& contact);

}  // namespace lcpbench
