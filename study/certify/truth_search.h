#pragma once

#include "study/certify/candidates.h"
#include "study/certify/certificate.h"
#include "study/certify/deadline.h"

namespace lcpbench::exact {

/// Certifies a problem.
///
/// A bare LCP: bases from `lemke` in double and quad, exact Lemke up to an order that it can be afforded for, branch
/// and bound until the deadline.
///
/// Contacts without friction, and M proven semidefinite: complete. A basis from `active_set`, corrected by exact
/// exchanges if it is wrong; a contradiction from the nonnegative least squares problem min |L u|^2 + (1 + q'u)^2,
/// which has the residual 0 exactly when the problem is unsolvable; last, exact Lemke on M with its potentials
/// eliminated.
///
/// Contacts with friction: bases from `contact_lemke` and `lemke`; the contradiction of the normals alone; the velocity
/// inside the dual friction cones, the solution of a frictionless problem whose contacts are the cones' edges; for few
/// unknowns exact Lemke; branch and bound until the deadline.
/// @pre finite data. @throws TimePassed
Certificate search_truth(const Problem& problem, const CertifyOptions& options, const Deadline& deadline,
                         Candidates& candidates);

}  // namespace lcpbench::exact
