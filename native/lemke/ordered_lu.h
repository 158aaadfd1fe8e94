#pragma once

#include <utility>

#include "native/kernels/pack.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// P B = L U with partial pivoting, in the roundings of LAPACK's DGETF2 and DGETRS: each entry has its products
/// subtracted one by one in the order of the pivots, none of them fused, and a column of L is multiplied by the
/// reciprocal of its pivot. Products with zeros are left out.
///
/// Columns are eliminated from left to right, so that those in front of the first changed one stay. A unit column whose
/// row is no pivot yet takes O(1), any other column O(n k), k the columns of L that are not empty.
class OrderedLu {
 public:
  void load(Count n) {
    n_ = n;
    stride_ = P::padded(n);
    lower_.resize(n * stride_);
    upper_.resize(n * stride_);
    work_.fill(stride_, 0);
    diagonal_.resize(n);
    kind_.resize(n);
    swapped_.resize(n);
    row_at_.resize(n);
    place_of_.resize(n);
    for (Count i = 0; i < n; ++i) row_at_[i] = place_of_[i] = i;
    done_ = 0;
  }

  Count done() const { return done_; }

  /// Forgets the elimination of column `first` and of those behind it. @pre first <= done()
  void forget(Count first) {
    for (; done_ > first; --done_) swap_places(done_ - 1, swapped_[done_ - 1]);
  }

  /// Eliminates the unit column of `row` as the next one. False, and nothing done, when `row` is a pivot already.
  bool add_unit(Count row) {
    if (place_of_[row] < done_) return false;
    take_pivot(place_of_[row]);
    diagonal_[done_] = 1;
    kind_[done_] = Kind::kUnit;
    ++done_;
    return true;
  }

  /// Eliminates the next column, which is overwritten. False, and nothing done, when no entry is left for a pivot.
  /// @param column  n entries by rows, padded with zeros
  bool add(double* column) {
    double* const upper = upper_.data() + done_ * stride_;
    eliminate(column, upper);
    Count pivot = done_;
    double largest = 0;
    for (Count place = done_; place < n_; ++place) {
      const double size = magnitude(column[row_at_[place]]);
      pivot = size > largest ? place : pivot;
      largest = size > largest ? size : largest;
    }
    if (!(largest > 0)) return false;
    take_pivot(pivot);
    diagonal_[done_] = column[row_at_[done_]];
    store_lower(column);
    ++done_;
    return true;
  }

  /// side := B^-1 side, from rows to columns. @pre all columns are eliminated
  void solve(double* side) {
    double* const solution = work_.data();
    eliminate(side, solution);
    for (Count k = n_ - 1; k >= 0; --k) {
      if (solution[k] == 0) continue;
      solution[k] /= diagonal_[k];
      if (kind_[k] != Kind::kUnit) subtract(solution[k], upper_.data() + k * stride_, solution, P::padded(k));
    }
    for (Count k = 0; k < n_; ++k) side[k] = solution[k];
  }

 private:
  using P = Packed<double>;
  static constexpr double kLeastNormal = 0x1p-1022;
  enum class Kind : char { kUnit, kEmptyBelow, kFull };

  void swap_places(Count a, Count b) {
    std::swap(row_at_[a], row_at_[b]);
    place_of_[row_at_[a]] = a;
    place_of_[row_at_[b]] = b;
  }

  void take_pivot(Count place) {
    swapped_[done_] = place;
    swap_places(done_, place);
  }

  /// L^-1 P column for the columns of L so far: its entries in the pivots' rows to `upper`, padded with zeros.
  void eliminate(double* column, double* upper) const {
    for (Count k = 0; k < done_; ++k) {
      const double factor = column[row_at_[k]];
      upper[k] = factor;
      if (factor != 0 && kind_[k] == Kind::kFull) subtract(factor, lower_.data() + k * stride_, column, stride_);
    }
    for (Count k = done_; k < P::padded(done_); ++k) upper[k] = 0;
  }

  /// to -= factor * from.
  static void subtract(double factor, const double* from, double* to, Count count) {
    for (Count i = 0; i < count; i += P::kWidth) P::store(to + i, P::load(to + i) - factor * P::load(from + i));
  }

  /// The next column of L, with zeros in the rows that are pivots.
  void store_lower(const double* column) {
    double* const lower = lower_.data() + done_ * stride_;
    const double pivot = diagonal_[done_];
    const bool has_reciprocal = magnitude(pivot) >= kLeastNormal;
    const double reciprocal = 1 / pivot;
    bool empty = true;
    for (Count i = 0; i < stride_; ++i) lower[i] = 0;
    for (Count place = done_ + 1; place < n_; ++place) {
      const double entry = column[row_at_[place]];
      lower[row_at_[place]] = has_reciprocal ? entry * reciprocal : entry / pivot;
      empty = empty && entry == 0;
    }
    kind_[done_] = empty ? Kind::kEmptyBelow : Kind::kFull;
  }

  Count n_ = 0, stride_ = 0, done_ = 0;
  Buffer<double> lower_;     ///< columns of L, by the rows of B, without their ones
  Buffer<double> upper_;     ///< columns of U above the diagonal; of unit columns nothing
  Buffer<double> diagonal_;  ///< of U
  Buffer<double> work_;
  Buffer<Kind> kind_;
  Buffer<Count> swapped_;            ///< the place with which each column's pivot changed places
  Buffer<Count> row_at_, place_of_;  ///< P and its inverse: the pivots' rows come first
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
