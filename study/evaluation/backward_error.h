#pragma once

#include "study/evaluation/quad_lcp.h"

namespace lcpbench {

/// How a row's violation is measured against its data.
enum class BackwardScale {
  kComponentwise,  ///< s_i = |q_i| + sum_j |M_ij| z_j
  kRowNorm,        ///< s_i = |q_i| + ||M_i||_1 ||z||_inf
};

/// Mixed backward error: the least over tau of max(tau, eta(z_tau)).
///
/// z_tau is z with each entry of magnitude at most tau times the largest magnitude in its block (impulses; lambdas) set
/// to zero; eta = max_i viol_i / s_i with viol_i = |w_i| where z_i > 0, else max(0, -w_i), and 0/0 = 0, x/0 = infinity;
/// infinity while an entry below zero remains. With the componentwise scale it is the smallest relative perturbation of
/// (q, M), entry by entry, of which z_tau is an exact solution.
///
/// The minimum is exact: eta changes only where tau passes one of the ratios |z_i| / largest, and ratios are passed
/// over only when a row proves them worse than one already measured.
/// @param z  size() finite entries.
Quad mixed_backward_error(QuadLcp& lcp, const QuadVector& z, BackwardScale scale);

}  // namespace lcpbench
