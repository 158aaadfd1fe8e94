#pragma once

#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include "native/active_set/arithmetic.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

/// Sums of n products of doubles, one in each lane, off by a rounding of the result and (n u)^2 times the sum of the
/// magnitudes of the products, u the rounding of a double [Ogita, Rump, Oishi 2005, Dot2]. A product below 2^-969 may
/// also lose 2^-1074.
class TwofoldSum {
  using L = Lanes<double>;
  using Pack = L::Pack;

 public:
  [[gnu::always_inline]] inline void add(Pack a, Pack b) {
    Pack product = a * b;
    forget(product);
    const Pack next = sum_ + product;
    const Pack part = next - sum_;
    rest_ += ((sum_ - (next - part)) + (product - part)) + error_of(a, b, product);
    sum_ = next;
  }
  Pack value() const { return sum_ + rest_; }

 private:
  /// Where a number comes from is no longer known: a product is not contracted with what it is added to.
  [[gnu::always_inline]] static inline void forget(Pack& pack) {
#if defined(__x86_64__)
    __asm__("" : "+x"(pack));
#else
    __asm__("" : "+m"(pack));
#endif
  }

  /// a b - product, exactly.
  [[gnu::always_inline]] static inline Pack error_of(Pack a, Pack b, Pack product) {
#if defined(__AVX2__)
    return _mm256_fmsub_pd(a, b, product);
#elif defined(__FP_FAST_FMA)
    Pack error = Pack{};
    for (Count lane = 0; lane < L::kWidth; ++lane) error[lane] = __builtin_fma(a[lane], b[lane], -product[lane]);
    return error;
#else  // by halves of 26 bits [Dekker 1971]
    const Pack high_a = high_half(a), high_b = high_half(b);
    const Pack low_a = a - high_a, low_b = b - high_b;
    return ((high_a * high_b - product) + high_a * low_b + low_a * high_b) + low_a * low_b;
#endif
  }

#if !defined(__AVX2__) && !defined(__FP_FAST_FMA)
  static Pack high_half(Pack x) {
    const Pack large = x * 134217729.0;  // 2^27 + 1
    return large - (large - x);
  }
#endif

  Pack sum_ = Pack{}, rest_ = Pack{};
};

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
