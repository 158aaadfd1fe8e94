#pragma once

#include <cstdint>
#include <random>

namespace lcpbench {

/// Whole numbers below a bound from a 64-bit Mersenne Twister, whose output the C++ standard fixes, by Lemire's
/// unbiased multiply-shift (2019): the same draws on every platform, which std::uniform_int_distribution does not
/// promise.
class BoundedDraw {
 public:
  explicit BoundedDraw(std::uint64_t seed) : engine_(seed) {}
  /// Uniform in 0 .. bound - 1. @pre bound > 0.
  std::uint64_t below(std::uint64_t bound) {
    __extension__ using Wide = unsigned __int128;
    Wide product = static_cast<Wide>(engine_()) * bound;
    const std::uint64_t threshold = (0 - bound) % bound;
    while (static_cast<std::uint64_t>(product) < threshold) product = static_cast<Wide>(engine_()) * bound;
    return static_cast<std::uint64_t>(product >> 64);
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace lcpbench
