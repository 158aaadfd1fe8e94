#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/quad.h"

namespace lcpbench {

/// A sum of products of up to three doubles without any rounding: what proofs in doubles are checked by.
///
/// A fixed-point number that holds every such product and 2^60 of them: nothing overflows, nothing underflows, and
/// nothing is allocated. [Kulisch, Computer Arithmetic and Validity, 2008, chapter 8]
class ExactSum {
 public:
  void clear() { limbs_.fill(0); }

  /// Adds a b c. @pre they are finite
  void add(double a, double b, double c = 1);

  /// -1, 0 or 1.
  int sign() const;

  /// The sum, to within 2^-110 of it.
  Quad value() const;

 private:
  using Limb = std::uint64_t;

  // Products are multiples of 2^-3222 below 2^3072; two's complement, the least significant limb first.
  static constexpr int kLowestBit = -3222;
  static constexpr std::size_t kLimbs = (3072 - kLowestBit + 60) / 64 + 2;

  std::array<Limb, kLimbs> limbs_{};
};

}  // namespace lcpbench
