#pragma once

#include <algorithm>
#include <cmath>

namespace lcpbench {

/// Logarithms and powers to base 2, linear between powers of two, so that no library decides their last bit: to about
/// 0.09 and 6 %. Both rise, and each is the inverse of the other.
/// @pre x > 0 and finite
inline double log2_of(double x) {
  int exponent = 0;
  const double mantissa = std::frexp(x, &exponent);  // in [1/2, 1)
  return exponent - 2 + 2 * mantissa;
}
inline double power_of_two(double y) {
  const double exponent = std::clamp(y, -1000.0, 1000.0);  // what a double holds
  const double whole = std::floor(exponent);
  return std::ldexp(1 + (exponent - whole), static_cast<int>(whole));
}
/// x^exponent. @pre x > 0 and finite
inline double power(double x, double exponent) { return power_of_two(exponent * log2_of(x)); }

}  // namespace lcpbench
