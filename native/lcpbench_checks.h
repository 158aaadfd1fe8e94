#pragma once

#include "core/contact_problem.h"
#include "core/scene.h"

namespace lcpbench {

// Tests of a simulator's data: sizes and indices, so that no solver reads past an array, and other faults that are as
// cheap to find. Problem files are tested for much more, which is too slow for a loop of a thousand steps per second: a
// Cholesky factorization of G, for example.

/// @throws InputError naming body or contact and field. O(bodies + contacts)
void check_usable(const RigidScene& scene);

/// Does not look for NaN and infinity in v, N, D, b, offset_t, the inertia, and R and b of bounded rows: see why_not()
/// of core/solver.h. @throws InputError naming the field. O(contacts + rows + blocks of the inertia)
void check_usable(const ContactProblem& contacts);

}  // namespace lcpbench
