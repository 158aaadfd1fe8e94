#pragma once

#include <cmath>
#include <cstdint>

#include "core/quad.h"
#include "generators/column_major.h"

// Exact checks that several tests of the generators need.

namespace lcpbench::checks {

/// The integer that `value` is in units of `step`; fails the check `exact` when it is none.
inline std::int64_t in_steps(double value, double step, bool& exact) {
  const double steps = value / step;
  if (!(std::fabs(steps) < 0x1p62) || std::trunc(steps) != steps) {
    exact = false;
    return 0;
  }
  return static_cast<std::int64_t>(steps);
}

/// True when sign * (A - shift I) is positive definite, by a Cholesky factorization (without roots) in Quad.
inline bool definite_after_shift(const ColumnMajor<double>& A, Quad shift, int sign) {
  const std::size_t n = A.rows;
  ColumnMajor<Quad> work(n, n);
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t i = 0; i < n; ++i) work(i, j) = sign * (static_cast<Quad>(A(i, j)) - (i == j ? shift : Quad{0}));
  }
  for (std::size_t k = 0; k < n; ++k) {
    if (!(work(k, k) > 0)) return false;
    for (std::size_t i = k + 1; i < n; ++i) {
      const Quad factor = work(i, k) / work(k, k);
      for (std::size_t j = k + 1; j < n; ++j) work(i, j) -= factor * work(k, j);
    }
  }
  return true;
}

/// True when the smallest eigenvalue lies within `allowed` of `smallest`, and the largest within `allowed` of
/// `largest`.
inline bool spectrum_ends_at(const ColumnMajor<double>& A, double smallest, double largest, double allowed) {
  const Quad slack = allowed;
  return definite_after_shift(A, static_cast<Quad>(smallest) - slack, 1) &&
         !definite_after_shift(A, static_cast<Quad>(smallest) + slack, 1) &&
         definite_after_shift(A, static_cast<Quad>(largest) + slack, -1) &&
         !definite_after_shift(A, static_cast<Quad>(largest) - slack, -1);
}

inline bool symmetric(const ColumnMajor<double>& A) {
  for (std::size_t j = 0; j < A.cols; ++j) {
    for (std::size_t i = 0; i < j; ++i) {
      if (!(A(i, j) == A(j, i))) return false;
    }
  }
  return A.rows == A.cols;
}

}  // namespace lcpbench::checks
