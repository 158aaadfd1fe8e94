#pragma once

#include <string>

#include "core/contact_problem.h"

namespace lcpbench {

/// Why the friction directions of a contact name no round cone, or "". They do if their number is a multiple of 4; the
/// tangents are then the directions 0 and edges / 4. If it is more than 4, they must be those of a regular polygon.
std::string why_no_round_cone(const ContactProblem& problem);

/// Friction impulses whose sum is a t1 + b t2 on the two directions of a regular polygon that it lies between.
/// @param f one entry per direction, a multiple of 4
void share_among_directions(double a, double b, Eigen::Ref<Vector> f);

/// Completes the z of impulses along the contacts' normals and tangents: lambda is the least that makes the friction
/// rows feasible, of soft contacts too. @param z f_N and f_D are read @param u the velocity v+ under these impulses
void complete_slip_bounds(const ContactProblem& problem, const ContactLayout& layout, const Vector& u, Vector& z);

}  // namespace lcpbench
