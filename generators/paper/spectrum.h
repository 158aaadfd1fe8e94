#pragma once

#include <vector>

#include "generators/column_major.h"

// Arithmetic whose every bit is fixed by IEEE 754 (and -ffp-contract=off): only + - * / and sqrt on doubles, in a
// written order. (The library's log and exp are not correctly rounded and differ between C libraries.)

namespace lcpbench {

/// log2(x) for normal x > 0, relative error below 1e-15 away from x = 1, absolute error below 1e-16 near it.
double portable_log2(double x);

/// 2^x for |x| <= 1000, relative error below 1e-15.
double portable_exp2(double x);

/// X diag(weights) X' for X of n rows and k columns, with a weight for each column. Sums are in the order of the
/// columns; the lower triangle is a copy of the upper one: exactly symmetric. O(n^2 k).
ColumnMajor<double> weighted_outer_sum(const ColumnMajor<double>& X, const std::vector<double>& weights);

/// True only if the symmetric A (n x n) is positive definite: Cholesky's factorization of A - c diag(A) runs through,
/// where c = 2 n (n + 2) u, u = 2^-53, exceeds any effect of its rounding. [Rump 2006, "Verification of positive
/// definiteness"] Some matrices with a condition number (after scaling to a unit diagonal) above 1/c are refused
/// although positive definite. False for NaN. O(n^3).
bool safely_positive_definite(const ColumnMajor<double>& A);

/// The eigenvalues (ascending) and orthonormal eigenvectors of a symmetric positive definite matrix.
struct Eigensystem {
  std::vector<double> values;
  ColumnMajor<double> vectors;
};

/// Eigensystem of Y Y' for a nonsingular square Y, by one-sided cyclic Jacobi rotations of the columns of Y. High
/// relative accuracy of the small eigenvalues too, for Y Y' is never formed. O(n^3) per sweep, about 8 sweeps.
/// [Hestenes 1958; Demmel, Veselic 1992] @throws std::logic_error if 60 sweeps do not suffice.
Eigensystem spectrum_of_square(ColumnMajor<double> Y);

/// How eigenvalues are brought into [1, condition].
enum class SpectrumMap {
  kLogLinear,  ///< log(value), mapped affinely
  kLinear,     ///< value, mapped affinely
  kGeometric,  ///< the i-th of n becomes condition^(i / (n - 1)); the values are not used
};

/// Eigenvalues in [1, condition], the last exactly `condition` and the first of several exactly 1.
/// @pre at least 1 value, ascending, > 0 (kGeometric: any); condition >= 1
std::vector<double> map_spectrum(const std::vector<double>& values, double condition, SpectrumMap map);

}  // namespace lcpbench
