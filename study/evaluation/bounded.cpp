#include "study/evaluation/bounded.h"

#include <cmath>
#include <vector>

#include "study/evaluation/at_isa_level.h"

namespace lcpbench {
namespace {

Bounded bounded_dot(const double* values, const std::size_t* rows, std::size_t count, const Bounded* x) {
  BoundedSum sum;
  for (std::size_t e = 0; e < count; ++e) sum.add(values[e], x[rows[e]]);
  return sum.value();
}

LCPBENCH_AVX2 Bounded bounded_dot_fused(const double* values, const std::size_t* rows, std::size_t count,
                                        const Bounded* x) {
  BoundedSum sum;
  for (std::size_t e = 0; e < count; ++e) {
    const double a = values[e], b = x[rows[e]].high;
    const double product = a * b;
    sum.add(a, x[rows[e]], {product, __builtin_fma(a, b, -product)});
  }
  return sum.value();
}

}  // namespace

/// By an expansion: doubles of which each is smaller than the last bit of the next one. [Shewchuk 1997, "Adaptive
/// precision floating-point arithmetic", Discrete & Computational Geometry 18, Theorem 10]
std::optional<Bounded> exact_dot(const double* values, const std::size_t* rows, std::size_t count, const Bounded* x) {
  std::vector<double> expansion;
  const auto grow = [&expansion](double term) {
    std::size_t kept = 0;
    for (const double component : expansion) {
      const bounded::Pair sum = bounded::exact_sum(term, component);
      term = sum.high;
      if (sum.low != 0) expansion[kept++] = sum.low;
    }
    expansion.resize(kept);
    if (term != 0) expansion.push_back(term);
  };
  for (std::size_t e = 0; e < count; ++e) {
    const Bounded& factor = x[rows[e]];
    if (!is_finite(factor) || !factor.exact()) return std::nullopt;
    for (const double part : {factor.high, factor.low}) {
      const bounded::Pair product = bounded::exact_product(values[e], part);
      if (!std::isfinite(product.low) || bounded::lost(product.high, values[e], part) != 0) return std::nullopt;
      grow(product.low);
      grow(product.high);
    }
  }
  bounded::Pair sum{0, 0};
  double rest = 0;
  for (std::size_t k = expansion.size(); k-- > 0;) {  // the largest first
    const bounded::Pair low = bounded::exact_sum(sum.low, expansion[k]);
    sum = bounded::exact_sum(sum.high, low.high);
    rest += std::abs(low.low);
  }
  return bounded::normalised(sum.high, sum.low, rest);
}

BoundedDot bounded_dot_of_level() { return at_isa_level(bounded_dot, bounded_dot_fused); }

}  // namespace lcpbench
