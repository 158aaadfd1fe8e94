#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/dyadic.h"

namespace lcpbench {

/// Integers modulo an odd prime below 2^62, held as x 2^64 mod p. [Montgomery 1985]
class PrimeField {
 public:
  using Element = std::uint64_t;

  explicit PrimeField(std::uint64_t prime);

  std::uint64_t prime() const { return prime_; }
  Element of(std::uint64_t x) const { return multiply(x, square_of_radix_); }
  /// Of an integer: x.low() >= 0.
  Element of(const Dyadic& x) const;
  std::uint64_t value(Element x) const { return reduce(x); }
  Element one() const { return one_; }
  Element add(Element a, Element b) const { return a + b < prime_ ? a + b : a + b - prime_; }
  Element subtract(Element a, Element b) const { return a < b ? a + prime_ - b : a - b; }
  Element multiply(Element a, Element b) const { return reduce(Wide{a} * b); }
  Element power(Element x, std::uint64_t exponent) const;
  /// @pre x != 0
  Element inverse(Element x) const { return power(x, prime_ - 2); }

 private:
  __extension__ using Wide = unsigned __int128;

  /// x / 2^64. @pre x < 2^64 p
  Element reduce(Wide x) const {
    const std::uint64_t multiple = static_cast<std::uint64_t>(x) * negative_inverse_;
    const auto reduced = static_cast<std::uint64_t>((x + Wide{multiple} * prime_) >> 64);
    return reduced < prime_ ? reduced : reduced - prime_;
  }

  std::uint64_t prime_;
  std::uint64_t negative_inverse_;  ///< -1 / p modulo 2^64
  std::uint64_t one_;               ///< 2^64 mod p
  std::uint64_t square_of_radix_;   ///< 2^128 mod p
};

/// The field of the largest prime below 2^62, of the next one, and so on.
const PrimeField& prime_field(std::size_t index);

/// Integers from their values modulo the primes of `fields`. [Garner 1959]
class Residues {
 public:
  explicit Residues(const std::vector<const PrimeField*>& fields);
  /// The integer nearest to zero with these values. @param values  one for each field
  Dyadic integer(const std::vector<std::uint64_t>& values) const;

 private:
  std::vector<const PrimeField*> fields_;
  std::vector<PrimeField::Element> primes_;    ///< by field i: the primes before it, in i
  std::vector<PrimeField::Element> inverses_;  ///< by field i: of the product of these
  Dyadic product_;
};

}  // namespace lcpbench
