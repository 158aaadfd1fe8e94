#pragma once

#include "native/lemke/scalars.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// Sums of products above this have lost nothing that counts to underflow.
template <class Scalar>
constexpr double kSmallestSafe =
#if defined(LCPBENCH_QUAD)
    0;
#elif defined(LCPBENCH_DOUBLE_DOUBLE)
    1e-250;
#else
    sizeof(Scalar) == sizeof(float) ? 1e-25 : 1e-280;
#endif

template <class Scalar, class... More>
void fill_with_zeros(Count size, Buffer<Scalar>& first, More&... more) {
  first.fill(size, Scalar(0));
  (more.fill(size, Scalar(0)), ...);
}

// Vector arithmetic on arrays that are padded to whole packs; lengths are rounded up to packs by the callee.

/// Packs of the output that stay in registers at a time.
constexpr Count kTilePacks = 4;
/// Of those, for all sides together, up to which two rows are taken at a time.
constexpr Count kMostInPairs = 4;

/// `kSides` combinations of the same rows.
template <class Scalar, Count kSides>
struct Combination {
  const Scalar* coefficients[static_cast<std::size_t>(kSides)];
  Scalar* out[static_cast<std::size_t>(kSides)];
};

/// A function of its own: products of a few rows would otherwise begin with saving what tiles of all sizes need.
template <Count kPacks, class Scalar, Count kSides>
[[gnu::noinline]] void combine_tile(const Scalar* rows, Count stride, Count count, Combination<Scalar, kSides> sides,
                                    Count at) {
  using P = Packed<Scalar>;
  using Sums = typename P::Pack[static_cast<std::size_t>(kSides)][static_cast<std::size_t>(kPacks)];
  Sums sums;
  for (Count s = 0; s < kSides; ++s) {
    for (Count p = 0; p < kPacks; ++p) sums[s][p] = typename P::Pack{};
  }
  const Scalar* row = rows + at;
  Count k = 0;
  if constexpr (P::kWidth > 1 && kSides * kPacks <= kMostInPairs) {  // halves the additions that wait for one another
    Sums others;
    for (Count s = 0; s < kSides; ++s) {
      for (Count p = 0; p < kPacks; ++p) others[s][p] = typename P::Pack{};
    }
    for (; k + 1 < count; k += 2, row += 2 * stride) {
      for (Count p = 0; p < kPacks; ++p) {
        const typename P::Pack first = P::load(row + p * P::kWidth);
        const typename P::Pack second = P::load(row + stride + p * P::kWidth);
        for (Count s = 0; s < kSides; ++s) {
          sums[s][p] += first * sides.coefficients[s][k];
          others[s][p] += second * sides.coefficients[s][k + 1];
        }
      }
    }
    for (Count s = 0; s < kSides; ++s) {
      for (Count p = 0; p < kPacks; ++p) sums[s][p] += others[s][p];
    }
  }
  for (; k < count; ++k, row += stride) {
    for (Count p = 0; p < kPacks; ++p) {
      const typename P::Pack entries = P::load(row + p * P::kWidth);
      for (Count s = 0; s < kSides; ++s) sums[s][p] += entries * sides.coefficients[s][k];
    }
  }
  for (Count s = 0; s < kSides; ++s) {
    for (Count p = 0; p < kPacks; ++p) P::store(sides.out[s] + at + p * P::kWidth, sums[s][p]);
  }
}

/// out_s[i] = sum over k < count of coefficients_s[k] rows[k * stride + i], for i < length.
template <class Scalar, Count kSides>
inline void combine(const Scalar* rows, Count stride, Count count, const Combination<Scalar, kSides>& sides,
                    Count length) {
  using P = Packed<Scalar>;
  Count packs = P::padded(length) / P::kWidth;
  Count at = 0;
  for (; packs > kTilePacks; packs -= kTilePacks, at += kTilePacks * P::kWidth) {
    combine_tile<kTilePacks>(rows, stride, count, sides, at);
  }
  switch (packs) {
    case 4: return combine_tile<4>(rows, stride, count, sides, at);
    case 3: return combine_tile<3>(rows, stride, count, sides, at);
    case 2: return combine_tile<2>(rows, stride, count, sides, at);
    case 1: return combine_tile<1>(rows, stride, count, sides, at);
    default: return;
  }
}

template <class Scalar>
inline void combine(const Scalar* rows, Count stride, Count count, const Scalar* coefficients, Scalar* out,
                    Count length) {
  combine(rows, stride, count, Combination<Scalar, 1>{{coefficients}, {out}}, length);
}

/// y += a x
template <class Scalar>
inline void add_multiple(Scalar* y, Scalar a, const Scalar* x, Count length) {
  using P = Packed<Scalar>;
  for (Count i = 0; i < length; i += P::kWidth) P::store(y + i, P::load(y + i) + a * P::load(x + i));
}

/// y = y * a
template <class Scalar>
inline void scale(Scalar* y, Scalar a, Count length) {
  using P = Packed<Scalar>;
  for (Count i = 0; i < length; i += P::kWidth) P::store(y + i, P::load(y + i) * a);
}

/// Sum over whole packs: what fills the last one must be zero in x or in y.
template <class Scalar>
inline Scalar dot(const Scalar* x, const Scalar* y, Count length) {
  using P = Packed<Scalar>;
  typename P::Pack sum = typename P::Pack{};
  for (Count i = 0; i < length; i += P::kWidth) sum += P::load(x + i) * P::load(y + i);
  return P::sum(sum);
}

/// Of the pack that begins with entry `first`, those of `count` entries; zeros for what comes after them.
template <class Scalar>
inline typename Packed<Scalar>::Pack entries_of(typename Packed<Scalar>::Pack pack, Count first, Count count) {
  using P = Packed<Scalar>;
  if constexpr (P::kWidth == 1) {
    return pack;
  } else {
    Scalar lanes[static_cast<std::size_t>(P::kWidth)];
    for (Count lane = 0; lane < P::kWidth; ++lane) lanes[lane] = static_cast<Scalar>(lane);
    return P::load(lanes) < static_cast<Scalar>(count - first) ? pack : typename P::Pack{};
  }
}

/// The larger of |pack| and `largest`, lane by lane; NaN is passed over.
template <class Scalar>
inline typename Packed<Scalar>::Pack larger_magnitude(typename Packed<Scalar>::Pack pack,
                                                      typename Packed<Scalar>::Pack largest) {
  using P = Packed<Scalar>;
  return P::max(P::max(pack, -pack), largest);
}

/// Keeps what is no number from comparing as small: a maximum that has met one stays infinite.
template <class Scalar>
Scalar number_or_infinity(Scalar x) {
  return x < kInfinity<Scalar> ? x : kInfinity<Scalar>;
}

/// max |x_i| over whole packs; NaN is passed over.
template <class Scalar>
inline Scalar largest_magnitude(const Scalar* x, Count length) {
  Scalar largest = 0;
  for (Count i = 0; i < length; ++i) largest = magnitude(x[i]) > largest ? magnitude(x[i]) : largest;
  return largest;
}

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
