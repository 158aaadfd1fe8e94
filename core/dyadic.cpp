#include "core/dyadic.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lcpbench {
namespace {

__extension__ using Wide = unsigned __int128;
using Limb = Dyadic::Limb;
constexpr int kLimbBits = Dyadic::kLimbBits;

/// x += y 2^(64 from). @pre x is long enough for the sum
void add(std::vector<Limb>& x, const std::vector<Limb>& y, std::size_t from) {
  Limb carry = 0;
  for (std::size_t i = from; i < x.size() && (i - from < y.size() || carry != 0); ++i) {
    const Wide sum = Wide{x[i]} + (i - from < y.size() ? y[i - from] : 0) + carry;
    x[i] = static_cast<Limb>(sum);
    carry = static_cast<Limb>(sum >> kLimbBits);
  }
}

/// x -= y 2^(64 from). @pre the result is not negative
void subtract(std::vector<Limb>& x, const std::vector<Limb>& y, std::size_t from) {
  Limb borrow = 0;
  for (std::size_t i = from; i < x.size() && (i - from < y.size() || borrow != 0); ++i) {
    const Wide difference = Wide{x[i]} - (i - from < y.size() ? y[i - from] : 0) - borrow;
    x[i] = static_cast<Limb>(difference);
    borrow = static_cast<Limb>(difference >> kLimbBits) & 1;
  }
}

/// The magnitude in the leading limbs, as a number in [1, 2^192] times 2^(64 exponent). @pre x != 0
Quad leading(const Dyadic& x, std::int64_t& exponent) {
  const std::size_t count = std::min<std::size_t>(3, x.limbs().size());
  Quad value = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const Limb limb = x.limbs()[x.limbs().size() - 1 - k];
    value = value * 0x1p64 + static_cast<double>(limb >> 32) * 0x1p32 + static_cast<double>(limb & 0xFFFFFFFF);
  }
  exponent = x.high() - static_cast<std::int64_t>(count);
  return value;
}

}  // namespace

Dyadic::Dyadic(double x) {
  if (x == 0) return;
  int exponent = 0;
  const double fraction = std::frexp(std::abs(x), &exponent);
  constexpr int kFractionBits = 53;
  const auto integer = static_cast<Limb>(std::ldexp(fraction, kFractionBits));
  exponent -= kFractionBits;
  const int limb = exponent >> 6;  // over kLimbBits, rounded down
  const Wide wide = Wide{integer} << (exponent - limb * kLimbBits);
  *this = Dyadic(x < 0 ? -1 : 1, {static_cast<Limb>(wide), static_cast<Limb>(wide >> kLimbBits)}, limb);
}

Dyadic::Dyadic(Quad x) {
  std::int64_t shift = 0;  // to where three doubles hold every bit of x
  for (; abs(x) >= 0x1p900; ++shift) x *= 0x1p-64;
  for (; x != 0 && abs(x) < 0x1p-700; --shift) x *= 0x1p64;
  while (x != 0) {
    const double part = to_double(x);
    *this += Dyadic(part);
    x -= part;
  }
  *this = shifted(shift);
}

Dyadic::Dyadic(int sign, std::vector<Limb> limbs, std::int64_t low)
    : sign_(sign), low_(low), limbs_(std::move(limbs)) {
  trim();
}

void Dyadic::trim() {
  while (!limbs_.empty() && limbs_.back() == 0) limbs_.pop_back();
  std::size_t zeros = 0;
  while (zeros < limbs_.size() && limbs_[zeros] == 0) ++zeros;
  limbs_.erase(limbs_.begin(), limbs_.begin() + static_cast<std::ptrdiff_t>(zeros));
  low_ += static_cast<std::int64_t>(zeros);
  if (limbs_.empty()) {
    sign_ = 0;
    low_ = 0;
  }
}

Dyadic Dyadic::shifted(std::int64_t limbs) const {
  Dyadic result = *this;
  if (sign_ != 0) result.low_ += limbs;
  return result;
}

Dyadic Dyadic::operator-() const {
  Dyadic result = *this;
  result.sign_ = -sign_;
  return result;
}

Dyadic& Dyadic::operator+=(const Dyadic& x) {
  if (x.sign_ == 0) return *this;
  if (sign_ == 0) return *this = x;
  const bool swap = sign_ != x.sign_ && compare_magnitudes(*this, x) < 0;
  const Dyadic& larger = swap ? x : *this;
  const Dyadic& other = swap ? *this : x;
  const std::int64_t low = std::min(low_, x.low_);
  const std::int64_t high = std::max(this->high(), x.high()) + 1;
  std::vector<Limb> sum(static_cast<std::size_t>(high - low), 0);
  std::copy(larger.limbs_.begin(), larger.limbs_.end(), sum.begin() + static_cast<std::ptrdiff_t>(larger.low_ - low));
  const auto from = static_cast<std::size_t>(other.low_ - low);
  if (sign_ == x.sign_) {
    add(sum, other.limbs_, from);
  } else {
    subtract(sum, other.limbs_, from);
  }
  return *this = Dyadic(larger.sign_, std::move(sum), low);
}

Dyadic operator*(const Dyadic& a, const Dyadic& b) {
  if (a.sign_ == 0 || b.sign_ == 0) return {};
  std::vector<Limb> product(a.limbs_.size() + b.limbs_.size(), 0);
  for (std::size_t i = 0; i < a.limbs_.size(); ++i) {
    Limb carry = 0;
    for (std::size_t j = 0; j < b.limbs_.size(); ++j) {
      const Wide sum = Wide{a.limbs_[i]} * b.limbs_[j] + product[i + j] + carry;
      product[i + j] = static_cast<Limb>(sum);
      carry = static_cast<Limb>(sum >> kLimbBits);
    }
    product[i + b.limbs_.size()] = carry;
  }
  return Dyadic(a.sign_ * b.sign_, std::move(product), a.low_ + b.low_);
}

int compare_magnitudes(const Dyadic& a, const Dyadic& b) {
  if (a.is_zero() || b.is_zero()) return (a.is_zero() ? 0 : 1) - (b.is_zero() ? 0 : 1);
  if (a.high() != b.high()) return a.high() < b.high() ? -1 : 1;
  for (std::int64_t at = a.high() - 1; at >= std::min(a.low(), b.low()); --at) {
    const auto limb = [at](const Dyadic& x) {
      return at < x.low() ? Limb{0} : x.limbs()[static_cast<std::size_t>(at - x.low())];
    };
    if (limb(a) != limb(b)) return limb(a) < limb(b) ? -1 : 1;
  }
  return 0;
}

Quad quotient(const Dyadic& a, const Dyadic& b) {
  if (a.is_zero()) return 0;
  std::int64_t exponent_a = 0;
  std::int64_t exponent_b = 0;
  const Quad magnitude = leading(a, exponent_a) / leading(b, exponent_b);
  // Beyond a shift of kMost limbs the result is infinite or zero in any case.
  constexpr std::int64_t kMost = 520;
  Quad result = a.sign() == b.sign() ? magnitude : -magnitude;
  const std::int64_t shift = std::clamp(exponent_a - exponent_b, -kMost, kMost);
  for (std::int64_t k = 0; k < std::abs(shift); ++k) result *= shift > 0 ? 0x1p64 : 0x1p-64;
  return result;
}

}  // namespace lcpbench
