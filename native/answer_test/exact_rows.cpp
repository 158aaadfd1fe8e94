#include "native/answer_test/exact_rows.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

namespace lcpbench::enumeration {
namespace {

/// A double as (-1)^negative * mantissa * 2^exponent, mantissa odd or, for zero, 0.
struct Dyadic {
  bool negative = false;
  Limb mantissa = 0;
  int exponent = std::numeric_limits<int>::max();
};

Dyadic dyadic(double x) {
  if (x == 0) return {};
  Dyadic result;
  result.negative = x < 0;
  constexpr int kDigits = std::numeric_limits<double>::digits;
  const double fraction = std::frexp(std::fabs(x), &result.exponent);
  const auto mantissa = static_cast<Limb>(std::ldexp(fraction, kDigits));
  const int zeros = std::countr_zero(mantissa);
  result.mantissa = mantissa >> zeros;
  result.exponent += zeros - kDigits;
  return result;
}

/// Bits of x / 2^exponent.
std::size_t bits_over(const Dyadic& x, int exponent) {
  if (x.mantissa == 0) return 0;
  return static_cast<std::size_t>(std::bit_width(x.mantissa)) + static_cast<std::size_t>(x.exponent - exponent);
}

/// to = x / 2^exponent.
void assign(Integer to, const Dyadic& x, int exponent) {
  std::fill(to.begin(), to.end(), 0);
  if (x.mantissa == 0) return;
  const auto shift = static_cast<std::size_t>(x.exponent - exponent);
  const std::size_t first = shift / kLimbBits;
  const std::size_t rest = shift % kLimbBits;
  to[first] = x.mantissa << rest;
  if (rest != 0 && first + 1 < to.size()) to[first + 1] = x.mantissa >> (kLimbBits - rest);
  if (x.negative) negate(to);
}

}  // namespace

void Rows::reserve(Index n) {
  bits_.reserve(static_cast<std::size_t>(n));
  limbs_.reserve(static_cast<std::size_t>(n * (n + 1)) * kMostLimbs);
}

void Rows::load(const Lcp& lcp) {
  // The Euclidean length of twelve entries is below 2^2 times the largest.
  constexpr std::size_t kLengthBits = 2;
  const Index n = lcp.size();
  const auto value = [&](Index i, Index j) { return dyadic(j < n ? lcp.M(i, j) : -lcp.q(i)); };
  const auto smallest_exponent = [&](Index i) {
    int smallest = std::numeric_limits<int>::max();
    for (Index j = 0; j <= n; ++j) smallest = std::min(smallest, value(i, j).exponent);
    return smallest;
  };
  bits_.assign(static_cast<std::size_t>(n), 0);
  for (Index i = 0; i < n; ++i) {
    std::size_t& bits = bits_[static_cast<std::size_t>(i)];
    const int exponent = smallest_exponent(i);
    for (Index j = 0; j <= n; ++j) bits = std::max(bits, bits_over(value(i, j), exponent) + kLengthBits);
  }
  stride_ = n == 0 ? 0 : limbs_for(*std::max_element(bits_.begin(), bits_.end()));
  limbs_.resize(static_cast<std::size_t>(n * (n + 1)) * stride_);
  for (Index i = 0; i < n; ++i) {
    const int exponent = smallest_exponent(i);
    for (Index j = 0; j <= n; ++j) {
      Limb* const limbs = &limbs_[static_cast<std::size_t>(i * (n + 1) + j) * stride_];
      assign({limbs, limbs_for(bits(i))}, value(i, j), exponent);
    }
  }
}

std::size_t Rows::bits_of_all() const { return std::accumulate(bits_.begin(), bits_.end(), std::size_t{0}); }

}  // namespace lcpbench::enumeration
