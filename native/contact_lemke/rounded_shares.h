#pragma once

#include "native/kernels/arithmetic.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// Finds a factor y_k, the share, for each column a_k, so that the sum of y_k a_k stays close to the sum of all a_k.
/// Shares are 1 but for rounding. They are rounded one after the other, each so that it makes up for the rounding of
/// those before. [Babai 1986, the nearest-plane method]
template <class Scalar>
class RoundedShares {
 public:
  /// Takes all memory that load() needs; touches none of it.
  void reserve(Count length) {
    padded_ = P::padded(length);
    most_ = length;
    A_.resize(most_ * padded_);
    R_.resize(most_ * most_);
    share_.resize(P::padded(most_));
    order_.resize(most_);
  }

  /// For up to `length` columns of `length` entries each. Sets the columns, and so their padding, to zero. clear() has
  /// to follow.
  void load(Count length) {
    reserve(length);
    fill_with_zeros(most_ * padded_, A_);
  }

  /// Starts a new sum, without columns.
  void clear() { columns_ = 0; }
  /// A new column to be written, which has the entries of its last use; its padding must stay zero. nullptr when there
  /// are `length` columns already.
  Scalar* next_column() { return columns_ < most_ ? A_.data() + padded_ * columns_++ : nullptr; }

  /// Finds the shares; `to_double(k, share)` rounds that of column k, and returns what it has become. The shortest
  /// column is rounded last, since nothing makes up for that. False when the columns are dependent.
  template <class Round>
  bool round(Round&& to_double) {
    if (!orthonormalise()) return false;
    for (Count k = columns_ - 1; k >= 0; --k) {
      Scalar left = R(k, k);
      for (Count j = k + 1; j < columns_; ++j) left += R(k, j) * (Scalar(1) - share_[j]);
      share_[k] = to_double(order_[k], left / R(k, k));
    }
    return true;
  }

 private:
  using P = Packed<Scalar>;

  /// A column counts as dependent if the projections leave no more of it than this many roundings of its length.
  static constexpr double kDependent = 64;

  Scalar* column(Count j) { return A_.data() + j * padded_; }

  Scalar& R(Count k, Count j) { return R_[k * most_ + j]; }

  /// A = Q R by Gram-Schmidt with column pivoting and a second pass.
  bool orthonormalise() {
    for (Count k = 0; k < columns_; ++k) order_[k] = k;
    for (Count k = 0; k < columns_; ++k) {
      bring_shortest_to(k);
      Scalar before = dot(column(k), column(k), padded_);  // and what the columns before have taken off
      for (Count j = 0; j < k; ++j) before += R(j, k) * R(j, k);
      before = square_root(before);
      for (Count j = 0; j < k; ++j) {
        const Scalar rest = dot(column(j), column(k), padded_);
        R(j, k) += rest;
        add_multiple(column(k), -rest, column(j), padded_);
      }
      const Scalar length = square_root(dot(column(k), column(k), padded_));
      if (!(length > static_cast<Scalar>(kDependent * kUnitRoundoff<Scalar>) * before)) return false;
      R(k, k) = length;
      scale(column(k), Scalar(1) / length, padded_);
      for (Count j = k + 1; j < columns_; ++j) {
        R(k, j) = dot(column(k), column(j), padded_);
        add_multiple(column(j), -R(k, j), column(k), padded_);
      }
    }
    return true;
  }

  /// Of the columns from k on.
  void bring_shortest_to(Count k) {
    Count shortest = k;
    Scalar least = dot(column(k), column(k), padded_);
    for (Count j = k + 1; j < columns_; ++j) {
      const Scalar square = dot(column(j), column(j), padded_);
      if (square < least) {
        least = square;
        shortest = j;
      }
    }
    if (shortest == k) return;
    for (Count i = 0; i < padded_; ++i) swap(column(k)[i], column(shortest)[i]);
    for (Count i = 0; i < k; ++i) swap(R(i, k), R(i, shortest));
    swap(order_[k], order_[shortest]);
  }

  Count padded_ = 0, most_ = 0, columns_ = 0;
  Buffer<Scalar> A_, R_, share_;
  Buffer<Count> order_;  ///< where the columns came from
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
