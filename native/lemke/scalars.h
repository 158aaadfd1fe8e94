#pragma once

#include "native/lemke/pack.h"

#if defined(LCPBENCH_QUAD)
#include "core/quad.h"
#elif defined(LCPBENCH_DOUBLE_DOUBLE)
#include "native/contact_lemke/double_double.h"
#endif

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// One number at a time: no processor has packs of more than 53 bits.
template <class Scalar>
struct Single {
  using Pack = Scalar;
  static constexpr Count kWidth = 1;

  static Pack load(const Scalar* from) { return *from; }
  static void store(Scalar* to, Pack pack) { *to = pack; }
  static Pack broadcast(Scalar value) { return value; }
  static Pack min(Pack a, Pack b) { return a < b ? a : b; }
  static Pack max(Pack a, Pack b) { return a > b ? a : b; }
  static Scalar min(Pack pack) { return pack; }
  static Scalar max(Pack pack) { return pack; }
  static Scalar sum(Pack pack) { return pack; }
  static Count padded(Count size) { return size; }
};

#if defined(LCPBENCH_QUAD)
template <>
struct Packed<Quad> : Single<Quad> {};
inline Quad square_root(Quad x) { return sqrt(x); }
template <class Scalar>
constexpr double kUnitRoundoff = kQuadUnitRoundoff;
#elif defined(LCPBENCH_DOUBLE_DOUBLE)
template <>
struct Packed<DoubleDouble> : Single<DoubleDouble> {};
template <class Scalar>
constexpr double kUnitRoundoff = 0x1p-104;  // of the sums and products of double_double.h
#else
template <class Scalar>
constexpr double kUnitRoundoff = sizeof(Scalar) == sizeof(float) ? 0x1p-24 : 0x1p-53;
inline double square_root(double x) { return __builtin_sqrt(x); }
inline float square_root(float x) { return __builtin_sqrtf(x); }
#endif

template <class Scalar>
inline void copy(Scalar* to, const Scalar* from, Count length) {
  using P = Packed<Scalar>;
  for (Count i = 0; i < length; i += P::kWidth) P::store(to + i, P::load(from + i));
}

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
