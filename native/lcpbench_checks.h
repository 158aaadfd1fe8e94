#pragma once

#include "core/contact_problem.h"
#include "core/scene.h"

namespace lcpbench {

// What a simulator's data must keep so that no solver reads past an array, and what costs as little to test. Problem
// files are tested for much more: in a loop that runs a thousand times a second a Cholesky factorization of G is too
// dear.

/// @throws InputError naming body or contact and field. O(bodies + contacts)
void check_usable(const RigidScene& scene);

/// @throws InputError naming the field. O(contacts)
void check_usable(const ContactProblem& contacts);

}  // namespace lcpbench
