#pragma once

#include <limits>
#include <vector>

#include "core/quad_matrix.h"
#include "core/types.h"
#include "study/output/json_output.h"

namespace lcpbench {

inline constexpr double kIllConditioned = 1e8;  ///< half of the digits of a double

/// Least and largest of some positive magnitudes; both NaN where there are none.
struct Range {
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = low;

  void add(double magnitude);
  /// high / low; NaN where there are none.
  double spread() const { return high / low; }
};

Json range_json(const Range& range);

/// What the eigenvalues of a symmetric matrix say, each known to within `rounding`. All NaN where they were not
/// computed, or an entry of the matrix is not finite; zero for a matrix of order 0.
struct Spectrum {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  double smallest = kNone;
  double largest = kNone;
  double rounding = kNone;          ///< bound on the error of every eigenvalue here
  double smallest_nonzero = kNone;  ///< least magnitude above the rounding; NaN where all are zero
  Index rank = -1;                  ///< eigenvalues whose magnitude is above the rounding; -1: not computed

  bool has_negative() const { return smallest < -rounding; }
  bool positive_definite() const { return smallest > rounding; }
  /// No eigenvalue is below zero by more than the rounding.
  bool may_be_semidefinite() const { return smallest >= -rounding; }
};

/// With the definiteness in words: "positive semidefinite to rounding".
Json spectrum_json(const Spectrum& spectrum);

/// Largest / smallest nonzero |eigenvalue|; NaN where all are zero.
double nonzero_condition(const Spectrum& spectrum);

/// Up to this order eigenvalues are computed in 113-bit arithmetic (Jacobi's rotations) [Golub, Van Loan 2013, 8.5]:
/// those of a matrix of doubles then err by far less than rounding in double. This order takes about 30 ms.
inline constexpr Index kLargestQuad = 40;

/// Of a symmetric matrix of doubles: in 113 bits up to kLargestQuad, else in double.
Spectrum spectrum_of(const Matrix& A);

/// Of a symmetric matrix in 113 bits, above kLargestQuad in double. `rounding` covers what the entries are off by.
/// @param formation_error  what an entry of A may be off by, in units of the largest magnitude in A
Spectrum spectrum_of(const QuadMatrix& A, double formation_error);

/// The symmetric A scaled to unit diagonal, D^-1/2 A D^-1/2; rows and columns without a positive diagonal entry become
/// zero. No choice of units changes its condition, which for positive definite A is at most n times the least over all
/// diagonal scalings. [van der Sluis 1969] In 113 bits, as rounding in double would make a singular A regular.
QuadMatrix unit_diagonal(const QuadMatrix& A);

/// The rank of a matrix of doubles, of its exact entries modulo the largest prime below 2^62. Never more than the true
/// rank, and less only if the prime divides every nonzero minor of that order: by chance, a probability of about 2^-62.
/// O(rows cols rank). @pre A is finite
Index rank_of_doubles(const Matrix& A);

/// Columns scaled to length 1; zero columns stay.
Matrix unit_columns(Matrix A);

/// "exact": the rank of A. "visible": the number of singular values above `visible` times the largest one, of
/// `in_units` (A in other units) with its columns scaled to length 1. Null where an entry is not finite.
Json rank_json(const Matrix& A, const Matrix& in_units, double visible);

}  // namespace lcpbench
