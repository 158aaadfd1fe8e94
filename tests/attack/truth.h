#pragma once

#include "core/problem.h"
#include "study/evaluation/evaluation.h"
#include "tests/attack/exact.h"

namespace lcpbench::attack {

/// What is exactly true of a small problem, found without any solver.
struct ExactTruth {
  Truth truth = Truth::kUnknown;
  Vector z{};  ///< contacts with bounded rows: the doubles next to an exact solution
};

/// Bare LCP, mixed or not: always known. Every complementary cone is examined, by branching over the pairs; at each node an exact
/// linear program decides whether the inequalities with the imposed zeros have a point.
///
/// Contact problem: positive definite inertia (leading minors) makes it solvable. Reduced rank, P'f = 0 meaning that f
/// lies in the null space: unsolvable when some u >= 0 has P'N u = 0 and v'N u < 0; solvable when no f in the friction
/// cones has P'f = 0 and v'f < 0. Between the two, and with bounded rows, the cones are examined as for a bare LCP,
/// within bounds; beyond them: unknown.
ExactTruth exact_truth(const Problem& problem);

/// u proves exactly that the problem has no solution. Bare LCP: u >= 0, M'u <= 0, q'u < 0. Contact problem: u >= 0 (nc
/// entries, one per contact), N u in the null space, v'N u < 0. Bounded rows have entries behind those of the contacts,
/// > 0 only without an upper bound, < 0 only without a lower one, 0 with compliance and of friction.
bool disproves(const Problem& problem, const DyadicVector& u);
bool disproves(const Problem& problem, const Vector& u);

/// The bounds of z.
LcpBounds bounds_of_impulses(const ContactProblem& contact);

/// The tangential offset along a direction of a contact of 2 or 4 edges.
Dyadic slip_offset(const ContactProblem& contact, Index c, int direction);

/// G, or G* if only that is given.
DyadicMatrix exact_inertia(const Inertia& inertia);

/// The inverse, or pseudo-inverse, of the inertia.
Inverse exact_response(const Inertia& inertia);

}  // namespace lcpbench::attack
