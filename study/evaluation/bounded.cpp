#include "study/evaluation/bounded.h"

#include "core/isa.h"

namespace lcpbench {
namespace {

Bounded bounded_dot(const double* values, const std::size_t* rows, std::size_t count, const Bounded* x) {
  BoundedSum sum;
  for (std::size_t e = 0; e < count; ++e) sum.add(values[e], x[rows[e]]);
  return sum.value();
}

Bounded bounded_dot_of_doubles(const double* values, const std::size_t* rows, std::size_t count, const double* x) {
  BoundedSum sum;
  for (std::size_t e = 0; e < count; ++e) {
    const double a = values[e], b = x[rows[e]];
    sum.add_exact(bounded::exact_product(a, b), a, b);
  }
  return sum.value();
}

#if defined(__x86_64__)
__attribute__((target("avx2,fma"))) Bounded bounded_dot_fused(const double* values, const std::size_t* rows,
                                                              std::size_t count, const Bounded* x) {
  BoundedSum sum;
  for (std::size_t e = 0; e < count; ++e) {
    const double a = values[e], b = x[rows[e]].high;
    const double product = a * b;
    sum.add(a, x[rows[e]], {product, __builtin_fma(a, b, -product)});
  }
  return sum.value();
}

__attribute__((target("avx2,fma"))) Bounded bounded_dot_of_doubles_fused(const double* values, const std::size_t* rows,
                                                                         std::size_t count, const double* x) {
  BoundedSum sum;
  for (std::size_t e = 0; e < count; ++e) {
    const double a = values[e], b = x[rows[e]];
    const double product = a * b;
    sum.add_exact({product, __builtin_fma(a, b, -product)}, a, b);
  }
  return sum.value();
}
#endif

}  // namespace

BoundedDot bounded_dot_of_level() {
#if defined(__x86_64__)
  if (isa_level() >= IsaLevel::kAvx2) return bounded_dot_fused;
#endif
  return bounded_dot;
}

BoundedDotOfDoubles bounded_dot_of_doubles_of_level() {
#if defined(__x86_64__)
  if (isa_level() >= IsaLevel::kAvx2) return bounded_dot_of_doubles_fused;
#endif
  return bounded_dot_of_doubles;
}

}  // namespace lcpbench
