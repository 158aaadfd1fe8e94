#pragma once

#include "study/certify/candidates.h"
#include "study/certify/certificate.h"
#include "study/certify/deadline.h"

namespace lcpbench::exact {

/// Certifies a bare LCP: bases from `lemke` in double and quad, branch and bound, exact Lemke, the contradiction of its
/// inequalities, and the enumeration of all cones, each of the last three up to an order that it can be afforded for.
/// @pre finite data
Certificate certify_bare(const Problem& problem, const Deadline& deadline, Candidates& candidates);

/// Certifies a contact problem.
///
/// Without friction, and M proven semidefinite: complete. A basis from `active_set`, corrected by exact exchanges if it
/// is wrong; a contradiction from the nonnegative least squares problem min |L u|^2 + (1 + q'u)^2, which has the
/// residual 0 exactly when the problem is unsolvable; last, exact Lemke on M with its potentials eliminated.
///
/// With friction: bases from `contact_lemke` and `lemke`; the contradiction of the normals alone; the velocity inside
/// the dual friction cones, the solution of a frictionless problem whose contacts are the cones' edges; the same
/// solvers on variants of the problem; for few contacts all combinations of their modes; for few unknowns exact Lemke
/// and the enumeration of cones.
/// @pre finite data
Certificate certify_contact(const Problem& problem, const CertifyOptions& options, const Deadline& deadline,
                            Candidates& candidates);

}  // namespace lcpbench::exact
