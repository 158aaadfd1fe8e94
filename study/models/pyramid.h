#pragma once

#include <vector>

#include "core/contact_problem.h"

namespace lcpbench {

/// Friction of every contact as impulses along its two tangents.
struct TangentImpulses {
  Vector normal;         ///< nc
  Vector first, second;  ///< nc, 0 without friction
};

/// The same contacts with two tangents each, as a pyramid of 4 edges: the tangents are the directions 0 and edges / 4.
/// @pre why_no_round_cone() is ""
ContactProblem with_tangents(const ContactProblem& problem);

/// The same contacts with a regular pyramid of `edges`, whose first edge stands at `angles` (nc) to the first tangent.
/// @param edges a multiple of 4, or 0: without friction @pre each contact of `tangents` has 4 edges or none
ContactProblem with_pyramid(const ContactProblem& tangents, int edges, const std::vector<double>& angles);

/// Of z of with_pyramid(), with the same edges and angles.
TangentImpulses tangent_impulses(const ContactProblem& tangents, int edges, const std::vector<double>& angles,
                                 const Vector& z);

/// z of the tangents' problem, lambda by the slips at the velocity that follows.
Vector pyramid_impulses(const ContactProblem& tangents, const TangentImpulses& impulses);

/// For each contact the angle against its slip; where it does not slip, that of its friction impulse.
std::vector<double> slip_angles(const ContactProblem& tangents, const TangentImpulses& impulses,
                                const Vector& velocity);

}  // namespace lcpbench
