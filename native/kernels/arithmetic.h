#pragma once

#include "native/kernels/scalars.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// Sums of products above this have lost nothing that counts to underflow.
template <class Scalar>
constexpr double kSmallestSafe =
#if defined(LCPBENCH_QUAD)
    0;
#else
    1e-280;
#endif

template <class Scalar, class... More>
void fill_with_zeros(Count size, Buffer<Scalar>& first, More&... more) {
  first.fill(size, Scalar(0));
  (more.fill(size, Scalar(0)), ...);
}

// Vector arithmetic on arrays that are padded to whole packs; lengths are rounded up to packs by the callee.

/// Packs of the output that stay in registers at a time.
constexpr Count kTilePacks = 4;
template <class Scalar>
constexpr Count kTileLength = kTilePacks* Packed<Scalar>::kWidth;
/// A tile of at most so many packs, counted over all its sides (see TileSums), takes two rows at a time.
constexpr Count kMostInPairs = 4;

/// kPacks packs of several combinations of the same rows, which are read once for all of them. A side is one
/// combination, sum over k < count of coefficients[side][k] row_k. Row k begins at row + k * stride.
template <Count kPacks, class Scalar, Count kSides>
struct TileSums {
  using P = Packed<Scalar>;
  using Pack = typename P::Pack;
  using Sums = Pack[static_cast<std::size_t>(kSides)][static_cast<std::size_t>(kPacks)];

  [[gnu::always_inline]] inline TileSums(const Scalar* row, Count stride, Count count,
                                         const Scalar* const (&coefficients)[static_cast<std::size_t>(kSides)]) {
    clear(of);
    Count k = 0;
    if constexpr (P::kWidth > 1 && kSides * kPacks <= kMostInPairs) {  // halves the additions that wait for one another
      Sums others;
      clear(others);
      for (const Count pairs = count & ~Count(1); k != pairs; k += 2, row += 2 * stride) {
        add(row, coefficients, k, of);
        add(row + stride, coefficients, k + 1, others);
      }
      for (Count s = 0; s < kSides; ++s) {
        for (Count p = 0; p < kPacks; ++p) of[s][p] += others[s][p];
      }
      if (k != count) add(row, coefficients, k, of);
    } else {
      for (; k != count; ++k, row += stride) add(row, coefficients, k, of);
    }
  }

  [[gnu::always_inline]] inline void operator+=(const TileSums& other) {
    for (Count s = 0; s < kSides; ++s) {
      for (Count p = 0; p < kPacks; ++p) of[s][p] += other.of[s][p];
    }
  }

  Sums of;

 private:
  [[gnu::always_inline]] static inline void clear(Sums& sums) {
    for (Count s = 0; s < kSides; ++s) {
      for (Count p = 0; p < kPacks; ++p) sums[s][p] = Pack{};
    }
  }

  [[gnu::always_inline]] static inline void add(const Scalar* row,
                                                const Scalar* const (&coefficients)[static_cast<std::size_t>(kSides)],
                                                Count k, Sums& sums) {
    for (Count p = 0; p < kPacks; ++p) {
      const Pack entries = P::load(row + p * P::kWidth);
      for (Count s = 0; s < kSides; ++s) sums[s][p] += entries * coefficients[s][k];
    }
  }
};

// Each number of packs has a function of its own, which is not inlined. One function for all would save the registers
// of the largest tile at its start, which takes too long where few rows are combined.

/// @param start  added to the sums where kOnto, else not read
template <Count kPacks, bool kOnto, class Scalar>
[[gnu::noinline]] void combine_tile(const Scalar* rows, Count stride, Count count, const Scalar* coefficients,
                                    const Scalar* start, Scalar* out) {
  using P = Packed<Scalar>;
  TileSums<kPacks, Scalar, 1> sums(rows, stride, count, {coefficients});
  for (Count p = 0; p < kPacks; ++p) {
    if constexpr (kOnto) sums.of[0][p] += P::load(start + p * P::kWidth);
    P::store(out + p * P::kWidth, sums.of[0][p]);
  }
}

template <Count kPacks>
struct PackCount {
  static constexpr Count kValue = kPacks;
};

