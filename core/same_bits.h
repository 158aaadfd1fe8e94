#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "core/types.h"

namespace lcpbench {

/// True when both have the same entries, bit for bit: NaN equals itself, 0 and -0 differ.
inline bool same_bits(const Vector& a, const Vector& b) {
  return a.size() == b.size() && std::equal(a.data(), a.data() + a.size(), b.data(), [](double x, double y) {
           return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
         });
}

}  // namespace lcpbench
