#include "native/lemke_finish.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/answer_storage.h"
#include "native/contact_test.h"

namespace lcpbench {
namespace {

/// Half of what the evaluation allows of bare LCPs: row-wise backward error. Of contact problems: kClaimedResidual.
constexpr double kClaimedBackwardError = 5e-10;

/// What is negative is a slack of the ratio test, or rounding; the test tells whether it mattered.
void clip(Vector& z) {
  for (double& value : z) {
    if (value < 0) value = 0;
  }
}

}  // namespace

LemkeFinish::LemkeFinish(const contact_lemke::Engine& judge, bool polishes) : judge_(judge), polishes_(polishes) {}

void LemkeFinish::load(const Problem& problem) {
  const Index n = problem.size();
  plain_.resize(n);
  basic_.resize(static_cast<std::size_t>(n));
  if (const ContactProblem* contact = problem.contact()) {
    lcp_ = nullptr;
    contacts_.load(*contact);
    contacts_.input.polishes_answers = polishes_;
    judge_.load(contacts_.input);
    return;
  }
  lcp_ = &problem.lcp();
  w_.resize(n);
  size_.resize(n);
}

char* LemkeFinish::begin_basis() {
  std::fill(basic_.begin(), basic_.end(), char{0});
  return basic_.data();
}

void LemkeFinish::run(lemke::LoadedEngine& engine, Answer& answer) {
  if (answer.claim == Claim::kUnsolvable) {
    answer.claim = Claim::kNumericalFailure;
    answer.detail = "ray, no proof";
    return;
  }
  if (answer.claim != Claim::kSolved) return;
  clip(answer.z);
  const bool passes = lcp_ != nullptr ? finish_matrix(engine, answer) <= kClaimedBackwardError
                                      : finish_contacts(answer) <= kClaimedResidual;
  if (passes) return;
  answer.claim = Claim::kNumericalFailure;
  answer.detail = "residual";
  answer.z.setZero();
}

/// A contact that does not press has no friction either: what is left of it is rounding.
void LemkeFinish::release_friction(Vector& z) const {
  const contact_lemke::Input& input = contacts_.input;
  for (std::ptrdiff_t contact = 0; contact < input.nc; ++contact) {
    if (z(contact) > 0) continue;
    z.segment(input.nc + input.friction_begin[contact],
              input.friction_begin[contact + 1] - input.friction_begin[contact])
        .setZero();
  }
}

/// @returns the velocity residual with its estimated rounding, relative to max|q|
double LemkeFinish::finish_contacts(Answer& answer) {
  release_friction(answer.z);
  if (polishes_) {
    plain_ = answer.z;
    if (polish_contacts(answer)) {
      const double residual = judge_.complete(answer.z.data()).certain;
      if (residual <= kClaimedResidual) {
        answer.velocity.swap(cleared_vectors().velocity);
        return residual;
      }
    }
    answer.z = plain_;
  }
  return judge_.complete(answer.z.data()).certain;
}

/// The velocity goes to the memory of cleared vectors.
bool LemkeFinish::polish_contacts(Answer& answer) {
  Vector& velocity = cleared_vectors().velocity;
  velocity.resize(contacts_.input.ngc);
  if (!judge_.polish_answer(basic_.data(), velocity.data(), answer.z.data())) return false;
  clip(answer.z);
  release_friction(answer.z);
  return velocity.allFinite();
}

double LemkeFinish::finish_matrix(lemke::LoadedEngine& engine, Answer& answer) {
  const bool has_basis = answer.counters.pivots > 0;  // else z = 0 without one
  if (polishes_ && has_basis) {
    plain_ = answer.z;
    if (engine.refine(answer.z.data())) {
      clip(answer.z);
      const double error = backward_error(answer.z);
      if (error <= kClaimedBackwardError) return error;
    }
    answer.z = plain_;
  }
  return backward_error(answer.z);
}

/// The largest |w_i| where z_i > 0, max(0, -w_i) elsewhere, relative to |q_i| + (|M| z)_i, and the rounding of w.
double LemkeFinish::backward_error(const Vector& z) {
  const auto& [M, q] = *lcp_;
  w_ = q;
  size_ = q.cwiseAbs();
  for (Index j = 0; j < z.size(); ++j) {
    if (z(j) == 0) continue;
    w_ += z(j) * M.col(j);
    size_ += z(j) * M.col(j).cwiseAbs();
  }
  double worst = 0;
  for (Index i = 0; i < z.size(); ++i) {
    const double off = z(i) > 0 || !(w_(i) >= 0) ? std::abs(w_(i)) : 0.0;
    if (off == 0) continue;
    const double relative = off / size_(i);
    if (!(relative <= worst)) worst = std::isnan(relative) ? std::numeric_limits<double>::infinity() : relative;
  }
  return worst + static_cast<double>(z.size() + 1) * std::numeric_limits<double>::epsilon();
}

}  // namespace lcpbench
