#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/quad_matrix.h"
#include "core/types.h"
#include "study/evaluation/bounded.h"

// Vectors, and decisions on numbers, of the measures of an answer. Real is Quad (113 bits) or Bounded (about 106 bits
// with an error bound, tried first). Two vectors have the same length.

namespace lcpbench {

template <class Real>
std::vector<Real> numbers(const Vector& x) {
  return std::vector<Real>(x.begin(), x.end());
}

// Terms with a_i = 0 are left out, unless b_i is not finite: then the sum is NaN.
template <class Real>
Real dot(const std::vector<Real>& a, const std::vector<Real>& b) {
  Real sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!surely_equal(a[i], 0) || !is_finite(b[i])) sum += a[i] * b[i];
  }
  return sum;
}

// 0 for no entries. @pre finite entries: of Quad a NaN would not count
template <class Real>
Real max_abs(const std::vector<Real>& x) {
  Real largest = 0;
  for (const Real& value : x) largest = larger(largest, abs(value));
  return largest;
}

template <class Real>
std::vector<Real> difference(std::vector<Real> a, const std::vector<Real>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

template <class Real>
std::vector<Real> sum(std::vector<Real> a, const std::vector<Real>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

template <class Real>
std::vector<Real> magnitudes(std::vector<Real> x) {
  for (Real& value : x) value = abs(value);
  return x;
}

// True only where x is exactly 0, false where the error bound leaves it open.
template <class Real>
bool is_zero(const Real& x) {
  return surely_equal(x, 0);
}

template <class Real>
bool all_finite(const std::vector<Real>& x) {
  return std::all_of(x.begin(), x.end(), [](const Real& value) { return is_finite(value); });
}

// True only where one is exactly 0 and the other surely at least 0.
template <class Real>
bool is_complementary(const Real& a, const Real& b) {
  return (surely_equal(a, 0) && surely_at_most(0, b)) || (surely_equal(b, 0) && surely_less(0, a));
}

template <class Real>
bool all_complementary(const std::vector<Real>& z, const std::vector<Real>& w) {
  return std::equal(z.begin(), z.end(), w.begin(), is_complementary<Real>);
}

// max_i |value_i| / scale_i, with 0/0 = 0 and x/0 = infinity. @pre finite entries: of Quad a NaN would not count
template <class Real>
Real largest_quotient(const std::vector<Real>& values, const std::vector<Real>& scales) {
  Real largest = 0;
  for (std::size_t i = 0; i < values.size(); ++i) largest = larger(largest, quotient(abs(values[i]), scales[i]));
  return largest;
}

// Whether x, rounded to double, is at most or below a bound. False for NaN.
inline bool at_most(Quad x, double bound) { return to_double(x) <= bound; }
inline bool below(Quad x, double bound) { return to_double(x) < bound; }
inline bool difference_below(Quad a, Quad b, double bound) { return to_double(a) - to_double(b) < bound; }

// The same. @throws Doubt where the error bound, or what rounding to double may change, leaves it open; for NaN, too
inline bool below(Bounded x, double bound) {
  x.error += 0x1p-50 * (std::abs(x.high) + bound);
  if (surely_less(x, bound)) return true;
  if (surely_less(bound, x)) return false;
  throw Doubt();
}
inline bool at_most(const Bounded& x, double bound) { return below(x, bound); }
inline bool difference_below(const Bounded& a, const Bounded& b, double bound) {
  Bounded x = a - b;
  x.error += 0x1p-50 * (std::abs(a.high) + std::abs(b.high));
  return below(x, bound);
}

}  // namespace lcpbench
