#pragma once

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// The unevaluated sum of two doubles, the second at most half a unit in the last place of the first: about 106 bits
/// and the range of a double, some twenty times as fast as 113 bits in software. [Dekker 1971; Hida, Li, Bailey 2001]
///
/// Needs arithmetic as written: no contraction of its own products and sums. Where the first part is infinite or not a
/// number, the second means nothing.
struct DoubleDouble {
  double high;
  double low;

  DoubleDouble() = default;
  constexpr DoubleDouble(double value) : high(value), low(0) {}  // NOLINT: numbers convert as they do to double
  constexpr DoubleDouble(double first, double second) : high(first), low(second) {}
  explicit operator double() const { return high; }

  /// first + second for |first| >= |second|
  static DoubleDouble renormalised(double first, double second) {
    const double sum = first + second;
    return {sum, second - (sum - first)};
  }
  static DoubleDouble exact_sum(double a, double b) {
    const double sum = a + b;
    const double part = sum - a;
    return {sum, (a - (sum - part)) + (b - part)};
  }
  static DoubleDouble exact_product(double a, double b) {
    const double product = a * b;
    return {product, __builtin_fma(a, b, -product)};
  }

  DoubleDouble operator-() const { return {-high, -low}; }
  friend DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {
    const DoubleDouble first = exact_sum(a.high, b.high);
    const DoubleDouble second = exact_sum(a.low, b.low);
    const DoubleDouble sum = renormalised(first.high, first.low + second.high);
    return renormalised(sum.high, sum.low + second.low);
  }
  friend DoubleDouble operator-(DoubleDouble a, DoubleDouble b) { return a + -b; }
  friend DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {
    const DoubleDouble product = exact_product(a.high, b.high);
    return renormalised(product.high, product.low + (a.high * b.low + a.low * b.high));
  }
  friend DoubleDouble operator/(DoubleDouble a, DoubleDouble b) {
    const double first = a.high / b.high;
    if (!(first - first == 0)) return first;
    const DoubleDouble rest = a - b * first;
    const double second = rest.high / b.high;
    const double third = (rest - b * second).high / b.high;
    return renormalised(first, second) + DoubleDouble(third);
  }
  DoubleDouble& operator+=(DoubleDouble other) { return *this = *this + other; }
  DoubleDouble& operator-=(DoubleDouble other) { return *this = *this - other; }
  DoubleDouble& operator*=(DoubleDouble other) { return *this = *this * other; }
  DoubleDouble& operator/=(DoubleDouble other) { return *this = *this / other; }

  friend bool operator==(DoubleDouble a, DoubleDouble b) { return a.high == b.high && a.low == b.low; }
  friend bool operator!=(DoubleDouble a, DoubleDouble b) { return !(a == b); }
  friend bool operator<(DoubleDouble a, DoubleDouble b) {
    return a.high < b.high || (a.high == b.high && a.low < b.low);
  }
  friend bool operator>(DoubleDouble a, DoubleDouble b) { return b < a; }
  friend bool operator<=(DoubleDouble a, DoubleDouble b) {
    return a.high < b.high || (a.high == b.high && a.low <= b.low);
  }
  friend bool operator>=(DoubleDouble a, DoubleDouble b) { return b <= a; }
};

/// One step of Newton's method from the root in double.
inline DoubleDouble square_root(DoubleDouble x) {
  const double root = __builtin_sqrt(x.high);
  if (!(root > 0) || !(root - root == 0)) return root;
  const DoubleDouble rest = x - DoubleDouble::exact_product(root, root);
  return DoubleDouble::renormalised(root, rest.high / (2 * root));
}

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
