#pragma once

#include "native/kernels/pack.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// Solves A X = [b_0 b_1] by Gaussian elimination with partial pivoting, A stored by rows with both right-hand sides at
/// their ends. Rows are exchanged by pointer; U is left with a unit diagonal, L is not kept.
class SmallSystem {
 public:
  static constexpr Count kSides = 2;

  void reserve(Count most) {
    work_.resize(most * stride_of(most));
    rows_.resize(most);
    column_.resize(most);
  }

  /// Begins a system of the given order; every row is then to be written.
  void begin(Count order) {
    order_ = order;
    stride_ = stride_of(order);
  }

  /// Row r: `order` entries at `entries`, followed in memory by whatever fills the last pack.
  void write_row(Count r, const double* entries, double side_0, double side_1) {
    double* const row = work_.data() + r * stride_;
    for (Count c = 0; c < order_; c += P::kWidth) P::store(row + c, P::load(entries + c));
    row[order_] = side_0;
    row[order_ + 1] = side_1;
    for (Count c = order_ + kSides; c < stride_; ++c) row[c] = 0;
    rows_[r] = row;
    column_[r] = row[0];
  }

  /// False when a column has no nonzero pivot. `solution_*`: order entries each, padded with zeros.
  bool solve(double* solution_0, double* solution_1) {
    if (!eliminate()) return false;
    substitute(solution_0, solution_1);
    return true;
  }

 private:
  using P = Packed<double>;
  using Pack = P::Pack;
  static constexpr Count kMostUnrolled = 8;

  static Count stride_of(Count order) { return P::padded(order + kSides); }

  bool eliminate() {
    Count pivot = largest_of_first_column();
    for (Count step = 0; step < order_; ++step) {
      const double value = column_[pivot];
      if (!(magnitude(value) > 0)) return false;
      double* const pivot_row = rows_[pivot];
      rows_[pivot] = rows_[step];
      column_[pivot] = column_[step];
      rows_[step] = pivot_row;
      pivot = subtract_below(step, pivot_row, 1 / value);
    }
    return true;
  }

  Count largest_of_first_column() const {
    Largest largest{0, -1};
    for (Count r = 0; r < order_; ++r) largest.offer(r, column_[r]);
    return largest.at;
  }

  /// A running maximum of magnitudes, without branches: where it lies is not predictable.
  struct Largest {
    Count at;
    double size;
    void offer(Count place, double value) {
      const double candidate = magnitude(value);
      at = candidate > size ? place : at;
      size = candidate > size ? candidate : size;
    }
  };

  /// Scales the pivot row to a unit pivot, clears column `step` below it and gathers the next column, of which it
  /// returns the largest entry's row. Entries left of the pivot that share its pack are overwritten: substitute() only
  /// multiplies them with zeros.
  Count subtract_below(Count step, double* pivot_row, double reciprocal) {
    const Count first = (step + 1) / P::kWidth * P::kWidth;
    switch ((stride_ - first) / P::kWidth) {
      case 1: return subtract_unrolled<1>(step, pivot_row, reciprocal);
      case 2: return subtract_unrolled<2>(step, pivot_row, reciprocal);
      case 3: return subtract_unrolled<3>(step, pivot_row, reciprocal);
      case 4: return subtract_unrolled<4>(step, pivot_row, reciprocal);
      case 5: return subtract_unrolled<5>(step, pivot_row, reciprocal);
      case 6: return subtract_unrolled<6>(step, pivot_row, reciprocal);
      case 7: return subtract_unrolled<7>(step, pivot_row, reciprocal);
      case kMostUnrolled: return subtract_unrolled<kMostUnrolled>(step, pivot_row, reciprocal);
      default: return subtract_long(step, first, pivot_row, reciprocal);
    }
  }

  /// The pivot row's packs stay in registers.
  template <Count kPacks>
  Count subtract_unrolled(Count step, double* pivot_row, double reciprocal) {
    const Count first = stride_ - kPacks * P::kWidth;
    Pack pivot[static_cast<std::size_t>(kPacks)];
    for (Count k = 0; k < kPacks; ++k) {
      pivot[k] = P::load(pivot_row + first + k * P::kWidth) * reciprocal;
      P::store(pivot_row + first + k * P::kWidth, pivot[k]);
    }
    double* const column = column_.data();
    double* const* const rows = rows_.data();
    const Count order = order_;
    Largest largest{step + 1, -1};
    for (Count r = step + 1; r < order; ++r) {
      double* const row = rows[r] + first;
      const double factor = column[r];
      for (Count k = 0; k < kPacks; ++k) {
        P::store(row + k * P::kWidth, P::load(row + k * P::kWidth) - factor * pivot[k]);
      }
      column[r] = row[step + 1 - first];
      largest.offer(r, column[r]);
    }
    return largest.at;
  }

  Count subtract_long(Count step, Count first, double* pivot_row, double reciprocal) {
    const Count stride = stride_;
    for (Count c = first; c < stride; c += P::kWidth) P::store(pivot_row + c, P::load(pivot_row + c) * reciprocal);
    Largest largest{step + 1, -1};
    for (Count r = step + 1; r < order_; ++r) {
      double* const row = rows_[r];
      const double factor = column_[r];
      for (Count c = first; c < stride; c += P::kWidth) {
        P::store(row + c, P::load(row + c) - factor * P::load(pivot_row + c));
      }
      column_[r] = row[step + 1];
      largest.offer(r, column_[r]);
    }
    return largest.at;
  }

  void substitute(double* solution_0, double* solution_1) const {
    const Count padded = P::padded(order_);
    for (Count i = 0; i < padded; i += P::kWidth) {
      P::store(solution_0 + i, Pack{});
      P::store(solution_1 + i, Pack{});
    }
    for (Count r = order_ - 1; r >= 0; --r) {
      const double* const row = rows_[r];
      Pack sum_0 = Pack{};
      Pack sum_1 = Pack{};
      for (Count c = r / P::kWidth * P::kWidth; c < padded; c += P::kWidth) {
        const Pack entries = P::load(row + c);
        sum_0 += entries * P::load(solution_0 + c);
        sum_1 += entries * P::load(solution_1 + c);
      }
      solution_0[r] = row[order_] - P::sum(sum_0);
      solution_1[r] = row[order_ + 1] - P::sum(sum_1);
    }
  }

  Count order_ = 0, stride_ = 0;
  Buffer<double> work_;
  Buffer<double*> rows_;
  Buffer<double> column_;  ///< of the rows not yet eliminated, the entries of the column that comes next
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
