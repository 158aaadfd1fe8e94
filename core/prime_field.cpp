#include "core/prime_field.h"

#include <array>
#include <deque>
#include <mutex>
#include <utility>

namespace lcpbench {
namespace {

__extension__ using Wide = unsigned __int128;

constexpr std::uint64_t kAllPrimesBelow = std::uint64_t{1} << 62;

/// By Miller and Rabin with the bases that leave no doubt below 2^81. [Sorenson, Webster 2017]
bool is_prime(std::uint64_t n) {
  constexpr std::array<std::uint64_t, 13> kBases{2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41};
  for (const std::uint64_t small : kBases) {
    if (n % small == 0) return false;
  }
  const PrimeField field(n);
  std::uint64_t odd = n - 1;
  int twos = 0;
  for (; odd % 2 == 0; odd /= 2) ++twos;
  const PrimeField::Element minus_one = n - field.one();
  for (const std::uint64_t base : kBases) {
    PrimeField::Element x = field.power(field.of(base), odd);
    bool passes = x == field.one() || x == minus_one;
    for (int k = 1; k < twos && !passes; ++k) {
      x = field.multiply(x, x);
      passes = x == minus_one;
    }
    if (!passes) return false;
  }
  return true;
}

/// x := factor x + addend.
void multiply_add(std::vector<Dyadic::Limb>& x, std::uint64_t factor, std::uint64_t addend) {
  std::uint64_t carry = addend;
  for (Dyadic::Limb& limb : x) {
    const Wide product = Wide{limb} * factor + carry;
    limb = static_cast<Dyadic::Limb>(product);
    carry = static_cast<std::uint64_t>(product >> 64);
  }
  if (carry != 0) x.push_back(carry);
}

}  // namespace

PrimeField::PrimeField(std::uint64_t prime) : prime_(prime) {
  std::uint64_t inverse = 1;
  for (int step = 0; step < 6; ++step) inverse *= 2 - prime * inverse;  // each doubles the bits that are right
  negative_inverse_ = ~inverse + 1;
  one_ = static_cast<std::uint64_t>((Wide{1} << 64) % prime);
  square_of_radix_ = static_cast<std::uint64_t>(Wide{one_} * one_ % prime);
}

PrimeField::Element PrimeField::of(const Dyadic& x) const {
  Element sum = 0;
  for (std::size_t i = x.limbs().size(); i-- > 0;) {
    sum = add(multiply(sum, square_of_radix_), of(x.limbs()[i]));  // the radix is square_of_radix_ as an element
  }
  for (std::int64_t k = 0; k < x.low(); ++k) sum = multiply(sum, square_of_radix_);
  return x.sign() < 0 ? subtract(0, sum) : sum;
}

PrimeField::Element PrimeField::power(Element x, std::uint64_t exponent) const {
  Element result = one_;
  for (; exponent != 0; exponent /= 2) {
    if (exponent % 2 != 0) result = multiply(result, x);
    x = multiply(x, x);
  }
  return result;
}

const PrimeField& prime_field(std::size_t index) {
  static std::mutex mutex;
  static std::deque<PrimeField> fields;  // whose elements stay where they are
  const std::scoped_lock lock(mutex);
  while (fields.size() <= index) {
    std::uint64_t candidate = (fields.empty() ? kAllPrimesBelow + 1 : fields.back().prime()) - 2;
    while (!is_prime(candidate)) candidate -= 2;
    fields.emplace_back(candidate);
  }
  return fields[index];
}

Residues::Residues(const std::vector<const PrimeField*>& fields) : fields_(fields), product_(1.0) {
  for (const PrimeField* field : fields_) {
    PrimeField::Element product = field->one();
    for (const PrimeField* before : fields_) {
      if (before == field) break;
      primes_.push_back(field->of(before->prime()));
      product = field->multiply(product, primes_.back());
    }
    inverses_.push_back(field->inverse(product));
    product_ = product_ * Dyadic(1, {field->prime()}, 0);
  }
}

Dyadic Residues::integer(const std::vector<std::uint64_t>& values) const {
  std::vector<std::uint64_t> digits(values.size());  // of d_0 + p_0 (d_1 + p_1 (d_2 + ...))
  const PrimeField::Element* primes = primes_.data();
  for (std::size_t i = 0; i < values.size(); ++i) {
    const PrimeField& field = *fields_[i];
    PrimeField::Element known = 0;
    for (std::size_t j = i; j-- > 0;) known = field.add(field.multiply(known, primes[j]), field.of(digits[j]));
    primes += i;
    digits[i] = field.value(field.multiply(field.subtract(field.of(values[i]), known), inverses_[i]));
  }
  std::vector<Dyadic::Limb> limbs;
  for (std::size_t i = digits.size(); i-- > 0;) multiply_add(limbs, fields_[i]->prime(), digits[i]);
  Dyadic least(1, std::move(limbs), 0);
  const Dyadic opposite = least - product_;
  return compare_magnitudes(opposite, least) < 0 ? opposite : least;
}

}  // namespace lcpbench