/// Calls tile(PackCount) with the packs that `length` entries need; not at all for none. @pre they fit one tile
template <class Scalar, class Tile>
[[gnu::always_inline]] inline void choose_tile(Count length, const Tile& tile) {
  constexpr Count kWidth = Packed<Scalar>::kWidth;
  if (length > 3 * kWidth) return tile(PackCount<4>{});
  if (length > 2 * kWidth) return tile(PackCount<3>{});
  if (length > kWidth) return tile(PackCount<2>{});
  if (length > 0) tile(PackCount<1>{});
}

/// Calls tile(PackCount, first entry) for one tile after the other, until they cover `length` entries. All but the last
/// have kTilePacks packs; the last pack may reach beyond `length`.
template <class Scalar, class Tile>
[[gnu::always_inline]] inline void for_each_tile(Count length, const Tile& tile) {
  Count at = 0;
  for (; length - at > kTileLength<Scalar>; at += kTileLength<Scalar>) tile(PackCount<kTilePacks>{}, at);
  choose_tile<Scalar>(length - at, [&](auto packs) { tile(packs, at); });
}

template <bool kOnto, class Scalar>
[[gnu::noinline]] void combine_long(const Scalar* rows, Count stride, Count count, const Scalar* coefficients,
                                    const Scalar* start, Scalar* out, Count length) {
  for_each_tile<Scalar>(length, [&](auto packs, Count at) {
    combine_tile<packs.kValue, kOnto>(rows + at, stride, count, coefficients, start + at, out + at);
  });
}

template <bool kOnto, class Scalar>
inline void combine_tiles(const Scalar* rows, Count stride, Count count, const Scalar* coefficients,
                          const Scalar* start, Scalar* out, Count length) {
  if (length > kTileLength<Scalar>) {
    return combine_long<kOnto>(rows, stride, count, coefficients, start, out, length);
  }
  choose_tile<Scalar>(
      length, [&](auto packs) { combine_tile<packs.kValue, kOnto>(rows, stride, count, coefficients, start, out); });
}

/// out[i] = sum over k < count of coefficients[k] rows[k * stride + i], for i < length.
template <class Scalar>
inline void combine(const Scalar* rows, Count stride, Count count, const Scalar* coefficients, Scalar* out,
                    Count length) {
  combine_tiles<false, Scalar>(rows, stride, count, coefficients, out, out, length);
}

