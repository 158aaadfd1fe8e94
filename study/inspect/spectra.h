#pragma once

#include <limits>
#include <vector>

#include "core/types.h"
#include "core/quad_matrix.h"

namespace lcpbench {

/// What the eigenvalues of a symmetric matrix say, each known to within `rounding`. All NaN where they were not
/// computed; zero for a matrix of order 0.
struct Spectrum {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  double smallest = kNone;
  double largest = kNone;
  double rounding = kNone;          ///< bound on the error of every eigenvalue here
  double smallest_nonzero = kNone;  ///< least magnitude above the rounding; NaN where all are zero
  Index rank = -1;                  ///< eigenvalues whose magnitude is above the rounding; -1: not computed

  bool known() const { return rank >= 0; }
  bool has_negative() const { return smallest < -rounding; }
  bool positive_definite() const { return smallest > rounding; }
  /// No eigenvalue is below zero by more than the rounding.
  bool may_be_semidefinite() const { return smallest >= -rounding; }
};

/// "positive definite", "positive semidefinite to rounding", "indefinite", "negative definite", "zero to rounding",
/// "negative semidefinite to rounding" or "not computed".
const char* definiteness(const Spectrum& spectrum);

/// Up to this order eigenvalues are computed in 113-bit arithmetic (Jacobi's method): what double arithmetic made of a
/// matrix is then seen exactly, for all purposes. At the bound it takes about a second.
inline constexpr Index kLargestQuad = 40;

/// All eigenvalues of a symmetric matrix, ascending, by Jacobi's cyclic rotations. Only the lower triangle is read.
/// O(n^3) a sweep, six to ten sweeps. [Golub, Van Loan 2013, 8.5]
QuadVector eigenvalues(QuadMatrix A);

/// Of a symmetric matrix of doubles: in 113 bits up to kLargestQuad, else in double.
Spectrum spectrum_of(const Matrix& A);

/// Of a symmetric matrix in 113 bits whose entries carry a relative error of `formation_error` (of the largest).
Spectrum spectrum_of(const QuadMatrix& A, double formation_error);

/// A with unit diagonal, D^-1/2 A D^-1/2; rows and columns without a positive diagonal entry become zero. Its condition
/// is the one that no choice of units changes, and within n of the least over all scalings. [van der Sluis 1969]
Matrix unit_diagonal(const Matrix& A);
QuadMatrix unit_diagonal(const QuadMatrix& A);

/// The rank of a matrix of doubles: of its entries, exactly as they are, modulo the prime 2^61 - 1. Never more than the
/// true rank; less only where the prime divides every nonzero minor of that order, for which there is no reason but
/// chance of 2^-61 or so. O(rows cols rank). NaN and infinity must not occur.
Index rank_of_doubles(const Matrix& A);

/// Singular values above `relative` times the largest, of A with columns scaled to length 1; 0 without nonzero columns.
Index numerical_rank(const Matrix& A, double relative);

}  // namespace lcpbench
