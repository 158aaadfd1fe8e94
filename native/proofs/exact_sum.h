#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace lcpbench {

/// A sum of products of doubles without any rounding, of which the sign is asked.
///
/// A fixed-point number that holds every product of two finite doubles and 2^60 of them: nothing overflows, nothing
/// underflows, and nothing is allocated. [Kulisch, Computer Arithmetic and Validity, 2008, chapter 8]
class ExactSum {
 public:
  void clear() { limbs_.fill(0); }

  /// Adds a b. @pre both are finite
  void add(double a, double b);

  /// -1, 0 or 1.
  int sign() const;

 private:
  using Limb = std::uint64_t;

  // Products are multiples of 2^-2148 below 2^2048; two's complement, the least significant limb first.
  static constexpr int kLowestBit = -2148;
  static constexpr std::size_t kLimbs = (2048 - kLowestBit + 60) / 64 + 2;

  std::array<Limb, kLimbs> limbs_{};
};

}  // namespace lcpbench
