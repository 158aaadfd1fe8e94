#include "native/answer_test/exact_integer.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace lcpbench::enumeration {
namespace {

__extension__ using Wide = unsigned __int128;

Limb low(Wide x) { return static_cast<Limb>(x); }
Limb high(Wide x) { return static_cast<Limb>(x >> kLimbBits); }

/// x += limb 2^(64 from) modulo 2^(64 x.size()).
void add_limb(Integer x, std::size_t from, Limb limb) {
  for (std::size_t i = from; limb != 0 && i < x.size(); ++i) {
    x[i] += limb;
    limb = x[i] < limb ? 1 : 0;
  }
}

/// x -= limb 2^(64 from) modulo 2^(64 x.size()).
void subtract_limb(Integer x, std::size_t from, Limb limb) {
  for (std::size_t i = from; limb != 0 && i < x.size(); ++i) {
    const Limb before = x[i];
    x[i] -= limb;
    limb = x[i] > before ? 1 : 0;
  }
}

/// x -= y 2^(64 from) modulo 2^(64 x.size()), y continued with limbs `sign`.
void subtract(Integer x, ConstInteger y, std::size_t from, Limb sign) {
  Limb borrow = 0;
  for (std::size_t i = from; i < x.size(); ++i) {
    const Wide difference = Wide{x[i]} - (i - from < y.size() ? y[i - from] : sign) - borrow;
    x[i] = low(difference);
    borrow = high(difference) & 1;
  }
}

void complement(Integer x) {
  for (Limb& limb : x) limb = ~limb;
}

/// The highest bit that is set. @pre x > 0
std::size_t highest_bit(ConstInteger x) {
  std::size_t i = x.size() - 1;
  while (x[i] == 0) --i;
  return i * kLimbBits + static_cast<std::size_t>(std::bit_width(x[i])) - 1;
}

/// The lowest bit that is set. @pre x != 0
std::size_t lowest_bit(ConstInteger x) {
  std::size_t i = 0;
  while (x[i] == 0) ++i;
  return i * kLimbBits + static_cast<std::size_t>(std::countr_zero(x[i]));
}

/// to = from / 2^bits, rounded down, modulo 2^(64 to.size()); zeros come in from above. May be in place.
void shift_right(Integer to, ConstInteger from, std::size_t bits) {
  const std::size_t limbs = bits / kLimbBits;
  const std::size_t rest = bits % kLimbBits;
  const auto limb = [&](std::size_t i) { return i < from.size() ? from[i] : 0; };
  for (std::size_t i = 0; i < to.size(); ++i) {
    const Limb lower = limb(i + limbs) >> rest;
    to[i] = rest == 0 ? lower : lower | limb(i + limbs + 1) << (kLimbBits - rest);
  }
}

void shift_left(Integer x, std::size_t bits) {
  const std::size_t limbs = bits / kLimbBits;
  const std::size_t rest = bits % kLimbBits;
  for (std::size_t i = x.size(); i-- > 0;) {
    const Limb upper = i < limbs ? 0 : x[i - limbs] << rest;
    x[i] = rest == 0 || i <= limbs ? upper : upper | x[i - limbs - 1] >> (kLimbBits - rest);
  }
}

/// The same number without leading limbs that only repeat its sign.
ConstInteger trimmed(ConstInteger x) {
  const Limb sign = is_negative(x) ? ~Limb{0} : 0;
  std::size_t size = x.size();
  while (size > 1 && x[size - 1] == sign && (x[size - 2] ^ sign) >> (kLimbBits - 1) == 0) --size;
  return x.first(size);
}

}  // namespace

bool is_negative(ConstInteger x) { return x.back() >> (kLimbBits - 1) != 0; }

bool is_zero(ConstInteger x) {
  return std::all_of(x.begin(), x.end(), [](Limb limb) { return limb == 0; });
}

void negate(Integer x) {
  complement(x);
  add_limb(x, 0, 1);
}

void assign(Integer to, ConstInteger from) {
  const std::size_t common = std::min(to.size(), from.size());
  std::copy_n(from.begin(), common, to.begin());
  std::fill(to.begin() + static_cast<std::ptrdiff_t>(common), to.end(), is_negative(from) ? ~Limb{0} : 0);
}

