#include "study/evaluation/bounded_refinement.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "study/evaluation/at_isa_level.h"
#include "study/evaluation/bounded.h"

namespace lcpbench {
namespace {

/// The operands of subtract_column(), n entries each.
struct Column {
  const double* entries;
  double y_high, y_low;
  double *sum, *rest, *roundings;
  std::size_t n;
};

/// The same steps as BoundedSum's, for all rows at once. kFused: with fused multiply-adds, which give what rounding
/// leaves of a product at once. The numbers are the same but at the ends of the range, where splitting a factor may
/// overflow or lose bits.
template <bool kFused>
[[gnu::always_inline]] inline void subtract_column_by(const Column& of) {
  double* __restrict const sum = of.sum;
  double* __restrict const rest = of.rest;
  double* __restrict const roundings = of.roundings;
  const double* __restrict const entries = of.entries;
  const double y_high = of.y_high, y_low = of.y_low;
  for (std::size_t i = 0; i < of.n; ++i) {
    const double g = entries[i];
    const double product = g * y_high;
    const double of_product = kFused ? __builtin_fma(g, y_high, -product) : bounded::exact_product(g, y_high).low;
    const bounded::Pair total = bounded::exact_sum(sum[i], -product);
    const double of_low = g * y_low;
    const double subtracted = of_product + of_low;
    const double added = total.low - subtracted;
    const double low = rest[i] + added;
    sum[i] = total.high;
    rest[i] = low;
    roundings[i] += (std::abs(of_low) + std::abs(subtracted)) + (std::abs(added) + std::abs(low));
  }
}

void subtract_column(const Column& of) { subtract_column_by<false>(of); }

LCPBENCH_AVX2 void subtract_column_fused(const Column& of) { subtract_column_by<true>(of); }

}  // namespace

BoundedRefinement::BoundedRefinement(std::size_t n, std::vector<double>& memory) {
  const std::initializer_list<std::span<double>*> parts = {&b_high, &b_low, &b_error,   &high,       &low,
                                                           &sum,    &rest,  &roundings, &correction, &bound};
  if (memory.size() < parts.size() * n) memory.resize(parts.size() * n);
  std::span<double> free = memory;
  for (std::span<double>* const part : parts) {
    *part = free.first(n);
    free = free.subspan(n);
  }
}

/// The residual in double, and a bound of its error. The leading parts are added without any. Of each column four
/// numbers are rounded, by at most 2^-53 of what they become, which `roundings` sums up: two of the low parts, their
/// difference from that of the sum, and the sum of these. The residual itself is the last.
void BoundedRefinement::find_residual(const double* A) {
  const std::size_t n = sum.size();
  for (std::size_t i = 0; i < n; ++i) {
    sum[i] = b_high[i];
    rest[i] = b_low[i];
    roundings[i] = 0;
  }
  static const auto subtract = at_isa_level(subtract_column, subtract_column_fused);
  for (std::size_t j = 0; j < n; ++j) {
    if (high[j] != 0) {
      subtract({A + j * n, high[j], low[j], sum.data(), rest.data(), roundings.data(), n});
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    correction[i] = sum[i] + rest[i];
    const double rounding = bounded::kRoundoff * (roundings[i] + std::abs(correction[i]));
    bound[i] = 2 * b_error[i] + rounding * (1 + 0x1p-20) + bounded::kLost;
  }
}

/// Beyond doubt, if no bits were lost below the range of a double.
bool BoundedRefinement::is_zero() const {
  for (std::size_t i = 0; i < sum.size(); ++i) {
    if (correction[i] != 0 || roundings[i] != 0) return false;
  }
  return true;
}

bool BoundedRefinement::may_have_lost_bits(std::span<const double> A) const {
  constexpr double kSmall = 0x1p-400;
  const auto is_small = [](double value) { return value != 0 && !(std::abs(value) > kSmall); };
  return std::any_of(high.begin(), high.end(), is_small) || std::any_of(A.begin(), A.end(), is_small);
}

void BoundedRefinement::correct() {
  for (std::size_t i = 0; i < high.size(); ++i) {
    const bounded::Pair total = bounded::exact_sum(high[i], correction[i]);
    const bounded::Pair normal = bounded::exact_sum(total.high, low[i] + total.low);
    high[i] = normal.high;
    low[i] = normal.low;
  }
}

}  // namespace lcpbench
