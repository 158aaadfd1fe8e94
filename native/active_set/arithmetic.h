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

template <>
struct Lanes<double> : lemke::LCPBENCH_LEVEL::Packed<double> {
  static constexpr double kUnitRoundoff = 0x1p-53;
  static double square_root(double x) { return __builtin_sqrt(x); }
};

template <>
struct Lanes<float> : lemke::LCPBENCH_LEVEL::Packed<float> {
  static constexpr float kUnitRoundoff = 0x1p-24F;
  static float square_root(float x) { return __builtin_sqrtf(x); }
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
  auto sum = L::broadcast(0);
  for (Count i = 0; i < size; i += L::kWidth) sum += L::load(x + i) * L::load(y + i);
  return L::sum(sum);
}

/// y = start + sum of the `count` rows of A, each times its factor; `stride` from row to row. `start` may be y.
template <class Scalar>
inline void combine_rows(Scalar* y, const Scalar* start, const Scalar* A, Count stride, const Scalar* factors,
                         Count count, Count size) {
  using L = Lanes<Scalar>;
  for (Count j = 0; j < size; j += L::kWidth) {
    auto sum = L::load(start + j);
    for (Count i = 0; i < count; ++i) sum += L::broadcast(factors[i]) * L::load(A + i * stride + j);
    L::store(y + j, sum);
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
