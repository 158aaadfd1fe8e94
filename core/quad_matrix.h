#pragma once

#include <cstddef>
#include <vector>

#include "core/quad.h"
#include "core/types.h"

namespace lcpbench {

using QuadVector = std::vector<Quad>;

/// value / scale, with 0/0 = 0 and x/0 = infinity: how measures are made relative.
Quad quotient(Quad value, Quad scale);

/// A dense matrix in 113-bit arithmetic, stored by rows.
struct QuadMatrix {
  std::size_t rows = 0;
  std::size_t cols = 0;
  QuadVector entries;

  QuadMatrix() = default;
  QuadMatrix(std::size_t row_count, std::size_t column_count)
      : rows(row_count), cols(column_count), entries(row_count * column_count, 0) {}
  explicit QuadMatrix(const Matrix& doubles);

  Quad& operator()(std::size_t i, std::size_t j) { return entries[i * cols + j]; }
  Quad operator()(std::size_t i, std::size_t j) const { return entries[i * cols + j]; }
};

/// A x; x has A.cols entries. O(rows cols).
QuadVector multiply(const QuadMatrix& A, const Quad* x);

/// A' x; x has A.rows entries. O(rows cols).
QuadVector multiply_transposed(const QuadMatrix& A, const Quad* x);

/// B diag(alpha) B', each entry to within (B.cols + 2) roundings of sqrt(G_ii G_jj) for alpha >= 0.
QuadMatrix weighted_gram(const QuadMatrix& B, const QuadVector& alpha);

/// A = L D L' with unit lower triangular L: a solver for symmetric positive definite matrices. No pivoting. O(n^3 / 3).
class QuadCholesky {
 public:
  /// Factors the lower triangle of A (n x n). False, and unusable, unless every pivot is positive and finite.
  bool factor(const QuadMatrix& A);

  /// Factors A = C C' without forming it, by orthogonalizing the rows of C, whose condition is the root of A's. False,
  /// and unusable, unless at least `least` of the length of each row is outside the span of those before it.
  bool factor_product(QuadMatrix C, double least);

  /// x := A^-1 x, for n entries. O(n^2).
  void solve(Quad* x) const;

  std::size_t size() const { return pivots_.size(); }

  /// L D^(1/2), and its inverse: A = root root'. O(n^3)
  QuadMatrix root() const;
  QuadMatrix inverse_root() const;

 private:
  QuadMatrix L_;
  QuadVector pivots_;
};

/// True only when A (n x n, exactly symmetric) is proven positive definite, whatever the rounding: A less a multiple of
/// its own diagonal, larger than all rounding of the factorization and of `formation_terms` roundings per entry of A,
/// factors with positive pivots. Scaling-invariant; refuses matrices within about n^2 2^-112 of singular (scaled to
/// unit diagonal). O(n^3 / 3). [Rump 2006, "Verification of positive definiteness", BIT 46]
/// @param least  and that scaled to unit diagonal it has no eigenvalue below this
bool proven_positive_definite(const QuadMatrix& A, std::size_t formation_terms, double least = 0);

}  // namespace lcpbench
