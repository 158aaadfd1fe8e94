#pragma once

#include <cmath>

#include "core/solver.h"
#include "core/types.h"

namespace lcpbench {

/// Factors the lower triangle of A in place as L L'; false, with A spoiled, when a pivot is not positive and finite.
/// Column by column, so that nothing is allocated.
inline bool cholesky_in_place(Matrix& A) {
  const Index n = A.rows();
  for (Index j = 0; j < n; ++j) {
    A.col(j).tail(n - j).noalias() -= A.block(j, 0, n - j, j) * A.row(j).head(j).transpose();
    const double pivot = A(j, j);
    if (!(pivot > 0) || !std::isfinite(pivot)) return false;
    A.col(j).tail(n - j) /= std::sqrt(pivot);
  }
  return true;
}

/// x := (L L')^-1 x. Reads the lower triangle of L alone.
inline void solve_with_factor(const Matrix& L, Vector& x) {
  L.triangularView<Eigen::Lower>().solveInPlace(x);
  L.transpose().triangularView<Eigen::Upper>().solveInPlace(x);
}

/// Factors `newton` into `factor`. Where it is not positive definite, multiples of the identity are added, relative to
/// its largest diagonal entry: from the rounding error of the entries to what dominates them. False when none helps.
inline bool factor_with_corrections(const Matrix& newton, Matrix& factor, Counters& counters) {
  constexpr double kFirstCorrection = 1e-15;
  constexpr double kCorrectionGrowth = 100.0;
  constexpr double kLastCorrection = 1e3;
  const double largest = newton.diagonal().cwiseAbs().maxCoeff();
  for (double correction = 0; correction <= kLastCorrection;
       correction = correction > 0 ? correction * kCorrectionGrowth : kFirstCorrection) {
    factor = newton;
    factor.diagonal().array() += correction * largest;
    ++counters.factorizations;
    if (cholesky_in_place(factor)) return true;
  }
  return false;
}

}  // namespace lcpbench
