#pragma once

#include <span>
#include <string>

#include "core/contact_problem.h"
#include "core/lcp.h"

namespace lcpbench {

/// Whether u (nc) proves that the contact problem has no solution: u >= 0, zero for contacts with normal compliance,
/// N u in the null space of the inertia G, and u'(N'v + b) < 0.
///
/// Then no impulse changes u'(N'v+ + b) < 0, so that some w_N stays negative. N u is in the null space if X'N u = 0 for
/// an inertia by factors, G N u = 0 for a given G, or G* N u = 0 where only G* is known.
///
/// All sums and products of the given doubles are exact (Dyadic): a u whose equalities hold only to rounding proves
/// nothing. False for a u of another length or with entries that are negative or not finite, and for data that are not
/// finite. O(nnz(N) + entries of the inertia) exact operations.
bool proves_unsolvable(const ContactProblem& problem, const Vector& u);

/// A lower bound [m/s] of the largest violation: after any impulses some contact has w_N <= -bound. It is
/// -u'(N'v + b) / sum(u), because u'w_N = u'(N'v + b) < 0 after any impulses. Exact, then rounded down to a double.
/// @pre proves_unsolvable(problem, u)
double least_violation(const ContactProblem& problem, const Vector& u);
/// The same for u (nc) as decimal integers >= 0, which may be too large for doubles. A positive factor common to all
/// changes nothing. @pre u proves that there is no solution
double least_violation(const ContactProblem& problem, std::span<const std::string> u);

/// Whether u (n) proves that the LCP has no solution: u >= 0, M'u <= 0 and q'u < 0, so that no z >= 0 has M z + q >= 0.
/// Exact, and false for bad u or data, as above. O(n^2) exact operations.
bool proves_unsolvable(const Lcp& lcp, const Vector& u);

}  // namespace lcpbench
