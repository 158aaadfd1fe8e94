#include "study/certify/exact_output.h"

#include <algorithm>

namespace lcpbench::exact {
namespace {

slong smallest_exponent(const ScaledVector& x) {
  return x.exponents.empty() ? 0 : *std::min_element(x.exponents.begin(), x.exponents.end());
}

}  // namespace

ExactVector to_text(const ScaledVector& x) {
  const slong base = std::min(smallest_exponent(x), slong{0});
  ExactVector result;
  Integer denominator = x.denominator;
  shift_left(denominator, -base);
  result.denominator = text(denominator);
  for (std::size_t i = 0; i < x.numerators.size(); ++i) {
    Integer numerator = x.numerators[i];
    shift_left(numerator, x.exponents[i] - base);
    result.numerators.push_back(text(numerator));
  }
  return result;
}

Vector to_doubles(const ScaledVector& x) {
  Vector result(static_cast<Index>(x.numerators.size()));
  for (Index i = 0; i < result.size(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    result(i) = rounded(x.numerators[at], x.exponents[at], x.denominator);
  }
  return result;
}

Vector to_unit_doubles(const ScaledVector& x) {
  const slong base = smallest_exponent(x);
  Integer largest;
  for (std::size_t i = 0; i < x.numerators.size(); ++i) {
    Integer size;
    fmpz_abs(size.get(), x.numerators[i].get());
    shift_left(size, x.exponents[i] - base);
    if (fmpz_cmp(size.get(), largest.get()) > 0) largest = size;
  }
  Vector result = Vector::Zero(static_cast<Index>(x.numerators.size()));
  if (largest.sign() == 0) return result;
  for (Index i = 0; i < result.size(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    result(i) = rounded(x.numerators[at], x.exponents[at] - base, largest);
  }
  return result;
}

ScaledVector scaled_z(const ExactSystem& system, const ExactPoint& point) {
  return {point.z, system.z_exponent, point.denominator};
}

ScaledVector scaled_potential(const ExactSystem& system, const ExactPoint& point) {
  return {point.p, std::vector<slong>(point.p.size(), system.p_exponent), point.denominator};
}

ScaledVector scaled_velocity(const ExactInertia& inertia, const Dyadic& v, const ExactSystem& system,
                             const ExactPoint& point) {
  const slong change_exponent = system.p_exponent + (inertia.velocity ? inertia.velocity->exponent : 0);
  const slong exponent = std::min(v.exponent, change_exponent);
  const Index ngc = v.m.rows();
  ScaledVector result{IntegerVector(static_cast<std::size_t>(ngc)),
                      std::vector<slong>(static_cast<std::size_t>(ngc), exponent), point.denominator};
  for (Index i = 0; i < ngc; ++i) {
    Integer change;
    if (inertia.velocity) {
      for (std::size_t j = 0; j < point.p.size(); ++j) {
        fmpz_addmul(change.get(), inertia.velocity->m(i, static_cast<Index>(j)), point.p[j].get());
      }
    } else {
      change = point.p[static_cast<std::size_t>(i)];
    }
    shift_left(change, change_exponent - exponent);
    Integer& sum = result.numerators[static_cast<std::size_t>(i)];
    fmpz_mul(sum.get(), v.m(i, 0), point.denominator.get());
    shift_left(sum, v.exponent - exponent);
    fmpz_add(sum.get(), sum.get(), change.get());
  }
  return result;
}

}  // namespace lcpbench::exact
