#include "native/proofs/doubtful_inertia.h"

#include <algorithm>

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

void DoubtfulInertia::reserve(const ContactProblem& contact) {
  const auto* factors = std::get_if<FactoredInertia>(&contact.inertia);
  if (factors == nullptr) return;
  const Index order = std::min(factors->X.rows(), factors->X.cols());
  work_.reserve(static_cast<std::size_t>(order * order + factors->X.rows()));
}

void DoubtfulInertia::load(const ContactProblem& contact) {
  exact_.reset();
  is_doubtful_ = may_be_singular_ = false;
  if (const auto* factors = std::get_if<FactoredInertia>(&contact.inertia)) {
    is_doubtful_ = !is_far_from_dependent(*factors, work_);
    may_be_singular_ = is_doubtful_ || factors->X.cols() < factors->X.rows();
  } else if (const auto* given = std::get_if<InverseInertia>(&contact.inertia)) {
    is_doubtful_ = mixes_scales(given->Ginv);
    may_be_singular_ = true;
  }
}

void DoubtfulInertia::doubt_given(const ContactProblem& contact) {
  is_doubtful_ = is_doubtful_ || std::holds_alternative<DenseInertia>(contact.inertia) ||
                 std::holds_alternative<BlockInertia>(contact.inertia);
}

bool DoubtfulInertia::confirms_exactly(const ContactProblem& contact, const Eigen::Ref<const Vector>& v,
                                       Answer& answer) {
  ContactProblem moving = contact;
  moving.v = v;
  bool is_indefinite = false;
  if (!exact_) exact_ = ExactResponse::of(contact.inertia, &is_indefinite);
  if (is_indefinite && !std::holds_alternative<FactoredInertia>(contact.inertia)) return true;
  if (!exact_ || !(ExactContacts(moving, *exact_).velocity_residual(answer.z) <= kClaimedResidual)) return false;
  if (answer.velocity.size() > 0) answer.velocity = post_impact_velocity(moving, answer.z);
  return true;
}

}  // namespace lcpbench
