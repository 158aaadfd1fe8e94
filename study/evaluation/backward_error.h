#pragma once

#include <cstddef>
#include <optional>

#include "core/lcp.h"
#include "core/quad_matrix.h"
#include "study/evaluation/island_rows.h"

namespace lcpbench {

/// w = M z + q.
QuadVector complement(const Lcp& lcp, const QuadVector& z);

struct BackwardError {
  Quad error = 0;
  /// The first with this error, or whose |z_i| decides tau; none if the error is zero.
  std::optional<std::size_t> row;
};

/// The largest mixed backward error of an island, each measured by itself: the least over tau of max(tau, eta(z_tau)).
///
/// z_tau is z with each entry of magnitude at most tau times the largest magnitude in the island set to zero;
/// eta = max_i viol_i / s_i over the island's rows with viol_i = |w_i| where z_i > 0, else max(0, -w_i),
/// s_i = |q_i| + ||M_i||_1 ||z_tau||_inf, and 0/0 = 0, x/0 = infinity; infinity while an entry below zero remains.
/// The minimum is exact: eta changes only where tau passes one of the ratios |z_i| / largest. O(n^2).
/// @param z  n finite entries, exact. @param w  complement() of it
/// @param islands  of M: no row of one may depend on an entry of another
BackwardError mixed_backward_error(const Lcp& lcp, const QuadVector& z, const QuadVector& w, const IslandRows& islands);

}  // namespace lcpbench
