#pragma once

#include "native/kernels/arithmetic.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

using lemke::LCPBENCH_LEVEL::add_multiple;
using lemke::LCPBENCH_LEVEL::Buffer;
using lemke::LCPBENCH_LEVEL::copy;
using lemke::LCPBENCH_LEVEL::Count;
using lemke::LCPBENCH_LEVEL::dot;
using lemke::LCPBENCH_LEVEL::kInfinity;
using lemke::LCPBENCH_LEVEL::kUnitRoundoff;
using lemke::LCPBENCH_LEVEL::lane_numbers;
using lemke::LCPBENCH_LEVEL::lanes_where;
using lemke::LCPBENCH_LEVEL::load_first;
using lemke::LCPBENCH_LEVEL::magnitude;
using lemke::LCPBENCH_LEVEL::scale;
using lemke::LCPBENCH_LEVEL::square_root;
using lemke::LCPBENCH_LEVEL::swap;
using lemke::LCPBENCH_LEVEL::transpose;
using lemke::LCPBENCH_LEVEL::transpose_block;
using lemke::LCPBENCH_LEVEL::widen;
using lemke::LCPBENCH_LEVEL::with_entry;

/// Makes room for `size` entries in each buffer.
template <class... Buffers>
inline void resize_all(Count size, Buffers&... buffers) {
  (buffers.resize(size), ...);
}

/// Registers of a scalar type.
template <class Scalar>
using Lanes = lemke::LCPBENCH_LEVEL::Packed<Scalar>;

// Arrays below have a length that is a multiple of the register's width, zero beyond their content.

/// y += factor x for an x that is not padded.
inline void add_unpadded_multiple(double* y, double factor, const double* x, Count size) {
  using L = Lanes<double>;
  const auto broadcast = L::broadcast(factor);
  Count i = 0;
  for (; i + L::kWidth <= size; i += L::kWidth) L::store(y + i, L::load(y + i) + broadcast * L::load(x + i));
  for (; i < size; ++i) y[i] += factor * x[i];
}

/// Row i -= (row[i] / pivot) row for the rows after `k` of a symmetric matrix with more columns to its right, in the
/// kPacks registers from `first` on, of which those of row k stay registers.
template <int kPacks>
inline void eliminate_below(double* A, Count stride, Count k, Count count, Count first, double inverse_pivot) {
  using L = Lanes<double>;
  const double* pivot_row = A + k * stride;
  L::Pack pivots[static_cast<unsigned>(kPacks)];
  for (int p = 0; p < kPacks; ++p) pivots[p] = L::load(pivot_row + first + p * L::kWidth);
  for (Count i = k + 1; i < count; ++i) {
    const auto factor = L::broadcast(-pivot_row[i] * inverse_pivot);
    double* row = A + i * stride + first;
    for (int p = 0; p < kPacks; ++p) L::store(row + p * L::kWidth, L::load(row + p * L::kWidth) + factor * pivots[p]);
  }
}

/// The same in all registers from `first` on.
[[gnu::always_inline]] inline void eliminate_rows_below(double* A, Count stride, Count k, Count count, Count first,
                                                        double inverse_pivot) {
  using L = Lanes<double>;
  constexpr int kMostPacks = 4;
  for (; stride - first > kMostPacks * L::kWidth; first += kMostPacks * L::kWidth) {
    eliminate_below<kMostPacks>(A, stride, k, count, first, inverse_pivot);
  }
  switch ((stride - first) / L::kWidth) {
    case 1: return eliminate_below<1>(A, stride, k, count, first, inverse_pivot);
    case 2: return eliminate_below<2>(A, stride, k, count, first, inverse_pivot);
    case 3: return eliminate_below<3>(A, stride, k, count, first, inverse_pivot);
    case 4: return eliminate_below<4>(A, stride, k, count, first, inverse_pivot);
  }
}

inline void set_zero(double* x, Count size) {
  using L = Lanes<double>;
  for (Count i = 0; i < size; i += L::kWidth) L::store(x + i, L::broadcast(0));
}

/// y = start + sum of the `count` rows of A, each times its factor; `stride` from row to row. `start` may be y.
inline void combine_rows(double* y, const double* start, const double* A, Count stride, const double* factors,
                         Count count, Count size) {
  lemke::LCPBENCH_LEVEL::combine_onto(A, stride, count, factors, start, y, size);
}

/// False for NaN and infinity.
inline bool finite(double x) {
  return x - x == 0;
}

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