void add_product(Integer sum, ConstInteger a, ConstInteger b) {
  a = trimmed(a);
  b = trimmed(b);
  for (std::size_t j = 0; j < std::min(b.size(), sum.size()); ++j) {
    if (b[j] == 0) continue;
    const std::size_t count = std::min(a.size(), sum.size() - j);
    Limb carry = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const Wide term = Wide{a[i]} * b[j] + sum[j + i] + carry;
      sum[j + i] = low(term);
      carry = high(term);
    }
    add_limb(sum, j + count, carry);
  }
  // Read without sign, a negative number is 2^(64 size) more than it is.
  const bool b_is_negative = is_negative(b);
  if (is_negative(a)) subtract(sum, b, a.size(), b_is_negative ? ~Limb{0} : 0);
  if (b_is_negative) subtract(sum, a, b.size(), 0);
}

void subtract_product(Integer sum, ConstInteger a, ConstInteger b) {
  complement(sum);  // -sum - 1
  add_product(sum, a, b);
  complement(sum);
}

void ExactDivisor::set(ConstInteger divisor) {
  negative_ = is_negative(divisor);
  const Integer odd(odd_.data(), divisor.size());
  assign(odd, divisor);
  if (negative_) negate(odd);
  shift_ = lowest_bit(odd);
  shift_right(odd, odd, shift_);
  size_ = highest_bit(odd) / kLimbBits + 1;
  inverse_ = odd[0];  // right in its last three bits, and in twice as many with each step
  for (int step = 0; step < 5; ++step) inverse_ *= 2 - odd[0] * inverse_;
}

void ExactDivisor::divide(Integer dividend, Integer quotient) const {
  shift_right(quotient, dividend, shift_);
  for (std::size_t i = 0; i < quotient.size(); ++i) {
    const Limb digit = quotient[i] * inverse_;
    if (digit == 0) continue;
    const std::size_t count = std::min(size_, quotient.size() - i);
    Limb borrow = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const Wide term = Wide{digit} * odd_[k] + borrow;
      borrow = high(term) + (quotient[i + k] < low(term) ? 1 : 0);
      quotient[i + k] -= low(term);
    }
    subtract_limb(quotient, i + count, borrow);
    quotient[i] = digit;
  }
  if (negative_) negate(quotient);
}

double nearest_double(Integer numerator, Integer denominator) {
  if (is_zero(numerator)) return 0;
  const bool negative = is_negative(numerator) != is_negative(denominator);
  if (is_negative(numerator)) negate(numerator);
  if (is_negative(denominator)) negate(denominator);
  // The denominator is shifted to fill its limbs, the numerator to have 63 bits more: then the quotient has 63 or 64,
  // and that of the leading limbs is too large by two at most. [Knuth, The Art of Computer Programming 2,
  // section 4.3.1]
  const std::size_t above = highest_bit(numerator);
  const std::size_t below = highest_bit(denominator);
  const std::size_t limbs = std::max(above, below) / kLimbBits + 1;
  shift_left(numerator, kLimbBits * limbs - 1 - above + (kLimbBits - 1));
  shift_left(denominator, kLimbBits * limbs - 1 - below);
  const Wide leading = Wide{numerator[limbs]} << kLimbBits | numerator[limbs - 1];
  Limb quotient = low(leading / denominator[limbs - 1]);
  const Limb with_sign[] = {quotient, 0};
  subtract_product(numerator, denominator, with_sign);
  constexpr Limb kOne[] = {1};
  for (; is_negative(numerator); --quotient) add_product(numerator, denominator, kOne);
  // What is left over is kept as a sticky last bit.
  const Limb bits = quotient | (is_zero(numerator) ? 0U : 1U);
  const double magnitude = std::ldexp(
      static_cast<double>(bits), static_cast<int>(above) - static_cast<int>(below) - (static_cast<int>(kLimbBits) - 1));
  return negative ? -magnitude : magnitude;
}

}  // namespace lcpbench::enumeration
