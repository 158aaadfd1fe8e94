#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace lcpbench {

/// The state of an iterative refinement of A y = b for one block A (n x n, by columns), with y in sums of two doubles.
/// The caller writes b and a first y. Then, as often as it takes: find_residual() writes the residual to `correction`,
/// the caller replaces it by an approximate solution of A c = residual, and correct() adds that to y.
struct BoundedRefinement {
  /// Makes `memory` large enough; the spans lie in it, with any content. It must not be resized while this is in use.
  BoundedRefinement(std::size_t n, std::vector<double>& memory);

  std::span<double> b_high, b_low, b_error;  ///< b, off by at most 2 b_error
  std::span<double> high, low;             ///< y
  std::span<double> sum, rest, roundings;  ///< of the residual: leading and low part, and what bounds its error
  std::span<double> correction;            ///< the residual, which the caller replaces by the solution for it
  std::span<double> bound;                 ///< of the residual's error

  /// b - A y in `correction`, and a bound of its error in `bound`. O(n^2)
  void find_residual(const double* A);
  /// Whether b_high + b_low - A y is exactly zero; certain only if may_have_lost_bits() is false.
  bool is_zero() const;
  /// Whether products of A and y may have lost bits to underflow.
  bool may_have_lost_bits(std::span<const double> A) const;
  /// y += correction.
  void correct();
};

}  // namespace lcpbench
