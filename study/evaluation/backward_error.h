#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/islands.h"
#include "study/evaluation/quad_lcp.h"

namespace lcpbench {

/// The rows of each island, ascending: RowIslands the other way round.
class IslandRows {
 public:
  explicit IslandRows(const RowIslands& islands);

  std::size_t count() const { return begin_.size() - 1; }
  std::span<const std::size_t> rows(std::size_t island) const {
    return std::span(rows_).subspan(begin_[island], begin_[island + 1] - begin_[island]);
  }

 private:
  std::vector<std::size_t> begin_;
  std::vector<std::size_t> rows_;
};

/// How a row's violation is measured against its data.
enum class BackwardScale {
  kComponentwise,  ///< s_i = |q_i| + sum_j |M_ij| z_j
  kRowNorm,        ///< s_i = |q_i| + ||M_i||_1 ||z||_inf
};

template <class Real>
struct BackwardError {
  Real error = 0;
  std::optional<std::size_t> row;  ///< one that the error is of; none where it is zero. Of a Bounded only a guess
  bool open = false;               ///< it may be larger: of some row nobody knows how much it is violated
};

/// The largest mixed backward error of an island, each measured by itself: the least over tau of max(tau, eta(z_tau)).
///
/// z_tau is z with each entry of magnitude at most tau times the largest magnitude of its kind (impulses; lambdas) in
/// the island set to zero; eta = max_i viol_i / s_i over the island's rows with viol_i = |w_i| where z_i > 0, else
/// max(0, -w_i), and 0/0 = 0, x/0 = infinity; infinity while an entry below zero remains. ||z||_inf is of the island.
/// With the componentwise scale it is the smallest relative perturbation of (q, M), entry by entry, of which z_tau is
/// an exact solution.
///
/// The minimum is exact: eta changes only where tau passes one of the ratios |z_i| / largest, and ratios are passed
/// over only when a row proves them worse than one already measured.
/// @param z  size() finite entries, exact.
/// @param u, w  lcp.response(z), and all_rows() of it.
/// @param islands  no row of one may depend on an entry of another.
template <class Real>
BackwardError<Real> mixed_backward_error(EvaluatedLcp<Real>& lcp, const std::vector<Real>& z,
                                         const std::vector<Real>& u, const std::vector<Real>& w, BackwardScale scale,
                                         const IslandRows& islands);

}  // namespace lcpbench
