#pragma once

#include "native/active_set/arithmetic.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

/// The trace of S^-1, where S is G = C'C scaled to unit diagonal and C is upper triangular: the sum of the squares of
/// the entries of C^-T diag(G)^(1/2). But for rounding, never less than the spectral norm of S^-1. O(ngc^3 / 6); for a
/// block diagonal C, O(ngc^2) to find the blocks and O(ngc) times the square of their order.
class InverseTrace {
  using L = Lanes<double>;

 public:
  /// Room for all G that are not larger.
  void reserve(Count ngc) {
    inverse_.resize(ngc * L::padded(ngc) + 1);
  }

  /// @param rows  of C, `stride` from one to the next; read right of the diagonal only
  /// @param inverse_diagonal, root_diagonal  1 / C_ii and G_ii^(1/2)
  /// @pre reserve()
  double of(const double* rows, Count stride, const double* inverse_diagonal, const double* root_diagonal, Count ngc) {
    double trace = 0;
    for (Count begin = 0; begin < ngc;) {
      const Count end = block_end(rows, stride, begin, ngc);
      trace += of_block(rows, stride, inverse_diagonal, root_diagonal, begin, end, L::padded(ngc));
      begin = end;
    }
    return trace;
  }

 private:
  /// One past the last row of the diagonal block of C that begins at `begin`.
  static Count block_end(const double* rows, Count stride, Count begin, Count ngc) {
    Count end = begin + 1;
    for (Count i = begin; i < end; ++i) {
      const double* const row = rows + i * stride;
      Count last = ngc;
      while (last > end && row[last - 1] == 0) --last;
      end = last;
    }
    return end;
  }

  /// The sum of the squares of one diagonal block of C^-T diag(G)^(1/2), by forward substitution. Each finished row is
  /// subtracted from all rows below at once, so that no row waits for a long sum.
  double of_block(const double* rows, Count stride, const double* inverse_diagonal, const double* root_diagonal,
                  Count begin, Count end, Count inverse_stride) {
    const Count first = begin / L::kWidth * L::kWidth;
    for (Count i = begin; i < end; ++i) {
      for (Count j = first; j <= i; j += L::kWidth) {
        L::store(inverse_.data() + i * inverse_stride + j, with_entry(L::broadcast(0), j, i, root_diagonal[i]));
      }
    }
    auto sum = L::broadcast(0);
    for (Count k = begin; k < end; ++k) {
      const double* const row = rows + k * stride;
      const auto factor = L::broadcast(inverse_diagonal[k]);
      for (Count j = first; j <= k; j += L::kWidth) {
        const auto entries = factor * L::load(inverse_.data() + k * inverse_stride + j);
        sum += entries * entries;
        for (Count i = k + 1; i < end; ++i) {
          double* const below = inverse_.data() + i * inverse_stride + j;
          L::store(below, L::load(below) - L::broadcast(row[i]) * entries);
        }
      }
    }
    return L::sum(sum);
  }

  Buffer<double> inverse_;  // C^-T diag(G)^(1/2) by rows
};

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
