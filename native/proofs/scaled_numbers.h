#pragma once

#include <cmath>
#include <limits>

#include "core/quad.h"

namespace lcpbench {

constexpr int kNoExponent = std::numeric_limits<int>::min();

inline Quad magnitude(Quad x) { return x < 0 ? -x : x; }
inline double magnitude(double x) { return std::fabs(x); }

/// x 2^exponent.
inline double scaled(double x, int exponent) { return std::ldexp(x, exponent); }
inline Quad scaled(Quad x, int exponent) {
  for (; exponent > 1000; exponent -= 1000) x *= Quad{0x1p1000};
  for (; exponent < -1000; exponent += 1000) x *= Quad{0x1p-1000};
  return x * static_cast<Quad>(std::ldexp(1.0, exponent));
}

/// The exponent of the power of two of x; kNoExponent for zero.
inline int exponent_of(double x) { return x == 0 ? kNoExponent : std::ilogb(x); }

}  // namespace lcpbench
