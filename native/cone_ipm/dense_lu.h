#pragma once

#include <vector>

#include "core/types.h"

namespace lcpbench {

/// LU factors of a square matrix by Gaussian elimination with partial pivoting. Only resize() allocates: Eigen's LU
/// takes memory for each factorization of a large matrix.
class DenseLu {
 public:
  /// Takes the memory for matrices of this order.
  void resize(Index order);
  /// The matrix to factor, by columns; holds the factors afterwards.
  Matrix& matrix() { return matrix_; }
  /// O(order^3). False, with the matrix partly factored, where a pivot, or its inverse, is zero or not finite.
  bool factor();
  /// x := A^-1 x, for `order` entries, O(order^2). @pre factor() was true
  void solve(Vector& x) const;

 private:
  bool factor_panel(Index first, Index width);
  void eliminate(Index first);

  Matrix matrix_;
  std::vector<Index> swapped_with_;  // row that each step exchanged with its own
};

}  // namespace lcpbench
