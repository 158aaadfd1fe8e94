#include "native/answer_test/exact_integer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <vector>

#include <boost/multiprecision/cpp_int.hpp>
#include <gtest/gtest.h>

namespace lcpbench::enumeration {
namespace {

using Reference = boost::multiprecision::cpp_int;
using Limbs = std::vector<Limb>;

/// x modulo 2^(64 limbs), as two's complement.
Limbs limbs_of(const Reference& x, std::size_t limbs) {
  const Reference modulus = Reference(1) << static_cast<unsigned>(kLimbBits * limbs);
  Reference rest = ((x % modulus) + modulus) % modulus;
  Limbs result;
  for (std::size_t i = 0; i < limbs; ++i) {
    result.push_back(static_cast<Limb>(rest & ~Limb{0}));
    rest >>= static_cast<unsigned>(kLimbBits);
  }
  return result;
}

/// Random numbers of random lengths, with runs of zeros and ones, where carries go far.
class ExactIntegerTest : public ::testing::Test {
 protected:
  std::size_t up_to(std::size_t most) { return std::uniform_int_distribution<std::size_t>(0, most)(random_); }

  /// Below 2^bits in magnitude.
  Reference integer(std::size_t bits) {
    Reference x = 0;
    for (std::size_t done = 0; done < bits;) {
      const std::size_t run = std::min(bits - done, 1 + up_to(90));
      x <<= static_cast<unsigned>(run);
      const std::size_t kind = up_to(3);
      const Reference ones = (Reference(1) << static_cast<unsigned>(run)) - 1;
      if (kind == 1) x |= ones;
      if (kind > 1) x |= ((Reference(random_()) << 64) | random_()) & ones;
      done += run;
    }
    return up_to(1) == 0 ? x : Reference(-x);
  }

  Reference nonzero_integer(std::size_t bits) {
    for (;;) {
      const Reference x = integer(bits);
      if (x != 0) return x;
    }
  }

 private:
  std::mt19937_64 random_{1};
};

TEST_F(ExactIntegerTest, AddsAndSubtractsProductsModuloTheLengthOfTheSum) {
  for (int trial = 0; trial < 20000; ++trial) {
    const std::size_t bits_a = up_to(500), bits_b = up_to(500), limbs = 1 + up_to(20);
    const Reference a = integer(bits_a), b = integer(bits_b), before = integer(kLimbBits * limbs - 1);
    Limbs sum = limbs_of(before, limbs);
    add_product(sum, limbs_of(a, limbs_for(bits_a)), limbs_of(b, limbs_for(bits_b)));
    ASSERT_EQ(sum, limbs_of(before + a * b, limbs)) << a << " " << b << " " << before;
    subtract_product(sum, limbs_of(b, limbs_for(bits_b)), limbs_of(a, limbs_for(bits_a)));
    ASSERT_EQ(sum, limbs_of(before, limbs)) << a << " " << b << " " << before;
  }
}

TEST_F(ExactIntegerTest, DividesExactly) {
  ExactDivisor by;
  by.reserve(limbs_for(500));
  for (int trial = 0; trial < 20000; ++trial) {
    const std::size_t bits = 1 + up_to(499), quotient_bits = up_to(500);
    const Reference divisor = nonzero_integer(bits), quotient = integer(quotient_bits);
    by.set(limbs_of(divisor, limbs_for(bits)));
    Limbs result(limbs_for(quotient_bits));
    Limbs dividend = limbs_of(divisor * quotient, by.dividend_limbs(result.size()));
    by.divide(dividend, result);
    ASSERT_EQ(result, limbs_of(quotient, result.size())) << quotient << " " << divisor;
  }
}

TEST_F(ExactIntegerTest, RoundsQuotientsToNearest) {
  for (int trial = 0; trial < 20000; ++trial) {
    const std::size_t bits = 1 + up_to(400);
    const Reference denominator = nonzero_integer(bits);
    // A multiple of the denominator by 54 bits, or one beside it, is a tie or is decided by its last bit.
    const std::size_t numerator_bits = trial % 2 == 0 ? up_to(400) : bits + 54;
    const Reference numerator =
        trial % 2 == 0 ? integer(numerator_bits) : Reference(denominator * integer(54) + integer(1));
    const std::size_t limbs = limbs_for(std::max(bits, numerator_bits) + 1) + 2;
    Limbs above = limbs_of(numerator, limbs), below = limbs_of(denominator, limbs);
    const double rounded = nearest_double(above, below);
    if (numerator == 0) {
      ASSERT_EQ(rounded, 0);
      continue;
    }
    // Twice the error is at most one unit in the last place, and a tie goes to the even one.
    int exponent = 0;
    const auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(rounded, &exponent), 53));
    exponent -= 53;
    Reference n = numerator, d = denominator;
    (exponent > 0 ? d : n) <<= static_cast<unsigned>(std::abs(exponent));
    const Reference twice_error = 2 * abs(Reference(n - mantissa * d));
    ASSERT_LE(twice_error, abs(d)) << numerator << " / " << denominator << " = " << rounded;
    ASSERT_TRUE(twice_error < abs(d) || mantissa % 2 == 0) << numerator << " / " << denominator;
  }
}

}  // namespace
}  // namespace lcpbench::enumeration
