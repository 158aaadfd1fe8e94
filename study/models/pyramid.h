#pragma once

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
ContactProblem with_pyramid(const ContactProblem& tangents, int edges);

/// The impulses in z, an answer to with_pyramid() with the same edges.
TangentImpulses tangent_impulses(const ContactProblem& tangents, int edges, const Vector& z);

/// The z of `tangents` with these impulses, and with the least lambda that makes its friction rows feasible.
Vector pyramid_impulses(const ContactProblem& tangents, const TangentImpulses& impulses);

}  // namespace lcpbench
