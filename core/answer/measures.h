#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/quad_matrix.h"
#include "core/types.h"

// Vectors of the measures of an answer. Two of them have the same length.

namespace lcpbench {

inline Quad larger(Quad a, Quad b) { return a < b ? b : a; }
inline Quad smaller(Quad a, Quad b) { return b < a ? b : a; }

inline Quad finite_or_infinity(Quad x) { return is_finite(x) ? x : Quad{HUGE_VAL}; }

inline QuadVector numbers(const Vector& x) { return {x.begin(), x.end()}; }

// Terms with a_i = 0 are left out, unless b_i is not finite: then the sum is NaN.
inline Quad inner(const QuadVector& a, const QuadVector& b) {
  Quad sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i] != 0 || !is_finite(b[i])) sum += a[i] * b[i];
  }
  return sum;
}

// 0 for no entries. @pre finite entries: a NaN would not count
inline Quad max_abs(const QuadVector& x) {
  Quad largest = 0;
  for (const Quad value : x) largest = larger(largest, abs(value));
  return largest;
}

inline QuadVector difference(QuadVector a, const QuadVector& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

inline QuadVector magnitudes(QuadVector x) {
  for (Quad& value : x) value = abs(value);
  return x;
}

inline bool all_finite(const QuadVector& x) {
  return std::all_of(x.begin(), x.end(), [](Quad value) { return is_finite(value); });
}

// Whether one is 0 and the other at least 0.
inline bool is_complementary(Quad a, Quad b) { return (a == 0 && b >= 0) || (b == 0 && a > 0); }

// Rows of which one is 0 and the other at least 0 are left out.
inline Quad complementarity(const QuadVector& z, const QuadVector& w) {
  Quad sum = 0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    if (!is_complementary(z[i], w[i])) sum += z[i] * w[i];
  }
  return sum;
}

}  // namespace lcpbench
