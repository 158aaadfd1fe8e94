#pragma once

#include <Eigen/Core>
#include <Eigen/QR>

#include "native/lemke/pack.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// The shortest of the x that minimize |A x - b|, for a square A that elimination found singular: by a complete
/// orthogonal decomposition, whose rank is numerical. O(order^3). Takes memory, and is there in double only: the rules
/// of 2012 are.
template <class Scalar>
struct LeastSquares {
  template <class Entry, class Side>
  static bool solve(Count, Entry, Side, Scalar*) {
    return false;
  }
};

template <>
struct LeastSquares<double> {
  /// @param A, b  A(row, column) and b(row)
  template <class Entry, class Side>
  static bool solve(Count order, Entry A, Side b, double* x) {
    Eigen::MatrixXd matrix(order, order);
    Eigen::VectorXd side(order);
    for (Count r = 0; r < order; ++r) {
      side(r) = b(r);
      for (Count c = 0; c < order; ++c) matrix(r, c) = A(r, c);
    }
    if (!matrix.allFinite() || !side.allFinite()) return false;
    const Eigen::VectorXd shortest = matrix.completeOrthogonalDecomposition().solve(side);
    for (Count c = 0; c < order; ++c) x[c] = shortest(c);
    return true;
  }
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
