#pragma once

#include "native/active_set/arithmetic.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

/// Solves K x = b with K = E + B'B, E a positive diagonal, by LDL' of the upper triangle. Rows of K are padded to whole
/// registers.
class SymmetricSystem {
  using L = Lanes<double>;

 public:
  /// Makes room for a B of at most `rows` rows and `order` columns.
  void reserve(Count order, Count rows) {
    matrix_.resize(order * L::padded(order) + 1);
    inverse_pivots_.resize(order + 1);
    factors_.resize(rows + 1);
  }

  /// About order^2 (order / 3 + rows / 2) multiplications. @returns whether all pivots are positive and finite
  /// @param diagonal  of E, `order` entries
  /// @param B  `rows` rows of `order` entries, `stride` apart, padded with zeros to whole registers
  bool factor(const double* diagonal, Count order, const double* B, Count stride, Count rows) {
    order_ = order;
    stride_ = L::padded(order);
    for (Count i = 0; i < order; ++i) {
      for (Count k = 0; k < rows; ++k) factors_[k] = B[k * stride + i];
      double* const from = row(i) + begin(i);
      set_zero(from, stride_ - begin(i));
      row(i)[i] = diagonal[i];
      combine_rows(from, from, B + begin(i), stride, factors_.data(), rows, stride_ - begin(i));
    }
    for (Count k = 0; k < order; ++k) {
      const double pivot = row(k)[k];
      if (!(pivot > 0) || !finite(pivot)) return false;
      inverse_pivots_[k] = 1 / pivot;
      eliminate_rows_below(matrix_.data(), stride_, k, order, begin(k), inverse_pivots_[k]);
      for (Count i = begin(k); i < k; ++i) row(k)[i] = 0;  // left of the diagonal, which solve() reads
    }
    return true;
  }

  /// x := K^-1 x. About order^2 multiplications. @pre factor() returned true; x is padded with zeros likewise
  void solve(double* x) const {
    for (Count k = 0; k < order_; ++k) {
      const double value = x[k];
      add_multiple(x + begin(k), -value * inverse_pivots_[k], row(k) + begin(k), stride_ - begin(k));
      x[k] = value;
    }
    for (Count k = order_ - 1; k >= 0; --k) {
      const double value = x[k];
      x[k] = 0;
      x[k] = (value - dot(row(k) + begin(k), x + begin(k), stride_ - begin(k))) * inverse_pivots_[k];
    }
  }

 private:
  double* row(Count i) { return matrix_.data() + i * stride_; }
  const double* row(Count i) const { return matrix_.data() + i * stride_; }
  /// First column of the register that holds the diagonal entry of row i.
  static Count begin(Count i) { return i / L::kWidth * L::kWidth; }

  Count order_ = 0;
  Count stride_ = 0;
  Buffer<double> matrix_;  ///< K, after factor() D L'
  Buffer<double> inverse_pivots_;
  Buffer<double> factors_;  ///< a column of B
};

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
