#include "study/certify/exact_problem.h"

#include <algorithm>
#include <utility>

#include "study/certify/integer_solve.h"

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
    const auto at = index(i);
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
    const auto at = index(i);
    result(i) = rounded(x.numerators[at], x.exponents[at] - base, largest);
  }
  return result;
}

ExactProblem::ExactProblem(const Problem& problem, const Deadline& deadline) {
  if (problem.contact() == nullptr) {
    system_ = bare_system(problem.lcp());
    return;
  }
  const ContactProblem& contact = *problem.contact();
  frictional_ = contact.frictional();
  v_ = to_dyadic(contact.v);
  if (const auto* factors = std::get_if<FactoredInertia>(&contact.inertia)) {
    weighted_ = weighted_factors(*factors);
    spanning_ = independent_factors(*factors, deadline);
  }
  inertia_ = exact_inertia(contact.inertia, spanning_, deadline);
  if (!inertia_.refusal.empty()) return;
  system_ = contact_system(contact, inertia_, deadline);
  if (spanning_.size() == weighted_.size()) return;
  stated_inertia_ = exact_inertia(contact.inertia, weighted_, deadline);
  stated_ = contact_system(contact, *stated_inertia_, deadline);
}

ExactPoint ExactProblem::stated(ExactPoint point) const {
  if (!stated_) return point;
  IntegerVector p(weighted_.size());
  std::size_t next = 0;
  for (std::size_t i = 0; i < weighted_.size() && next < spanning_.size(); ++i) {
    if (weighted_[i] == spanning_[next]) std::swap(p[i], point.p[next++]);
  }
  point.p = std::move(p);
  return point;
}

ScaledVector ExactProblem::z(const ExactPoint& point) const {
  return {point.z, stated().z_exponent, point.denominator};
}

ScaledVector ExactProblem::potential(const ExactPoint& point) const {
  return {point.p, std::vector<slong>(point.p.size(), stated().p_exponent), point.denominator};
}

ScaledVector ExactProblem::velocity_after(const ExactPoint& point) const {
  const ExactInertia& inertia = stated_inertia_ ? *stated_inertia_ : inertia_;
  const slong change_exponent = stated().p_exponent + (inertia.velocity ? inertia.velocity->exponent : 0);
  const slong exponent = std::min(v_.exponent, change_exponent);
  const Index ngc = v_.m.rows();
  ScaledVector result{IntegerVector(index(ngc)), std::vector<slong>(index(ngc), exponent), point.denominator};
  for (Index i = 0; i < ngc; ++i) {
    Integer change;
    if (inertia.velocity) {
      for (std::size_t j = 0; j < point.p.size(); ++j) {
        fmpz_addmul(change.get(), inertia.velocity->m(i, static_cast<Index>(j)), point.p[j].get());
      }
    } else {
      change = point.p[index(i)];
    }
    shift_left(change, change_exponent - exponent);
    Integer& sum = result.numerators[index(i)];
    fmpz_mul(sum.get(), v_.m(i, 0), point.denominator.get());
    shift_left(sum, v_.exponent - exponent);
    fmpz_add(sum.get(), sum.get(), change.get());
  }
  return result;
}

std::optional<ExactPoint> point_at_rest(const ExactProblem& problem, const Deadline& deadline) {
  const Dyadic& v = problem.velocity();
  const ExactInertia& inertia = problem.inertia();
  IntegerMatrix p = v.m;
  ExactPoint point{IntegerVector(index(v.m.rows())), IntegerVector(index(problem.system().size())), Integer(1)};
  slong exponent = v.exponent;
  if (inertia.velocity) {
    if (!Lifting(inertia.velocity->m, deadline).solve(v.m, p, point.denominator)) return std::nullopt;
    exponent -= inertia.velocity->exponent;
  }
  const slong shift = exponent - problem.system().p_exponent;
  if (shift > 0) fmpz_mat_scalar_mul_2exp(p.get(), p.get(), static_cast<ulong>(shift));
  if (shift < 0) fmpz_mul_2exp(point.denominator.get(), point.denominator.get(), static_cast<ulong>(-shift));
  for (std::size_t i = 0; i < point.p.size(); ++i) fmpz_neg(point.p[i].get(), p(static_cast<Index>(i), 0));
  return point;
}

}  // namespace lcpbench::exact
