#include "native/answer_test.h"

#include <variant>

#include "core/answer_storage.h"
#include "native/contact_units.h"

namespace lcpbench {
namespace {

/// Of the verdict's 1e-4, relative to max|q|: in 113 bits nothing is lost to rounding but that of the returned lambdas.
constexpr double kClaimedQuadResidual = 0.999e-4;

}  // namespace

AnswerTest::AnswerTest() : judge_(contact_lemke_engine(isa_level())), quad_judge_(lemke::quad::kContactEngine) {}

void AnswerTest::load(const Problem& problem, Bodies bodies) {
  completed_.resize(problem.size());
  bare_ = problem.contact() == nullptr;
  trusts_ = bodies == Bodies::kTrusted && !bare_ && std::holds_alternative<BlockInertia>(problem.contact()->inertia);
  if (trusts_) return;
  if (bare_) return bare_test_.load(problem.lcp());
  const ContactProblem& contact = *problem.contact();
  units_ = coordinate_units(contact.inertia);
  if (units_.size() > 0) in_units_ = contact_in_units(contact, units_);
  contacts_.load(units_.size() > 0 ? in_units_ : contact);
  judge_.load(contacts_.input);
  quad_judge_.reserve(contacts_.input);
  quad_is_loaded_ = false;
}

void AnswerTest::set_velocity(const Vector& v) {
  if (trusts_) return;
  contacts_.v = v;
  if (units_.size() > 0) contacts_.v.array() /= units_.array();
  judge_.set_velocity(contacts_.v.data());
  if (quad_is_loaded_) quad_judge_.set_velocity(contacts_.v.data());
}

bool AnswerTest::settle(Answer& answer) {
  if (answer.claim != Claim::kSolved) return false;
  if (trusts_) return true;
  if (solves(answer.z)) {
    if (bare_ && bare_test_.disproves(completed_)) {
      answer.claim = Claim::kUnsolvable;
      answer.detail = "proven";
      Vector& farkas = cleared_vectors().farkas;
      farkas = bare_test_.proof();
      answer.farkas.swap(farkas);
      return false;
    }
    answer.z = completed_;
    return true;
  }
  answer.claim = Claim::kNumericalFailure;
  answer.detail = "residual";  // short enough for std::string to hold in place
  return false;
}

bool AnswerTest::solves(const Vector& z) {
  if (!z.allFinite()) return false;
  completed_ = z.cwiseMax(0.0);
  if (!bare_) return solves_contacts();
  return bare_test_.backward_error(completed_) <= kClaimedBackwardError;
}

bool AnswerTest::solves_contacts() {
  release_friction(contacts_.input, completed_);
  if (judge_.complete(completed_.data()).certain <= kClaimedResidual) return true;
  if (!quad_is_loaded_) quad_judge_.load(contacts_.input);
  quad_is_loaded_ = true;
  return quad_judge_.complete(completed_.data()).certain <= kClaimedQuadResidual;
}

void release_friction(const contact_lemke::Input& contacts, Vector& z) {
  for (std::ptrdiff_t contact = 0; contact < contacts.nc; ++contact) {
    if (z(contact) > 0) continue;
    z.segment(contacts.nc + contacts.friction_begin[contact],
              contacts.friction_begin[contact + 1] - contacts.friction_begin[contact])
        .setZero();
  }
}

}  // namespace lcpbench
