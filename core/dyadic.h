#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/quad.h"

namespace lcpbench {

/// A number m 2^e with integers m and e, without any rounding: every double is one, and their sums and products are.
///
/// Sign and magnitude; the exponent is a multiple of 64, so that sums need no shifts. Every number allocates; a sum
/// takes memory for all bits between its largest and its least. (`exact::Dyadic` of study/certify is a whole matrix.)
class Dyadic {
 public:
  using Limb = std::uint64_t;
  static constexpr int kLimbBits = 64;

  Dyadic() = default;
  /// @pre x is finite
  explicit Dyadic(double x);
  /// @pre x is finite
  explicit Dyadic(Quad x);
  /// sign * (the magnitude of the limbs, the least significant first) * 2^(64 low). @pre sign is 1 or -1
  Dyadic(int sign, std::vector<Limb> limbs, std::int64_t low);

  /// -1, 0 or 1.
  int sign() const { return sign_; }
  bool is_zero() const { return sign_ == 0; }
  /// The magnitude is limbs() 2^(64 low()); the first and the last limb are not zero, none for zero.
  const std::vector<Limb>& limbs() const { return limbs_; }
  std::int64_t low() const { return low_; }
  /// The magnitude is below 2^(64 high()). 0 for zero.
  std::int64_t high() const { return low_ + static_cast<std::int64_t>(limbs_.size()); }

  /// This times 2^(64 limbs).
  Dyadic shifted(std::int64_t limbs) const;

  Dyadic operator-() const;
  Dyadic& operator+=(const Dyadic& x);
  Dyadic& operator-=(const Dyadic& x) { return *this += -x; }
  friend Dyadic operator+(Dyadic a, const Dyadic& b) { return a += b; }
  friend Dyadic operator-(Dyadic a, const Dyadic& b) { return a += -b; }
  friend Dyadic operator*(const Dyadic& a, const Dyadic& b);

 private:
  void trim();

  int sign_ = 0;
  std::int64_t low_ = 0;
  std::vector<Limb> limbs_;
};

/// -1, 0 or 1 as |a| is smaller than |b|, equal, or larger.
int compare_magnitudes(const Dyadic& a, const Dyadic& b);

inline Dyadic abs(const Dyadic& x) { return x.sign() < 0 ? -x : x; }
inline bool operator<(const Dyadic& a, const Dyadic& b) { return (a - b).sign() < 0; }

/// a / b to within a few units of 2^-113 of it, less exact where it is subnormal; beyond the range of Quad infinite or
/// zero. @pre b != 0
Quad quotient(const Dyadic& a, const Dyadic& b);

}  // namespace lcpbench
