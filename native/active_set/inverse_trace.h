#pragma once

#include "native/active_set/arithmetic.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

/// The trace of the inverse of G = C'C scaled to unit diagonal, C upper triangular, from the rows of C^-T: never less
/// than the norm of that inverse. O(ngc^3 / 6); of blocks O(ngc^2) to find them and O(ngc) times the square of their
/// order.
template <class Scalar>
class InverseTrace {
  using L = Lanes<Scalar>;

 public:
  void reserve(Count ngc) {
    inverse_.resize(ngc * L::padded(ngc) + 1);
  }

  /// @param rows  of C, `stride` from one to the next, and the inverses of its diagonal; the roots of the diagonal of G
  Scalar of(const Scalar* rows, Count stride, const Scalar* inverse_diagonal, const Scalar* root_diagonal, Count ngc) {
    Scalar trace = 0;
    for (Count begin = 0; begin < ngc;) {
      const Count end = block_end(rows, stride, begin, ngc);
      trace += of_block(rows, stride, inverse_diagonal, root_diagonal, begin, end, L::padded(ngc));
      begin = end;
    }
    return trace;
  }

 private:
  /// The end of the block on the diagonal of C that begins at `begin`.
  static Count block_end(const Scalar* rows, Count stride, Count begin, Count ngc) {
    Count end = begin + 1;
    for (Count i = begin; i < end; ++i) {
      const Scalar* const row = rows + i * stride;
      Count last = ngc;
      while (last > end && row[last - 1] == 0) --last;
      end = last;
    }
    return end;
  }

  /// The sum of the squares of the block of C^-T, whose columns are scaled. A row that is known is taken from those
  /// below it at once: each of these waits for one product, not for a sum.
  Scalar of_block(const Scalar* rows, Count stride, const Scalar* inverse_diagonal, const Scalar* root_diagonal,
                  Count begin, Count end, Count lanes) {
    const Count first = begin / L::kWidth * L::kWidth;
    for (Count i = begin; i < end; ++i) {
      for (Count j = first; j <= i; j += L::kWidth) {
        L::store(inverse_.data() + i * lanes + j, with_entry(L::broadcast(0), j, i, root_diagonal[i]));
      }
    }
    auto sum = L::broadcast(0);
    for (Count k = begin; k < end; ++k) {
      const Scalar* const row = rows + k * stride;
      const auto factor = L::broadcast(inverse_diagonal[k]);
      for (Count j = first; j <= k; j += L::kWidth) {
        const auto entries = factor * L::load(inverse_.data() + k * lanes + j);
        sum += entries * entries;
        for (Count i = k + 1; i < end; ++i) {
          Scalar* const below = inverse_.data() + i * lanes + j;
          L::store(below, L::load(below) - L::broadcast(row[i]) * entries);
        }
      }
    }
    return L::sum(sum);
  }

  Buffer<Scalar> inverse_;  // C^-T by rows, its columns times the roots of the diagonal of G
};

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
