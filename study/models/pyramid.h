#pragma once

#include <vector>

#include "core/contact_problem.h"

namespace lcpbench {

/// The net impulse of every contact along its normal and its two tangents [N s].
struct TangentImpulses {
  Vector normal;         ///< nc
  Vector first, second;  ///< nc, along the tangents; 0 without friction
};

/// The same contacts with friction pyramids of 4 edges, along and against the tangents: directions 0 and edges / 4.
/// @pre why_no_round_cone() is ""
ContactProblem with_tangents(const ContactProblem& problem);

/// The same contacts with regular friction pyramids; those without friction stay so.
/// @param tangents from with_tangents() @param edges a multiple of 4, or 0 for no friction
/// @param angles nc: from the first tangent, towards the second, to the first edge [rad]
ContactProblem with_pyramid(const ContactProblem& tangents, int edges, const std::vector<double>& angles);

/// The impulses in z, an answer to with_pyramid() with the same edges and angles.
TangentImpulses tangent_impulses(const ContactProblem& tangents, int edges, const std::vector<double>& angles,
                                 const Vector& z);

/// The z of `tangents` with these impulses, and with the least lambda that makes its friction rows feasible.
Vector pyramid_impulses(const ContactProblem& tangents, const TangentImpulses& impulses);

/// For each contact the angle, as in with_pyramid(), of the direction against its slip J_t'u + offset + compliance f_t;
/// where it does not slip, that of its friction impulse f_t. @param velocity u = v+ under these impulses
std::vector<double> slip_angles(const ContactProblem& tangents, const TangentImpulses& impulses,
                                const Vector& velocity);

}  // namespace lcpbench
