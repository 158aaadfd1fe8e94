#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace lcpbench {

/// Iterative refinement of A y = b for one block A, n x n by columns: y in sums of two doubles, and its residual with a
/// bound. The caller solves for the correction.
struct BoundedRefinement {
  /// In memory of the caller's, which only grows.
  BoundedRefinement(std::size_t n, std::vector<double>& memory);

  std::span<double> b_high, b_low, b_error;
  std::span<double> high, low;             ///< y
  std::span<double> sum, rest, roundings;  ///< of the residual: leading and low part, and what bounds its error
  std::span<double> correction;            ///< at first the residual
  std::span<double> bound;                 ///< of the residual's error

  /// b - A y in `correction`, and a bound of its error in `bound`. O(n^2)
  void find_residual(const double* A);
  /// Whether that residual is exactly zero, unless bits may have been lost.
  bool is_zero() const;
  bool may_have_lost_bits(std::span<const double> A) const;
  /// y += correction.
  void correct();
};

}  // namespace lcpbench
