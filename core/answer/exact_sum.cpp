#include "core/answer/exact_sum.h"

#include <bit>
#include <cmath>

namespace lcpbench {
namespace {

__extension__ using Wide = unsigned __int128;

/// |x| = mantissa 2^exponent.
struct Parts {
  std::uint64_t mantissa = 0;
  int exponent = 0;
};

Parts parts_of(double x) {
  constexpr int kMantissaBits = 52;
  constexpr int kLowestExponent = -1074;
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const auto fraction = bits & ((std::uint64_t{1} << kMantissaBits) - 1);
  const auto biased = static_cast<int>(bits >> kMantissaBits & 0x7ff);
  if (biased == 0) return {fraction, kLowestExponent};
  return {fraction | std::uint64_t{1} << kMantissaBits, kLowestExponent + biased - 1};
}

/// x 2^exponent.
Quad scaled(Quad x, int exponent) {
  for (; exponent > 1000; exponent -= 1000) x *= Quad{0x1p1000};
  for (; exponent < -1000; exponent += 1000) x *= Quad{0x1p-1000};
  return x * Quad{std::ldexp(1.0, exponent)};
}

}  // namespace

void ExactSum::add(double a, double b, double c) {
  const Parts first = parts_of(a), second = parts_of(b), third = parts_of(c);
  const Wide pair = Wide{first.mantissa} * second.mantissa;  // 106 bits
  if (pair == 0 || third.mantissa == 0) return;
  const Wide low = Wide{static_cast<Limb>(pair)} * third.mantissa;
  const Wide high = (pair >> 64) * third.mantissa + (low >> 64);  // of 159 bits, those from the 64th on
  const auto shift = static_cast<unsigned>(first.exponent + second.exponent + third.exponent - kLowestBit);
  const unsigned rest = shift % 64;
  const auto above = [rest](Limb limb) { return rest == 0 ? 0 : limb >> (64 - rest); };
  const Limb digits[] = {static_cast<Limb>(low), static_cast<Limb>(high), static_cast<Limb>(high >> 64)};
  const Limb parts[] = {digits[0] << rest, digits[1] << rest | above(digits[0]), digits[2] << rest | above(digits[1]),
                        above(digits[2])};
  std::size_t i = shift / 64;
  Limb carry = 0;
  if (std::signbit(a) == (std::signbit(b) != std::signbit(c))) {
    for (const Limb part : parts) {
      const Wide sum = Wide{limbs_[i]} + part + carry;
      limbs_[i++] = static_cast<Limb>(sum);
      carry = static_cast<Limb>(sum >> 64);
    }
    for (; carry != 0 && i < kLimbs; ++i) carry = ++limbs_[i] == 0 ? 1 : 0;
  } else {
    for (const Limb part : parts) {
      const Wide difference = Wide{limbs_[i]} - part - carry;
      limbs_[i++] = static_cast<Limb>(difference);
      carry = static_cast<Limb>(difference >> 64) & 1;
    }
    for (; carry != 0 && i < kLimbs; ++i) carry = limbs_[i]-- == 0 ? 1 : 0;
  }
}

int ExactSum::sign() const {
  if (limbs_.back() >> 63 != 0) return -1;
  for (const Limb limb : limbs_) {
    if (limb != 0) return 1;
  }
  return 0;
}

Quad ExactSum::value() const {
  const bool negative = limbs_.back() >> 63 != 0;
  std::array<Limb, kLimbs> magnitude = limbs_;
  if (negative) {
    bool carry = true;
    for (Limb& limb : magnitude) carry = (limb = ~limb + (carry ? 1 : 0)) == 0 && carry;
  }
  std::size_t top = kLimbs;
  while (top > 0 && magnitude[top - 1] == 0) --top;
  const std::size_t least = top < 3 ? 0 : top - 3;
  Quad value = 0;
  for (std::size_t i = top; i-- > least;) value = value * Quad{0x1p64} + static_cast<Quad>(magnitude[i]);
  value = scaled(value, 64 * static_cast<int>(least) + kLowestBit);
  return negative ? -value : value;
}

}  // namespace lcpbench
