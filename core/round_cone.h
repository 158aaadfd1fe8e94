#pragma once

#include <string>

#include "core/contact_problem.h"

namespace lcpbench {

/// Why the friction directions of some contact do not define a round cone, or "". A contact with friction needs a
/// multiple of 4 directions; its tangents t1 and t2 are then the directions 0 and edges / 4. More than 4 must form a
/// regular polygon in these tangents, to 1e-12 of the longer one: edge_direction() rounds to 2^-40, which is 9.1e-13.
/// t1 and t2 may not be the same direction, to 1e-12. Whether they are orthonormal is not tested.
std::string why_no_round_cone(const ContactProblem& problem);

/// Sets f >= 0, the impulses along the directions of a contact, so that their vector sum is a t1 + b t2. Only the two
/// directions next to that vector get an impulse. The entries add up to at least its length.
/// @param a, b [N s] @param f one entry per direction of a regular polygon, a multiple of 4
void share_among_directions(double a, double b, Eigen::Ref<Vector> f);

/// Sets the lambda in z to the least values >= 0 for which all friction rows of w are >= 0, with compliance and
/// tangential offsets. @param z its f_D is read, its lambda is written @param u the velocity v+ under its impulses
void complete_slip_bounds(const ContactProblem& problem, const ContactLayout& layout, const Vector& u, Vector& z);

}  // namespace lcpbench
