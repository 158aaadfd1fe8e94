#pragma once

#include "core/contact_problem.h"
#include "core/scene.h"

namespace lcpbench {

// Tests of a simulator's data: sizes and indices, so that no solver reads past an array, and other faults that are as
// cheap to find. Problem files are tested for much more: in a loop that runs a thousand times a second a Cholesky
// factorization of G is too dear.

/// @throws InputError naming body or contact and field. O(bodies + contacts)
void check_usable(const RigidScene& scene);

/// @throws InputError naming the field. O(contacts + blocks of the inertia)
void check_usable(const ContactProblem& contacts);

}  // namespace lcpbench
