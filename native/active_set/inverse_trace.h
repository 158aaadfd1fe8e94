#pragma once

#include "native/active_set/arithmetic.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

/// The trace of the inverse of G = C'C scaled to unit diagonal, C upper triangular, from the rows of C^-T: never less
/// than the norm of that inverse. O(ngc^3 / 6); of blocks O(ngc) times the square of their order.
template <class Scalar>
class InverseTrace {
  using L = Lanes<Scalar>;

 public:
  void reserve(Count ngc) {
    lanes_ = L::padded(ngc);
    inverse_.resize(ngc * lanes_ + 1);
    inverse_begin_.resize(ngc + 1);
    squares_.resize(lanes_ + 1);
    unit_.resize(2 * L::kWidth);
  }

  /// @param columns  of C, padded; `inverse_diagonal` of C; G by columns
  Scalar of(const Scalar* columns, const Scalar* inverse_diagonal, const double* G, Count ngc) {
    set_zero(unit_.data(), 2 * L::kWidth);
    unit_[L::kWidth] = 1;
    set_zero(squares_.data(), lanes_);
    for (Count i = 0; i < ngc; ++i) add_row(i, columns + i * lanes_, inverse_diagonal[i]);
    Scalar trace = 0;
    for (Count i = 0; i < ngc; ++i) trace += squares_[i] * static_cast<Scalar>(G[i * ngc + i]);
    return trace;
  }

 private:
  /// Row i of C^-T; squares_ += those of its entries.
  void add_row(Count i, const Scalar* column, Scalar inverse_diagonal) {
    Count from = 0;
    while (from < i && column[from] == 0) ++from;
    Count begin = from == 0 ? 0 : i;  // of the row's nonzero entries
    for (Count k = from; k < i && begin > 0; ++k) begin = inverse_begin_[k] < begin ? inverse_begin_[k] : begin;
    begin = begin / L::kWidth * L::kWidth;
    inverse_begin_[i] = begin;
    const Count end = (i / L::kWidth + 1) * L::kWidth;
    Scalar* const row = inverse_.data() + i * lanes_;
    set_zero(row, begin);
    set_zero(row + end, lanes_ - end);
    const auto factor = L::broadcast(inverse_diagonal);
    for (Count j = begin; j < end; j += L::kWidth) {
      auto sum = j + L::kWidth < end ? L::broadcast(0) : unit_pack(i % L::kWidth);
      auto other = L::broadcast(0);
      Count k = from;
      for (; k + 1 < i; k += 2) {
        sum += L::broadcast(-column[k]) * L::load(inverse_.data() + k * lanes_ + j);
        other += L::broadcast(-column[k + 1]) * L::load(inverse_.data() + (k + 1) * lanes_ + j);
      }
      if (k < i) sum += L::broadcast(-column[k]) * L::load(inverse_.data() + k * lanes_ + j);
      const auto entries = factor * (sum + other);
      L::store(row + j, entries);
      L::store(squares_.data() + j, L::load(squares_.data() + j) + entries * entries);
    }
  }

  /// 1 in one lane, made without storing a number apart, which would hold up the load of the register.
  typename L::Pack unit_pack(Count lane) const { return L::load(unit_.data() + L::kWidth - lane); }

  Count lanes_ = 0;
  Buffer<Scalar> inverse_;       // C^-T by rows
  Buffer<Count> inverse_begin_;  // of the nonzero entries of its rows
  Buffer<Scalar> squares_;       // by coordinate, of the entries of C^-T
  Buffer<Scalar> unit_;          // zeros but for a 1 at the width of a register
};

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
