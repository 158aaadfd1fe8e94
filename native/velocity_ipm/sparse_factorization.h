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

  /// For the pattern analyzed, in units of about 0.2 ns: the time of four multiplications in a dense kernel.
  struct Cost {
    double factor = 0;
    double solve = 0;
  };
  virtual Cost cost() const = 0;
};

/// The same for matrices with a symmetric pattern and any values.
class UnsymmetricFactorization {
 public:
  virtual ~UnsymmetricFactorization() = default;

  /// As of SparseFactorization.
  virtual void analyze(const SparseMatrix& lower) = 0;
  /// False when the factorization breaks down.
  /// @param lower  the values of the lower triangle, in the order of the pattern analyzed
  /// @param upper  those of the transpose of the upper triangle; with zeros, or anything, on the diagonal
  virtual bool factor(const double* lower, const double* upper) = 0;
  virtual void solve(Vector& x) = 0;
  virtual SparseFactorization::Cost cost() const = 0;
};

}  // namespace lcpbench
