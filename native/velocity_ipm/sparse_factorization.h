#pragma once

#include "core/types.h"

namespace lcpbench {

/// Solves systems with sparse symmetric positive definite matrices of one pattern: what the interior-point method needs
/// of a sparse Cholesky library. Matrices are given by their lower triangle, compressed, with sorted columns, their
/// rows already in an order of elimination (elimination_order).
class SparseFactorization {
 public:
  virtual ~SparseFactorization() = default;

  /// Before anything else: the pattern of the matrices to come. Values mean nothing yet.
  virtual void analyze(const SparseMatrix& lower) = 0;
  /// False when the factorization breaks down. @param lower  stays as it is until the last solve() with it
  virtual bool factor(const SparseMatrix& lower) = 0;
  /// x := A^-1 x, of the last matrix factored. @pre that factor() was true
  virtual void solve(Vector& x) = 0;

  /// Multiplications, of matrices with the pattern analyzed.
  struct Cost {
    double factor = 0;
    double solve = 0;
  };
  virtual Cost cost() const = 0;
};

}  // namespace lcpbench
