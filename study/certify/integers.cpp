#include "study/certify/integers.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

namespace lcpbench::exact {
namespace {

constexpr int kDoubleBits = 53;
/// Rows of a product between two looks at the clock.
constexpr Index kRowsAtOnce = 32;
constexpr slong kSmallestExponent = -1074;  // of the smallest positive double

// The largest e with 2^e <= a / b, for a, b > 0.
slong floor_log2(const Integer& a, const Integer& b) {
  const slong guess = static_cast<slong>(fmpz_bits(a.get())) - static_cast<slong>(fmpz_bits(b.get()));
  Integer left = a;
  Integer right = b;
  shift_left(left, -guess);
  shift_left(right, guess);
  return fmpz_cmp(left.get(), right.get()) >= 0 ? guess : guess - 1;
}

}  // namespace

Parts dyadic(double value) {
  if (value == 0) return {};
  int exponent = 0;
  const auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(value, &exponent), kDoubleBits));
  const int zeros = std::countr_zero(static_cast<std::uint64_t>(mantissa));
  return {mantissa / (std::int64_t{1} << zeros), exponent - kDoubleBits + zeros};
}

IntegerMatrix product(const IntegerMatrix& a, const IntegerMatrix& b, const Deadline& deadline) {
  IntegerMatrix c(a.rows(), b.cols());
  for (Index begin = 0; begin < a.rows(); begin += kRowsAtOnce) {
    deadline.check();
    const Index end = std::min(begin + kRowsAtOnce, a.rows());
    fmpz_mat_t from;
    fmpz_mat_t to;
    fmpz_mat_window_init(from, a.get(), begin, 0, end, a.cols());
    fmpz_mat_window_init(to, c.get(), begin, 0, end, c.cols());
    fmpz_mat_mul(to, from, b.get());
    fmpz_mat_window_clear(from);
    fmpz_mat_window_clear(to);
  }
  return c;
}

IntegerMatrix transposed(const IntegerMatrix& a) {
  IntegerMatrix t(a.cols(), a.rows());
  fmpz_mat_transpose(t.get(), a.get());
  return t;
}

IntegerMatrix columns(const IntegerMatrix& a, const std::vector<Index>& which) {
  IntegerMatrix c(a.rows(), static_cast<Index>(which.size()));
  for (Index j = 0; j < c.cols(); ++j) {
    for (Index i = 0; i < a.rows(); ++i) fmpz_set(c(i, j), a(i, which[index(j)]));
  }
  return c;
}

Dyadic to_dyadic(const Matrix& a) {
  Dyadic result{IntegerMatrix(a.rows(), a.cols()), 0};
  std::optional<slong> smallest;
  for (const double value : a.reshaped()) {
    if (value != 0) smallest = std::min(smallest.value_or(std::numeric_limits<slong>::max()), dyadic(value).exponent);
  }
  result.exponent = smallest.value_or(0);
  for (Index j = 0; j < a.cols(); ++j) {
    for (Index i = 0; i < a.rows(); ++i) fmpz_set_d_2exp(result.m(i, j), a(i, j), -result.exponent);
  }
  return result;
}

Dyadic refined(Dyadic a, slong exponent) {
  fmpz_mat_scalar_mul_2exp(a.m.get(), a.m.get(), static_cast<ulong>(a.exponent - exponent));
  a.exponent = exponent;
  return a;
}

Dyadic product(const Dyadic& a, const Dyadic& b, const Deadline& deadline) {
  return {product(a.m, b.m, deadline), a.exponent + b.exponent};
}

Dyadic transposed(const Dyadic& a) { return {transposed(a.m), a.exponent}; }

double rounded(const Integer& numerator, slong shift, const Integer& denominator) {
  if (numerator.sign() == 0) return 0;
  Integer a;
  fmpz_abs(a.get(), numerator.get());
  // The result is a whole number of units 2^unit: 53 bits of them, fewer below the normal numbers.
  const slong unit = std::max(floor_log2(a, denominator) + shift - (kDoubleBits - 1), kSmallestExponent);
  Integer b = denominator;
  shift_left(a, shift - unit);
  shift_left(b, unit - shift);
  Integer quotient;
  Integer remainder;
  fmpz_fdiv_qr(quotient.get(), remainder.get(), a.get(), b.get());
  fmpz_mul_2exp(remainder.get(), remainder.get(), 1);
  const int half = fmpz_cmp(remainder.get(), b.get());
  if (half > 0 || (half == 0 && fmpz_is_odd(quotient.get()))) fmpz_add_ui(quotient.get(), quotient.get(), 1);
  if (unit > std::numeric_limits<double>::max_exponent)
    return numerator.sign() * std::numeric_limits<double>::infinity();
  return numerator.sign() * std::ldexp(static_cast<double>(fmpz_get_si(quotient.get())), static_cast<int>(unit));
}

Matrix to_doubles(const Dyadic& a) {
  Matrix result(a.m.rows(), a.m.cols());
  const Integer one(1);
  for (Index j = 0; j < result.cols(); ++j) {
    for (Index i = 0; i < result.rows(); ++i) {
      Integer value;
      fmpz_set(value.get(), a.m(i, j));
      result(i, j) = rounded(value, a.exponent, one);
    }
  }
  return result;
}

std::string text(const Integer& value) {
  std::string digits(fmpz_sizeinbase(value.get(), 10) + 2, '\0');
  fmpz_get_str(digits.data(), 10, value.get());
  digits.resize(digits.find('\0'));
  return digits;
}

}  // namespace lcpbench::exact