/// The same, added to start[i].
template <class Scalar>
inline void combine_onto(const Scalar* rows, Count stride, Count count, const Scalar* coefficients, const Scalar* start,
                         Scalar* out, Count length) {
  combine_tiles<true>(rows, stride, count, coefficients, start, out, length);
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

/// Sum over whole packs: what fills the last one must be zero in x or y, and finite in the other.
template <class Scalar>
inline Scalar dot(const Scalar* x, const Scalar* y, Count length) {
  using P = Packed<Scalar>;
  typename P::Pack sum = typename P::Pack{};
  for (Count i = 0; i < length; i += P::kWidth) sum += P::load(x + i) * P::load(y + i);
  return P::sum(sum);
}

/// P::sum() of as many packs as a pack has lanes.
template <class Scalar>
inline typename Packed<Scalar>::Pack sums_of(
    const typename Packed<Scalar>::Pack (&packs)[static_cast<std::size_t>(Packed<Scalar>::kWidth)]) {
  using P = Packed<Scalar>;
  using Pack = typename P::Pack;
  if constexpr (P::kWidth == 1) {
    return packs[0];
  } else if constexpr (P::kWidth == 4) {  // the additions of four sums() side by side
    const auto halves = [](Pack a, Pack b) -> Pack {
      return __builtin_shufflevector(a, b, 0, 1, 4, 5) + __builtin_shufflevector(a, b, 2, 3, 6, 7);
    };
    const Pack first = halves(packs[0], packs[1]), second = halves(packs[2], packs[3]);
    const Pack sums =
        __builtin_shufflevector(first, second, 0, 4, 2, 6) + __builtin_shufflevector(first, second, 1, 5, 3, 7);
    return __builtin_shufflevector(sums, sums, 0, 2, 1, 3);
  } else {
    Pack sums = Pack{};
    for (Count k = 0; k < P::kWidth; ++k) sums[k] = P::sum(packs[k]);
    return sums;
  }
}

/// The dot products of x with kWidth vectors, each bit for bit as dot() has it.
template <class Scalar>
inline typename Packed<Scalar>::Pack dots(const Scalar* x,
                                          const Scalar* const (&y)[static_cast<std::size_t>(Packed<Scalar>::kWidth)],
                                          Count length) {
  using P = Packed<Scalar>;
  typename P::Pack sums[static_cast<std::size_t>(P::kWidth)];
  for (Count k = 0; k < P::kWidth; ++k) sums[k] = typename P::Pack{};
  for (Count i = 0; i < length; i += P::kWidth) {
    const typename P::Pack factors = P::load(x + i);
    for (Count k = 0; k < P::kWidth; ++k) sums[k] += factors * P::load(y[k] + i);
  }
  return sums_of<Scalar>(sums);
}

/// 0, 1, 2, ...
template <class Scalar>
[[gnu::always_inline]] inline typename Packed<Scalar>::Pack lane_numbers() {
  using P = Packed<Scalar>;
  Scalar lanes[static_cast<std::size_t>(P::kWidth)];
  for (Count lane = 0; lane < P::kWidth; ++lane) lanes[lane] = static_cast<Scalar>(static_cast<double>(lane));
  return P::load(lanes);
}

/// The pack that begins with entry `first` of an array of `count` entries, with zeros for what lies beyond the array.
/// @pre first < count
template <class Scalar>
inline typename Packed<Scalar>::Pack entries_of(typename Packed<Scalar>::Pack pack, Count first, Count count) {
  using P = Packed<Scalar>;
  if constexpr (P::kWidth == 1) {
    return pack;
  } else {
    return lane_numbers<Scalar>() < static_cast<Scalar>(count - first) ? pack : typename P::Pack{};
  }
}

/// The pack that begins with entry `first`, with `value` in the place of `entry`; as it is, if `entry` is in another
/// pack. Done in a register: a load of the whole pack would wait for a store to a part of it.
template <class Scalar>
inline typename Packed<Scalar>::Pack with_entry(typename Packed<Scalar>::Pack pack, Count first, Count entry,
                                                Scalar value) {
  using P = Packed<Scalar>;
  if constexpr (P::kWidth == 1) {
    return first == entry ? value : pack;
  } else {
    return lane_numbers<Scalar>() == static_cast<Scalar>(entry - first) ? P::broadcast(value) : pack;
  }
}
template <class Scalar>
inline typename Packed<Scalar>::Pack without_entry(typename Packed<Scalar>::Pack pack, Count first, Count entry) {
  return with_entry<Scalar>(pack, first, entry, Scalar(0));
}

/// The larger of |pack| and `largest`, lane by lane; NaN is passed over.
template <class Scalar>
inline typename Packed<Scalar>::Pack larger_magnitude(typename Packed<Scalar>::Pack pack,
                                                      typename Packed<Scalar>::Pack largest) {
  using P = Packed<Scalar>;
  return P::max(P::max(pack, -pack), largest);
}

/// The first of x[from] to x[size - 1] that is not zero, or `size`.
template <class Scalar>
[[gnu::always_inline]] inline Count next_nonzero(const double* x, Count from, Count size) {
  using D = Packed<double>;
  if constexpr (Packed<Scalar>::kWidth > 1) {
    while (from + D::kWidth <= size && lanes_where<double>(D::load(x + from) != typename D::Pack{}) == 0) {
      from += D::kWidth;
    }
  }
  while (from < size && x[from] == 0) ++from;
  return from;
}

/// x, but infinity for NaN: `if (!(x <= most)) most = number_or_infinity(x)` makes a maximum infinite for good at NaN.
template <class Scalar>
Scalar number_or_infinity(Scalar x) {
  return x < kInfinity<Scalar> ? x : kInfinity<Scalar>;
}

/// max |x_i| for i < length: what fills the last pack is not read. NaN is passed over.
template <class Scalar>
inline Scalar largest_magnitude(const Scalar* x, Count length) {
  Scalar largest = 0;
  for (Count i = 0; i < length; ++i) largest = magnitude(x[i]) > largest ? magnitude(x[i]) : largest;
  return largest;
}

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
