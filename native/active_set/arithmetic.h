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

/// Sum of a register's lanes, by halves.
template <class Scalar, class Pack>
inline Scalar sum_of_lanes(Pack x) {
  constexpr Count kWidth = static_cast<Count>(sizeof(Pack) / sizeof(Scalar));
  if constexpr (kWidth == 16) {
    return sum_of_lanes<Scalar>(__builtin_shufflevector(x, x, 0, 1, 2, 3, 4, 5, 6, 7) +
                                __builtin_shufflevector(x, x, 8, 9, 10, 11, 12, 13, 14, 15));
  } else if constexpr (kWidth == 8) {
    return sum_of_lanes<Scalar>(__builtin_shufflevector(x, x, 0, 1, 2, 3) + __builtin_shufflevector(x, x, 4, 5, 6, 7));
  } else if constexpr (kWidth == 4) {
    return sum_of_lanes<Scalar>(__builtin_shufflevector(x, x, 0, 1) + __builtin_shufflevector(x, x, 2, 3));
  } else {
    return x[0] + x[1];
  }
}

template <>
struct Lanes<double> : lemke::LCPBENCH_LEVEL::Packed<double> {
  static constexpr double kUnitRoundoff = 0x1p-53;
  static double square_root(double x) { return __builtin_sqrt(x); }
  static double sum(Pack pack) { return sum_of_lanes<double>(pack); }
};

template <>
struct Lanes<float> : lemke::LCPBENCH_LEVEL::Packed<float> {
  static constexpr float kUnitRoundoff = 0x1p-24F;
  static float square_root(float x) { return __builtin_sqrtf(x); }
  static float sum(Pack pack) { return sum_of_lanes<float>(pack); }
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
