#pragma once

#include "native/lemke_engine/pack.h"

#if defined(LCPBENCH_WITH_QUAD)
#include "core/quad.h"
#endif

namespace lcpbench::active_set::LCPBENCH_LEVEL {

using lemke::LCPBENCH_LEVEL::Buffer;
using lemke::LCPBENCH_LEVEL::Count;
using lemke::LCPBENCH_LEVEL::kInfinity;

/// Registers of a scalar type, and what the method needs to know of its arithmetic.
template <class Scalar>
struct Lanes;

/// Combines a register's lanes by halves. They are copied out, since GCC has __builtin_shufflevector from version 12 on
/// only; that takes no longer.
template <class Scalar, class Pack, class Combine>
inline Scalar reduce_lanes(Pack x, Combine combine) {
  constexpr std::size_t kHalfSize = sizeof(Pack) / 2;
  if constexpr (kHalfSize == sizeof(Scalar)) {
    return combine(x[0], x[1]);
  } else {
    typedef Scalar Half __attribute__((vector_size(kHalfSize)));
    Half low, high;
    __builtin_memcpy(&low, &x, kHalfSize);
    __builtin_memcpy(&high, reinterpret_cast<const char*>(&x) + kHalfSize, kHalfSize);
    return reduce_lanes<Scalar>(combine(low, high), combine);
  }
}

template <class Scalar, class Pack>
inline Scalar sum_of_lanes(Pack x) {
  return reduce_lanes<Scalar>(x, [](auto a, auto b) { return a + b; });
}

template <class Scalar, class Pack>
inline Scalar largest_lane(Pack x) {
  return reduce_lanes<Scalar>(x, [](auto a, auto b) { return a > b ? a : b; });
}

template <>
struct Lanes<double> : lemke::LCPBENCH_LEVEL::Packed<double> {
  static constexpr double kUnitRoundoff = 0x1p-53;
  static double square_root(double x) { return __builtin_sqrt(x); }
  using lemke::LCPBENCH_LEVEL::Packed<double>::max;
  static double sum(Pack pack) { return sum_of_lanes<double>(pack); }
  static double max(Pack pack) { return largest_lane<double>(pack); }
};

template <>
struct Lanes<float> : lemke::LCPBENCH_LEVEL::Packed<float> {
  static constexpr float kUnitRoundoff = 0x1p-24F;
  static float square_root(float x) { return __builtin_sqrtf(x); }
  using lemke::LCPBENCH_LEVEL::Packed<float>::max;
  static float sum(Pack pack) { return sum_of_lanes<float>(pack); }
  static float max(Pack pack) { return largest_lane<float>(pack); }
};

#if defined(LCPBENCH_WITH_QUAD)
template <>
struct Lanes<Quad> {
  using Pack = Quad;
  static constexpr Count kWidth = 1;
  static constexpr double kUnitRoundoff = kQuadUnitRoundoff;
  static Quad square_root(Quad x) { return lcpbench::sqrt(x); }
  static Pack load(const Quad* from) { return *from; }
  static void store(Quad* to, Pack pack) { *to = pack; }
  static Pack broadcast(Quad value) { return value; }
  static Pack min(Pack a, Pack b) { return a < b ? a : b; }
  static Pack max(Pack a, Pack b) { return a > b ? a : b; }
  static Quad sum(Pack pack) { return pack; }
  static Quad max(Pack pack) { return pack; }
  static Count padded(Count size) { return size; }
};
#endif

// Arrays below have a length that is a multiple of the register's width, zero beyond their content.

/// y += factor x.
template <class Scalar>
inline void add_multiple(Scalar* y, Scalar factor, const Scalar* x, Count size) {
  using L = Lanes<Scalar>;
  const auto broadcast = L::broadcast(factor);
  for (Count i = 0; i < size; i += L::kWidth) L::store(y + i, L::load(y + i) + broadcast * L::load(x + i));
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

template <class Scalar>
inline void scale(Scalar* x, Scalar factor, Count size) {
  using L = Lanes<Scalar>;
  const auto broadcast = L::broadcast(factor);
  for (Count i = 0; i < size; i += L::kWidth) L::store(x + i, broadcast * L::load(x + i));
}

template <class Scalar>
inline void copy(Scalar* to, const Scalar* from, Count size) {
  using L = Lanes<Scalar>;
  for (Count i = 0; i < size; i += L::kWidth) L::store(to + i, L::load(from + i));
}

template <class Scalar>
inline void set_zero(Scalar* x, Count size) {
  using L = Lanes<Scalar>;
  for (Count i = 0; i < size; i += L::kWidth) L::store(x + i, L::broadcast(0));
}

template <class Scalar>
inline Scalar dot(const Scalar* x, const Scalar* y, Count size) {
  using L = Lanes<Scalar>;
  if (size == L::kWidth) return L::sum(L::load(x) * L::load(y));
  if (size == 2 * L::kWidth) {
    return L::sum(L::load(x) * L::load(y) + L::load(x + L::kWidth) * L::load(y + L::kWidth));
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
  for (Count i = 0; i < count; ++i) {
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

template <class Scalar>
inline Scalar magnitude(Scalar x) {
  return x < 0 ? -x : x;
}

/// False for NaN and infinity.
template <class Scalar>
inline bool finite(Scalar x) {
  return x - x == 0;
}

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
