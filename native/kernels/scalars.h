#pragma once

#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include <cstdint>

#include "native/kernels/pack.h"

#if defined(LCPBENCH_QUAD)
#include "core/quad.h"
#endif

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// Packs of one number, for 113 bits: no processor has registers for more of them.
template <class Scalar>
struct Single {
  using Pack = Scalar;
  static constexpr Count kWidth = 1;

  static Pack load(const Scalar* from) { return *from; }
  static void store(Scalar* to, Pack pack) { *to = pack; }
  static Pack broadcast(Scalar value) { return value; }
  static Pack min(Pack a, Pack b) { return a < b ? a : b; }
  static Pack max(Pack a, Pack b) { return a > b ? a : b; }
  static Scalar min(Pack pack) { return pack; }
  static Scalar max(Pack pack) { return pack; }
  static Scalar sum(Pack pack) { return pack; }
  static Count padded(Count size) { return size; }
};

#if defined(LCPBENCH_QUAD)
template <>
struct Packed<Quad> : Single<Quad> {};
inline Quad square_root(Quad x) { return sqrt(x); }
template <class Scalar>
constexpr double kUnitRoundoff = kQuadUnitRoundoff;
#else
template <class Scalar>
constexpr double kUnitRoundoff = 0x1p-53;
inline double square_root(double x) { return __builtin_sqrt(x); }
#endif

template <class Scalar>
inline void copy(Scalar* to, const Scalar* from, Count length) {
  using P = Packed<Scalar>;
  for (Count i = 0; i < length; i += P::kWidth) P::store(to + i, P::load(from + i));
}

/// The lanes in which a comparison of packs holds, as bits.
template <class Scalar, class Mask>
[[gnu::always_inline]] inline std::uint64_t lanes_where(Mask mask) {
  if constexpr (Packed<Scalar>::kWidth == 1) {
    return mask ? 1 : 0;
#if defined(__AVX2__)
  } else if constexpr (sizeof(mask) == 32 && sizeof(Scalar) == sizeof(double)) {
    typedef double Bits __attribute__((vector_size(32)));
    return static_cast<std::uint64_t>(__builtin_ia32_movmskpd256(reinterpret_cast<Bits>(mask)));
#endif
  } else {
    std::uint64_t lanes = 0;
    for (Count lane = 0; lane < Packed<Scalar>::kWidth; ++lane) lanes |= (mask[lane] != 0 ? 1ULL : 0ULL) << lane;
    return lanes;
  }
}

/// The first `count` entries, at least 1, and zeros in what is left of the pack; nothing behind them is read.
template <class Scalar>
[[gnu::always_inline]] inline typename Packed<Scalar>::Pack load_first(const double* from, Count count) {
  using P = Packed<Scalar>;
#if defined(__AVX2__) && !defined(__AVX512F__)
  if constexpr (sizeof(Scalar) == sizeof(double)) {
    constexpr long long kMasks[] = {-1, -1, -1, -1, 0, 0, 0};
    return _mm256_maskload_pd(from, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(kMasks + P::kWidth - count)));
  }
#endif
  Scalar lanes[static_cast<std::size_t>(P::kWidth)];
  for (Count lane = 0; lane < P::kWidth; ++lane) {
    lanes[lane] = lane < count ? static_cast<Scalar>(from[lane]) : static_cast<Scalar>(0);
  }
  return P::load(lanes);
}

/// to := from, filled up with zeros to whole packs. The last pack of doubles may overlap the one before.
template <class Scalar>
inline void widen(const double* from, Count size, Scalar* to) {
  using P = Packed<Scalar>;
  Count i = 0;
  if constexpr (sizeof(Scalar) == sizeof(double)) {
    if (size >= P::kWidth) {
      P::store(to + P::padded(size) - P::kWidth, P::broadcast(0));
      for (; i + P::kWidth <= size; i += P::kWidth) P::store(to + i, P::load(from + i));
      P::store(to + size - P::kWidth, P::load(from + size - P::kWidth));
      return;
    }
  }
  for (; i < size; ++i) to[i] = static_cast<Scalar>(from[i]);
  for (; i < P::padded(size); ++i) to[i] = static_cast<Scalar>(0);
}

/// to := the transpose of the square matrix `from`, of the order of a pack; the rows of either are their stride apart.
template <class To, class From>
inline void transpose_block(const From* from, Count stride, To* to, Count to_stride) {
  for (Count i = 0; i < Packed<To>::kWidth; ++i) {
    for (Count j = 0; j < Packed<To>::kWidth; ++j) to[j * to_stride + i] = static_cast<To>(from[i * stride + j]);
  }
}
#if defined(__AVX2__) && !defined(__AVX512F__)
inline void transpose_block(const double* from, Count stride, double* to, Count to_stride) {
  using P = Packed<double>;
  using Pack = P::Pack;
  const Pack a = P::load(from), b = P::load(from + stride);
  const Pack c = P::load(from + 2 * stride), d = P::load(from + 3 * stride);
  const Pack ab_even = __builtin_shufflevector(a, b, 0, 4, 2, 6), ab_odd = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Pack cd_even = __builtin_shufflevector(c, d, 0, 4, 2, 6), cd_odd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  P::store(to, __builtin_shufflevector(ab_even, cd_even, 0, 1, 4, 5));
  P::store(to + to_stride, __builtin_shufflevector(ab_odd, cd_odd, 0, 1, 4, 5));
  P::store(to + 2 * to_stride, __builtin_shufflevector(ab_even, cd_even, 2, 3, 6, 7));
  P::store(to + 3 * to_stride, __builtin_shufflevector(ab_odd, cd_odd, 2, 3, 6, 7));
}
#endif

/// `count` vectors of `length` entries, `stride` apart, become `length` rows, each of whole packs and filled up with
/// zeros. The last block of rows or columns may overlap the one before.
template <class To, class From>
inline void transpose(const From* from, Count stride, Count length, Count count, To* to) {
  using P = Packed<To>;
  const Count padded = P::padded(count);
  if (length < P::kWidth || count < P::kWidth) {
    for (Count i = 0; i < length; ++i) {
      for (Count k = 0; k < padded; ++k) {
        to[i * padded + k] = k < count ? static_cast<To>(from[k * stride + i]) : static_cast<To>(0);
      }
    }
    return;
  }
  for (Count i = 0; i < length; ++i) P::store(to + (i + 1) * padded - P::kWidth, P::broadcast(0));
  for (Count column = 0; column < count; column += P::kWidth) {
    const Count k = column < count - P::kWidth ? column : count - P::kWidth;
    for (Count row = 0; row < length; row += P::kWidth) {
      const Count i = row < length - P::kWidth ? row : length - P::kWidth;
      transpose_block(from + k * stride + i, stride, to + i * padded + k, padded);
    }
  }
}

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
