#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

// Integers of a length that the caller proves long enough, in memory of the caller's: nothing here allocates in a call.

namespace lcpbench::enumeration {

using Limb = std::uint64_t;
inline constexpr std::size_t kLimbBits = 64;

/// Two's complement, the least significant limb first, at least one.
using Integer = std::span<Limb>;
using ConstInteger = std::span<const Limb>;

/// Limbs that hold every integer below 2^bits in magnitude.
constexpr std::size_t limbs_for(std::size_t bits) { return bits / kLimbBits + 1; }

bool is_negative(ConstInteger x);
bool is_zero(ConstInteger x);
void negate(Integer x);

/// to = from modulo 2^(64 to.size()).
void assign(Integer to, ConstInteger from);

/// sum += a b modulo 2^(64 sum.size()). @pre no overlap
void add_product(Integer sum, ConstInteger a, ConstInteger b);

/// sum -= a b modulo 2^(64 sum.size()). @pre no overlap
void subtract_product(Integer sum, ConstInteger a, ConstInteger b);

/// Exact division, from the least significant limb on. It reads only the limbs that determine the quotient.
/// [Jebelean, An algorithm for exact division, 1993]
class ExactDivisor {
 public:
  /// Room for divisors of so many limbs. Allocates.
  void reserve(std::size_t limbs) { odd_.resize(limbs); }

  /// @param divisor not zero
  void set(ConstInteger divisor);

  /// Limbs of the dividend that a quotient of so many limbs depends on.
  std::size_t dividend_limbs(std::size_t quotient_limbs) const {
    return quotient_limbs + (shift_ + kLimbBits - 1) / kLimbBits;
  }

  /// quotient = dividend / divisor modulo 2^(64 quotient.size()).
  /// @param dividend of dividend_limbs(quotient.size()) limbs; destroyed
  void divide(Integer dividend, Integer quotient) const;

 private:
  std::vector<Limb> odd_;  // |divisor| / 2^shift_
  std::size_t size_ = 0;   // of odd_ in use
  std::size_t shift_ = 0;
  Limb inverse_ = 1;  // of odd_ modulo 2^64
  bool negative_ = false;
};

/// numerator / denominator rounded once to the nearest double (twice when the result is subnormal).
/// @param numerator,denominator of one length, the two top limbs free; destroyed. @pre denominator != 0
double nearest_double(Integer numerator, Integer denominator);

}  // namespace lcpbench::enumeration
