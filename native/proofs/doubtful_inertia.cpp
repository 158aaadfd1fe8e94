#include "native/proofs/doubtful_inertia.h"

#include <algorithm>
#include <variant>

#include "core/answer/contact_residual.h"
#include "core/compliance.h"

namespace lcpbench {
namespace {

/// Whether coordinates that move are so far apart in scale that a root of G* may lose one.
bool mixes_scales(const Matrix& Ginv) {
  constexpr double kFar = 0x1p40;
  double largest = 0;
  for (const double entry : Ginv.diagonal()) largest = std::max(largest, entry);
  return std::any_of(Ginv.diagonal().begin(), Ginv.diagonal().end(),
                     [&](double entry) { return entry != 0 && entry * kFar < largest; });
}

}  // namespace

bool may_be_singular(const ContactProblem& contact) {
  return std::holds_alternative<FactoredInertia>(contact.inertia) ||
         std::holds_alternative<InverseInertia>(contact.inertia);
}

bool may_be_unsolvable(const ContactProblem& contact) {
  if (every_contact_yields(contact)) return false;
  return may_be_singular(contact) || !(contact.b.array() >= 0).all();
}

void DoubtfulInertia::reserve(const ContactProblem& contact) {
  const auto* factors = std::get_if<FactoredInertia>(&contact.inertia);
  if (factors == nullptr) return;
  const Index order = std::min(factors->X.rows(), factors->X.cols());
  work_.reserve(static_cast<std::size_t>(order * order + factors->X.rows()));
}

void DoubtfulInertia::load(const ContactProblem& contact) {
  is_doubtful_ = may_be_singular_ = false;
  if (const auto* factors = std::get_if<FactoredInertia>(&contact.inertia)) {
    is_doubtful_ = !is_far_from_dependent(*factors, work_);
    may_be_singular_ = is_doubtful_ || factors->X.cols() < factors->X.rows();
  } else if (const auto* given = std::get_if<InverseInertia>(&contact.inertia)) {
    is_doubtful_ = mixes_scales(given->Ginv);
    may_be_singular_ = true;
  }
}

bool DoubtfulInertia::confirms_in_quad(const ContactProblem& contact, const Eigen::Ref<const Vector>& v,
                                       Answer& answer) {
  constexpr Index kMostCoordinates = 200;  // which take some tenths of a second
  if (contact.ngc() > kMostCoordinates) return false;
  ContactProblem moving = contact;
  moving.v = v;
  ContactResidual residual(moving);
  if (!residual.lcp) return false;
  const ContactResidual::Point point = residual.at(answer.z);
  if (!(residual.rho(point) <= kClaimedResidual)) return false;
  for (Index i = 0; i < answer.velocity.size(); ++i) {
    answer.velocity(i) = to_double(point.u[static_cast<std::size_t>(i)]);
  }
  return true;
}

}  // namespace lcpbench
