#pragma once

#include "native/kernels/arithmetic.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

using lemke::LCPBENCH_LEVEL::add_multiple;
using lemke::LCPBENCH_LEVEL::Buffer;
using lemke::LCPBENCH_LEVEL::copy;
using lemke::LCPBENCH_LEVEL::Count;
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
template <class Scalar>
inline void add_unpadded_multiple(Scalar* y, Scalar factor, const double* x, Count size) {
  Count i = 0;
  if constexpr (sizeof(Scalar) == sizeof(double)) {
    using L = Lanes<double>;
    const auto broadcast = L::broadcast(factor);
    for (; i + L::kWidth <= size; i += L::kWidth) L::store(y + i, L::load(y + i) + broadcast * L::load(x + i));
  }
  for (; i < size; ++i) y[i] += factor * static_cast<Scalar>(x[i]);
}

/// Row i -= (row[i] / pivot) row for the rows after `k` of a symmetric matrix with more columns to its right, in the
/// kPacks registers from `first` on, of which those of row k stay registers.
template <int kPacks, class Scalar>
inline void eliminate_below(Scalar* A, Count stride, Count k, Count count, Count first, Scalar inverse_pivot) {
  using L = Lanes<Scalar>;
  const Scalar* pivot_row = A + k * stride;
  typename L::Pack pivots[static_cast<unsigned>(kPacks)];
  for (int p = 0; p < kPacks; ++p) pivots[p] = L::load(pivot_row + first + p * L::kWidth);
  for (Count i = k + 1; i < count; ++i) {
    const auto factor = L::broadcast(-pivot_row[i] * inverse_pivot);
    Scalar* row = A + i * stride + first;
    for (int p = 0; p < kPacks; ++p) L::store(row + p * L::kWidth, L::load(row + p * L::kWidth) + factor * pivots[p]);
  }
}

/// The same in all registers from `first` on.
template <class Scalar>
[[gnu::always_inline]] inline void eliminate_rows_below(Scalar* A, Count stride, Count k, Count count, Count first,
                                                        Scalar inverse_pivot) {
  using L = Lanes<Scalar>;
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

template <class Scalar>
inline void set_zero(Scalar* x, Count size) {
  using L = Lanes<Scalar>;
  for (Count i = 0; i < size; i += L::kWidth) L::store(x + i, L::broadcast(0));
}

template <class Scalar>
[[gnu::always_inline]] inline Scalar dot(const Scalar* x, const Scalar* y, Count size) {
  using L = Lanes<Scalar>;
  if (size == L::kWidth) return L::sum(L::load(x) * L::load(y));
  if (size == 2 * L::kWidth) {
    return L::sum(L::load(x) * L::load(y) + L::load(x + L::kWidth) * L::load(y + L::kWidth));
  }
  if (size == 3 * L::kWidth) {
    return L::sum(L::load(x) * L::load(y) + L::load(x + L::kWidth) * L::load(y + L::kWidth) +
                  L::load(x + 2 * L::kWidth) * L::load(y + 2 * L::kWidth));
  }
  auto sum = L::broadcast(0);
  for (Count i = 0; i < size; i += L::kWidth) sum += L::load(x + i) * L::load(y + i);
  return L::sum(sum);
}

/// kPacks registers of combine_rows, which stay registers.
template <int kPacks, class Scalar>
inline void combine_columns(Scalar* y, const Scalar* start, const Scalar* A, Count stride, const Scalar* factors,
                            Count count) {
  using L = Lanes<Scalar>;
  typename L::Pack sums[static_cast<unsigned>(kPacks)];
  for (int p = 0; p < kPacks; ++p) sums[p] = L::load(start + p * L::kWidth);
  Count i = 0;
  if constexpr (L::kWidth > 1) {  // two rows at a time: half as many additions wait for one another
    typename L::Pack others[static_cast<unsigned>(kPacks)];
    for (int p = 0; p < kPacks; ++p) others[p] = L::broadcast(0);
    for (; i + 1 < count; i += 2) {
      const Scalar* const row = A + i * stride;
      const auto first = L::broadcast(factors[i]);
      const auto second = L::broadcast(factors[i + 1]);
      for (int p = 0; p < kPacks; ++p) {
        sums[p] += first * L::load(row + p * L::kWidth);
        others[p] += second * L::load(row + stride + p * L::kWidth);
      }
    }
    for (int p = 0; p < kPacks; ++p) sums[p] += others[p];
  }
  for (; i < count; ++i) {
    const auto factor = L::broadcast(factors[i]);
    for (int p = 0; p < kPacks; ++p) sums[p] += factor * L::load(A + i * stride + p * L::kWidth);
  }
  for (int p = 0; p < kPacks; ++p) L::store(y + p * L::kWidth, sums[p]);
}

/// y = start + sum of the `count` rows of A, each times its factor; `stride` from row to row. `start` may be y.
template <class Scalar>
inline void combine_rows(Scalar* y, const Scalar* start, const Scalar* A, Count stride, const Scalar* factors,
                         Count count, Count size) {
  constexpr Count kWidth = Lanes<Scalar>::kWidth;
  Count j = 0;
  for (; j + 3 * kWidth <= size; j += 3 * kWidth) combine_columns<3>(y + j, start + j, A + j, stride, factors, count);
  if (j + 2 * kWidth <= size) {
    combine_columns<2>(y + j, start + j, A + j, stride, factors, count);
  } else if (j < size) {
    combine_columns<1>(y + j, start + j, A + j, stride, factors, count);
  }
}

/// False for NaN and infinity.
template <class Scalar>
inline bool finite(Scalar x) {
  return x - x == 0;
}

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
