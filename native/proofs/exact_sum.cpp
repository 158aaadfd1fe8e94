#include "native/proofs/exact_sum.h"

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

}  // namespace

void ExactSum::add(double a, double b) {
  const Parts left = parts_of(a);
  const Parts right = parts_of(b);
  const Wide product = Wide{left.mantissa} * right.mantissa;  // 106 bits
  if (product == 0) return;
  const auto shift = static_cast<unsigned>(left.exponent + right.exponent - kLowestBit);
  std::size_t i = shift / 64;
  const unsigned rest = shift % 64;
  const Wide low = product << rest;
  const Limb high = rest == 0 ? 0 : static_cast<Limb>(product >> (128 - rest));
  const Limb parts[] = {static_cast<Limb>(low), static_cast<Limb>(low >> 64), high};
  Limb carry = 0;
  if (std::signbit(a) == std::signbit(b)) {
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

}  // namespace lcpbench
