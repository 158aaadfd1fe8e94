#pragma once

#include "native/kernels/pack.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// A column of a sum: where it stands in memory and its factor in each of the two sums.
struct Term {
  const double* column;
  double factor[2];
};

/// sums[s][0..size) += sum over the terms of factor[s] * column, s < kSums, reading each column once. `size` is a
/// multiple of the pack's width. Every entry is summed in the order of the terms, so that equal rows have equal sums.
template <std::size_t kSums>
void add_terms(const Term* terms, Count count, Count size, double* const (&sums)[kSums]) {
  using P = Packed<double>;
  constexpr std::size_t kRun = 4;
  constexpr Count kRunSize = static_cast<Count>(kRun) * P::kWidth;
  const auto offset = [](std::size_t r) { return static_cast<Count>(r) * P::kWidth; };
  Count i = 0;
  for (; i + kRunSize <= size; i += kRunSize) {
    P::Pack sum[kSums][kRun];
    for (std::size_t s = 0; s < kSums; ++s) {
      for (std::size_t r = 0; r < kRun; ++r) sum[s][r] = P::load(sums[s] + i + offset(r));
    }
    for (const Term* term = terms; term != terms + count; ++term) {
      for (std::size_t r = 0; r < kRun; ++r) {
        const P::Pack column = P::load(term->column + i + offset(r));
        for (std::size_t s = 0; s < kSums; ++s) sum[s][r] += term->factor[s] * column;
      }
    }
    for (std::size_t s = 0; s < kSums; ++s) {
      for (std::size_t r = 0; r < kRun; ++r) P::store(sums[s] + i + offset(r), sum[s][r]);
    }
  }
  for (; i < size; i += P::kWidth) {
    P::Pack sum[kSums];
    for (std::size_t s = 0; s < kSums; ++s) sum[s] = P::load(sums[s] + i);
    for (const Term* term = terms; term != terms + count; ++term) {
      const P::Pack column = P::load(term->column + i);
      for (std::size_t s = 0; s < kSums; ++s) sum[s] += term->factor[s] * column;
    }
    for (std::size_t s = 0; s < kSums; ++s) P::store(sums[s] + i, sum[s]);
  }
}

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
