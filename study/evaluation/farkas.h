#pragma once

#include <span>
#include <string>

#include "core/contact_problem.h"
#include "core/lcp.h"

namespace lcpbench {

/// Whether u proves, in exact dyadic arithmetic on the doubles given, that no solution exists.
///
/// Contact problem: u (nc) >= 0, N u in null(G) and (N'v + b)'u < 0. No impulse can then change u'(N'v+ + b) =
/// u'(N'v + b) < 0, so some w_N stays negative. null(G): X'N u = 0 for factors (those of alpha = 0 left out), G N u = 0
/// for a given G, G* N u = 0 where only G* is known (G symmetric).
/// Every number is a double, so sums and products are exact integers times a power of two; a u whose equalities hold
/// only to rounding proves nothing. False for a u of another length or with NaN, infinite or
/// negative entries, and for data that are not finite.
/// O(nnz(N) + ngc^2) exact operations.
bool proves_unsolvable(const ContactProblem& problem, const Vector& u);

/// How far any impulses at all leave some contact violated where u proves that there is no solution: the normal
/// velocities w after them have u'w = u'(N'v + b) < 0, so that the least of them is at most u'(N'v + b) / sum(u).
/// Exact, then rounded down. [m/s] @pre u (nc) proves it
double least_violation(const ContactProblem& problem, const Vector& u);
/// The same of decimal integers, which may have any positive factor in common.
double least_violation(const ContactProblem& problem, std::span<const std::string> u);

/// Bare LCP: u (n) >= 0, M'u <= 0 and q'u < 0, so that no z >= 0 has M z + q >= 0. O(n^2) exact operations.
bool proves_unsolvable(const Lcp& lcp, const Vector& u);

}  // namespace lcpbench
