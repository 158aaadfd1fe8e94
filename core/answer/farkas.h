#pragma once

#include "core/contact_problem.h"
#include "core/lcp.h"

namespace lcpbench {

// Proofs in doubles that a problem has no solution. All sums are exact (ExactSum): a u whose equalities hold only to
// rounding proves nothing. False for a u of another length or with entries that are negative or not finite, and for
// data that are not finite.

/// Whether u, one weight for each contact and then for each bounded row, proves that the contact problem has no
/// solution: with J = [N R], u'(J'v + b) < 0 and J u in the null space of the inertia, so that no impulse changes u'w,
/// and yet u'w >= 0 in every solution. That is so where weights of contacts are >= 0, those of rows > 0 only where the
/// impulse has no upper bound (then w >= 0), < 0 only where it has no lower one, and 0 where the contact or row yields
/// and for rows of friction. In the null space if X'J u = 0 for an inertia by factors, G J u = 0 for a given G, or
/// G* J u = 0 where only G* is known. O(nnz(J)) exact products, and as many more for each column of an inertia, or
/// block, that J u meets.
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

/// A lower bound of the largest violation: after any impulses some contact has w_N <= -bound [m/s], or a bounded row
/// misses its w by as much [m/s, rad/s]. It is -u'(J'v + b) / sum |u|, because u'w = u'(J'v + b) < 0 after any impulses,
/// rounded down to a double.
/// @pre proves_unsolvable(problem, u)
double least_violation(const ContactProblem& problem, const Vector& u);

}  // namespace lcpbench
