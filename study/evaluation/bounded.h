#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <limits>
#include <optional>
#include <vector>

#include "core/quad.h"

namespace lcpbench {

/// Thrown where the bound of a Bounded is too wide for a decision. The caller then evaluates in 113 bits.
struct Doubt : std::exception {
  const char* what() const noexcept override { return "the bound on the rounding leaves this open"; }
};

/// A number as the sum of two doubles, about 106 bits, with a bound on its error. The evaluation computes in this
/// arithmetic first, and in 113 bits where the bound leaves a decision open.
///
/// The exact number differs from high + low by at most 2 error. The factor 2 makes up for the rounding of `error`
/// itself, of which each operation loses a few parts in 2^53. What overflows ends as NaN or with an infinite error, and
/// what may have lost bits to underflow with an error that covers them, so that no decision is taken on it.
/// Operations that need no rounding add no error. Relies on arithmetic as written (no contraction).
struct Bounded {
  double high = 0;
  double low = 0;
  double error = 0;

  Bounded() = default;
  Bounded(double value) : high(value) {}  // NOLINT: doubles convert as they do to Quad
  Bounded(double first, double second, double bound) : high(first), low(second), error(bound) {}

  bool exact() const { return error == 0; }
};

namespace bounded {

constexpr double kRoundoff = 0x1p-53;
/// Products of a smaller magnitude may lose bits below the range of a double, less than kLost.
constexpr double kSmallProduct = 0x1p-900;
constexpr double kLost = 0x1p-1000;

/// Two doubles whose exact sum is a + b, or a b.
struct Pair {
  double high;
  double low;
};

inline Pair exact_sum(double a, double b) {
  const double sum = a + b;
  const double part = sum - a;
  return {sum, (a - (sum - part)) + (b - part)};
}

/// The leading 26 bits and the rest. [Veltkamp 1968]
inline Pair split(double a) {
  const double scaled = 134217729.0 * a;
  const double leading = scaled - (scaled - a);
  return {leading, a - leading};
}

/// [Dekker 1971] Without a fused multiply-add, which is slow where the processor is not known to have it.
inline Pair exact_product(double a, double b) {
  const double product = a * b;
  const Pair x = split(a), y = split(b);
  return {product, ((x.high * y.high - product) + x.high * y.low + x.low * y.high) + x.low * y.low};
}

inline Bounded unknown() {
  return {std::numeric_limits<double>::quiet_NaN(), 0, std::numeric_limits<double>::infinity()};
}

/// A bound on what exact_product(a, b), whose leading part is `product`, may have lost to underflow.
inline double lost(double product, double a, double b) {
  return std::abs(product) > kSmallProduct || a == 0 || b == 0 ? 0 : kLost;
}

/// high + low, `error` covering all else.
inline Bounded normalised(double high, double low, double error) {
  const Pair sum = exact_sum(high, low);
  return {sum.high, sum.low, error};
}

}  // namespace bounded

using BoundedVector = std::vector<Bounded>;

inline bool is_finite(const Bounded& x) {
  return std::isfinite(x.high) && std::isfinite(x.low) && std::isfinite(x.error);
}

inline Bounded operator-(const Bounded& a) { return {-a.high, -a.low, a.error}; }

inline Bounded operator+(const Bounded& a, const Bounded& b) {
  const bounded::Pair sum = bounded::exact_sum(a.high, b.high);
  const double lows = a.low + b.low;
  if (lows == 0) return {sum.high, sum.low, a.error + b.error};
  const double low = sum.low + lows;
  return bounded::normalised(sum.high, low, a.error + b.error + bounded::kRoundoff * (std::abs(lows) + std::abs(low)));
}

inline Bounded operator-(const Bounded& a, const Bounded& b) { return a + -b; }

inline Bounded operator*(const Bounded& a, const Bounded& b) {
  if ((a.high == 0 && a.error == 0 && is_finite(b)) || (b.high == 0 && b.error == 0 && is_finite(a))) return 0.0;
  const bounded::Pair product = bounded::exact_product(a.high, b.high);
  double error = std::abs(a.high) * b.error + std::abs(b.high) * a.error + 2 * (a.error * b.error) +
                 bounded::lost(product.high, a.high, b.high);
  if (a.error != 0 || b.error != 0) error += bounded::kLost;
  if (a.low == 0 && b.low == 0) return {product.high, product.low, error};
  error += 0x1p-102 * std::abs(product.high) + bounded::kLost;
  return bounded::normalised(product.high, product.low + (a.high * b.low + a.low * b.high), error);
}

inline Bounded& operator+=(Bounded& a, const Bounded& b) { return a = a + b; }
inline Bounded& operator-=(Bounded& a, const Bounded& b) { return a = a - b; }

inline Bounded operator/(const Bounded& a, const Bounded& b) {
  if (!(std::abs(b.high) > 8 * b.error)) return bounded::unknown();
  const double first = a.high / b.high;
  const Bounded rest = Bounded(a.high, a.low, 0) - Bounded(b.high, b.low, 0) * first;
  if (rest.high == 0 && rest.error == 0 && a.error == 0 && b.error == 0) return first;
  const double magnitude = std::abs(first);
  const double error = 0x1p-100 * magnitude + (rest.error + a.error + magnitude * b.error) * 2 / std::abs(b.high);
  return bounded::normalised(first, rest.high / b.high, error + bounded::kLost);
}

/// Whether a is known to be exactly b.
inline bool surely_equal(const Bounded& a, double b) { return a.error == 0 && a.high == b && a.low == 0; }
inline bool surely_equal(Quad a, double b) { return a == b; }

/// Whether a < b for all numbers that the bounds allow. False for NaN.
inline bool surely_less(const Bounded& a, const Bounded& b) {
  if (!(a.high <= b.high)) return false;
  const double apart = (b.high - a.high) + (b.low - a.low);
  return apart > 4 * (a.error + b.error) && apart > 0x1p-40 * std::abs(b.low - a.low);
}
inline bool surely_less(Quad a, Quad b) { return a < b; }

/// Whether a <= b is certain: a is surely less, or both are known exactly and equal.
inline bool surely_at_most(const Bounded& a, const Bounded& b) {
  return surely_less(a, b) || (a.error == 0 && b.error == 0 && a.high == b.high && a.low == b.low);
}
inline bool surely_at_most(Quad a, Quad b) { return a <= b; }

inline Bounded abs(const Bounded& x) { return x.high < 0 ? -x : x; }

/// The maximum of both, with a bound on its error also where it is open which is the larger.
inline Bounded larger(const Bounded& a, const Bounded& b) {
  if (surely_less(a, b)) return b;
  if (surely_less(b, a)) return a;
  if (std::isnan(a.high + b.high + a.error + b.error)) return bounded::unknown();
  const bool second = a.high < b.high || (a.high == b.high && a.low < b.low);
  const Bounded& chosen = second ? b : a;
  return {chosen.high, chosen.low, std::max(a.error, b.error)};
}
inline Quad larger(Quad a, Quad b) { return a < b ? b : a; }

inline Bounded smaller(const Bounded& a, const Bounded& b) { return -larger(-a, -b); }
inline Quad smaller(Quad a, Quad b) { return b < a ? b : a; }

/// @pre x >= 0
inline Bounded sqrt(const Bounded& x) {
  if (x.high == 0 && x.error == 0) return 0.0;
  const double root = std::sqrt(x.high);
  if (!(x.high > 8 * x.error) || !std::isfinite(root)) return bounded::unknown();
  const bounded::Pair square = bounded::exact_product(root, root);
  const Bounded rest =
      Bounded(x.high, x.low, 0) - Bounded(square.high, square.low, bounded::lost(square.high, root, root));
  const double error = 0x1p-100 * root + (x.error + rest.error) / root;
  return bounded::normalised(root, rest.high / (2 * root), error);
}

/// value / scale, with 0/0 = 0 and x/0 = infinity for x of either sign. Unknown where the bounds leave open whether
/// scale is 0, or whether the x of x/0 is.
inline Bounded quotient(const Bounded& value, const Bounded& scale) {
  if (surely_equal(value, 0)) return 0.0;
  if (surely_equal(scale, 0)) {
    return surely_less(0.0, abs(value)) ? Bounded(std::numeric_limits<double>::infinity()) : bounded::unknown();
  }
  return value / scale;
}

/// start + sum_k a_k x_k. Only sums of low parts are rounded; the sum of their magnitudes bounds this rounding.
class BoundedSum {
 public:
  explicit BoundedSum(const Bounded& start = 0.0)
      : high_(start.high), low_(start.low), error_(start.error), lows_(std::abs(start.low)) {}
  void add(double a, const Bounded& x) { add(a, x, bounded::exact_product(a, x.high)); }
  /// @param product  of a and x.high, exactly.
  void add(double a, const Bounded& x, const bounded::Pair& product) {
    const bounded::Pair sum = bounded::exact_sum(high_, product.high);
    const double of_low = a * x.low;
    high_ = sum.high;
    low_ += sum.low + (product.low + of_low);
    lows_ += std::abs(sum.low) + std::abs(product.low) + std::abs(of_low);
    error_ += std::abs(a) * x.error + bounded::lost(product.high, a, x.high);
    inexact_ = inexact_ || x.error != 0 || x.low != 0;  // either product may have vanished
    ++terms_;
  }
  Bounded value() const {
    const double inexact = lows_ == 0 && error_ == 0 && !inexact_ ? 0 : bounded::kLost;
    return bounded::normalised(high_, low_, error_ + bounded::kRoundoff * (terms_ + 4) * lows_ + inexact);
  }

