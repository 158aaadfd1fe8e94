#pragma once

#include <cstddef>

#include "core/isa.h"

// The border between the Cholesky and LU factorizations and their dense kernels, which are compiled once per
// instruction-set level. Only plain structs and pointers cross it, for the reason that engine_border.h gives.

namespace lcpbench::cholesky {

/// Kernels work on four rows and columns at a time. A matrix of m rows that they change stands in columns of
/// `stride` >= m + kMargin entries, has kMargin more columns than m, and zeros in its rows m to m + kMargin - 1; of the
/// rest they change the lower triangle, and use the upper one and the columns beyond m as scratch.
inline constexpr std::ptrdiff_t kMargin = 3;

/// Doubles of `work` for matrices of so many rows: one packed panel. factor_lu() needs twice that.
constexpr std::ptrdiff_t work_size(std::ptrdiff_t rows) { return (rows + kMargin) * 64; }

/// Dense kernels of Cholesky factorizations, A = L L', of the products B B' that A is a sum of, and of LU
/// factorizations. None allocates.
struct Engine {
  /// Factors the first `columns` columns of the symmetric `a` (rows x rows) and subtracts their part from the rest: L
  /// stands in them then, and the Schur complement in the rest. False when a pivot is not positive, or not finite.
  bool (*factor)(double* a, std::ptrdiff_t stride, std::ptrdiff_t rows, std::ptrdiff_t columns, double* work);
  /// The same, A = L U, for a square matrix: `lower` has its lower triangle, `upper` the transpose of its strict upper
  /// one. L stands in the columns of `lower` then, with ones on its diagonal, and U' in those of `upper`.
  /// Rows are exchanged within panels of 64 columns only: for each k < `columns` in turn row k with row swaps[k]. False
  /// when a pivot, or its inverse, is zero or not finite. @param work  twice work_size(rows)
  bool (*factor_lu)(double* lower, double* upper, std::ptrdiff_t stride, std::ptrdiff_t rows, std::ptrdiff_t columns,
                    int* swaps, double* work);
  /// a += B B' for B (rows x columns) by columns of `b_stride` >= rows + kMargin entries, zeros in the margin.
  void (*add_product)(double* a, std::ptrdiff_t stride, const double* b, std::ptrdiff_t b_stride, std::ptrdiff_t rows,
                      std::ptrdiff_t columns, double* work);
  /// x := [L1 0; L2 I]^-1 x for L = [L1; L2] (rows x columns) by columns without margin, L1 with the inverse of each
  /// diagonal entry in its place.
  void (*solve_lower)(const double* l, std::ptrdiff_t rows, std::ptrdiff_t columns, double* x);
  /// x := [L1 0; L2 I]'^-1 x.
  void (*solve_transposed)(const double* l, std::ptrdiff_t rows, std::ptrdiff_t columns, double* x);
  /// lengths (rows) := those of the columns of L^-1, for L (rows x rows) by columns without margin, with the inverse of
  /// each diagonal entry in its place.
  void (*measure_inverse)(const double* l, std::ptrdiff_t rows, double* lengths, double* work);
};

/// The lower triangle of `given` (rows x rows) by columns, with the margin below it, for factor().
void take_lower(const double* given, std::ptrdiff_t rows, double* a, std::ptrdiff_t stride);

/// The first `columns` columns of L as factor() leaves them in `a`, by columns of `rows` entries and with the inverse
/// of each diagonal entry in its place, as the solves take them. So for L in `lower` and U' in `upper` of factor_lu().
void keep_columns(const double* a, std::ptrdiff_t stride, std::ptrdiff_t rows, std::ptrdiff_t columns, double* l);

/// The kernels of one level. @param level must not exceed best_isa_level()
const Engine& engine(IsaLevel level);

namespace baseline {
extern const Engine kEngine;
}  // namespace baseline
namespace avx2 {
extern const Engine kEngine;
}  // namespace avx2
namespace avx512 {
extern const Engine kEngine;
}  // namespace avx512

}  // namespace lcpbench::cholesky
