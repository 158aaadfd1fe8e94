#include "study/certify/exact_problem.h"

#include <utility>

#include "study/certify/integer_solve.h"

namespace lcpbench::exact {

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

std::optional<ExactPoint> point_at_rest(const ExactProblem& problem, const Deadline& deadline) {
  const Dyadic& v = problem.velocity();
  const ExactInertia& inertia = problem.inertia();
  IntegerMatrix p = v.m;
  ExactPoint point{IntegerVector(static_cast<std::size_t>(v.m.rows())),
                   IntegerVector(static_cast<std::size_t>(problem.system().size())), Integer(1)};
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