 private:
  double high_, low_, error_, lows_;
  double terms_ = 0;
  bool inexact_ = false;
};

/// The sum of values[e] x[rows[e]] for e < count, by BoundedSum, with fused multiply-adds where the processor has them:
/// they give the same numbers, unless a product leaves the range in which Dekker's splitting is exact.
using BoundedDot = Bounded (*)(const double* values, const std::size_t* rows, std::size_t count, const Bounded* x);
BoundedDot bounded_dot_of_level();

/// The same sum without any rounding but that of the result, for x without errors and where no bits are lost at the
/// lower end of the range of a double; else nothing. For sums whose terms cancel so far that BoundedSum cannot tell the
/// sign, as the relative velocity of two bodies with equal velocities, which is zero. O(count^2)
std::optional<Bounded> exact_dot(const double* values, const std::size_t* rows, std::size_t count, const Bounded* x);

/// The largest relative error of a measure that settled() returns. The report prints at most six digits; the files of
/// tables have all digits, of which nine are significant.
inline constexpr double kSettled = 0x1p-30;

/// The largest absolute error of a measure relative to the data, whose own rounding to double is as large.
inline constexpr double kSettledByData = 0x1p-53;

/// Whether the error is at most kSettled |x|, or at most `absolute`. Infinity is settled where it is exact, NaN never.
inline bool is_settled(const Bounded& x, double absolute = 0) {
  const bool infinite = x.exact() && std::isinf(x.high) && x.low == 0;
  return infinite || (is_finite(x) && 2 * x.error <= std::max(kSettled * std::abs(x.high), absolute));
}

/// x as a double. @throws Doubt unless it is settled.
inline double settled(const Bounded& x, double absolute = 0) {
  if (!is_settled(x, absolute)) throw Doubt();
  return x.high;
}
inline double settled(Quad x, double = 0) { return to_double(x); }

/// The leading part. The error is ignored.
inline double to_double(const Bounded& x) { return x.high; }

/// The leading part, to order numbers before it is tested whether their bounds allow this order. Of a Bounded that is
/// NaN it is infinity.
inline Quad leading(Quad x) { return x; }
inline double leading(const Bounded& x) {
  return std::isnan(x.high) ? std::numeric_limits<double>::infinity() : x.high;
}

}  // namespace lcpbench
