#pragma once

#include <vector>

#include "core/lcp.h"
#include "native/answer_test/exact_integer.h"

namespace lcpbench::enumeration {

/// The rows [M -q] of an LCP, each multiplied by the power of two that makes it integers without common factor 2.
/// Scaling a row scales its w alone, so solutions stay what they are.
class Rows {
 public:
  /// Limbs of an entry at most: the exponents of doubles span 2098 bits.
  static constexpr std::size_t kMostLimbs = 34;

  /// Room for any problem of that order. Allocates.
  void reserve(Index n);

  /// O(n^2), at most kMostLimbs limbs for each entry. Allocates where there is no room.
  void load(const Lcp& lcp);

  Index size() const { return static_cast<Index>(bits_.size()); }

  /// @param column of M, or size() for -q
  ConstInteger entry(Index row, Index column) const {
    return {&limbs_[static_cast<std::size_t>(row * (size() + 1) + column) * stride_], limbs_for(bits(row))};
  }

  /// A determinant of rows of at most twelve columns is below 2^(sum of their bits) in magnitude. [Hadamard]
  std::size_t bits(Index row) const { return bits_[static_cast<std::size_t>(row)]; }
  std::size_t bits_of_all() const;

 private:
  std::vector<std::size_t> bits_;
  std::vector<Limb> limbs_;
  std::size_t stride_ = 0;
};

}  // namespace lcpbench::enumeration
