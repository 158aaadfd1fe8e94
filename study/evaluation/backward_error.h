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
  std::optional<std::size_t> row;  ///< the first with this error; none if the error is zero
};

/// The largest violation of a row relative to its scale, see LcpRow. O(n^2).
/// @param z  n finite entries, exact. @param w  complement() of it
/// @param islands  of M, which give the largest |z_j| of each row's scale
BackwardError backward_error(const Lcp& lcp, const QuadVector& z, const QuadVector& w, const IslandRows& islands);

}  // namespace lcpbench
