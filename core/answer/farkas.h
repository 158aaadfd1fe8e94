#pragma once

#include "core/contact_problem.h"
#include "core/lcp.h"

namespace lcpbench {

// Proofs in doubles that a problem has no solution. All sums are exact (ExactSum): a u whose equalities hold only to
// rounding proves nothing. False for a u of another length or with entries that are negative or not finite, and for
// data that are not finite.

/// Whether u (nc) proves that the contact problem has no solution: u >= 0, zero for contacts with compliance,
/// (N'v + b)'u < 0, and N u in the null space of the inertia. No impulse then changes u'w_N, and f_N >= 0 asks for
/// w_N >= 0. In the null space if X'N u = 0 for an inertia by factors, G N u = 0 for a given G, or G* N u = 0 where
/// only G* is known. O(nnz(N)) exact products, and as many more for each column of an inertia, or block, that N u
/// meets.
/// @param v  in place of the velocity before the impact
bool proves_unsolvable(const ContactProblem& problem, const Vector& v, const Vector& u);
inline bool proves_unsolvable(const ContactProblem& problem, const Vector& u) {
  return proves_unsolvable(problem, problem.v, u);
}

/// Whether u (n) proves that the LCP has no solution: u >= 0, M'u <= 0 and q'u < 0, so that no z >= 0 has M z + q >= 0.
/// False for a mixed LCP. O(n^2) exact products.
bool proves_unsolvable(const Lcp& lcp, const Vector& u);

/// |q'u| / sum_i u_i max(|q_i|, F_i) of a proof u for a bare LCP, F_i its floors (lcp_floors()): by so much of its own
/// size the problem misses a solution. Rounded to a double. O(n^2) @pre proves_unsolvable(lcp, u)
double proof_margin(const Lcp& lcp, const Vector& u);

/// A lower bound [m/s] of the largest violation: after any impulses some contact has w_N <= -bound. It is
/// -u'(N'v + b) / sum(u), because u'w_N = u'(N'v + b) < 0 after any impulses, rounded down to a double.
/// @pre proves_unsolvable(problem, u)
double least_violation(const ContactProblem& problem, const Vector& u);

}  // namespace lcpbench
