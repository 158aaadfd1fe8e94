#include "native/lemke/lemke_finish.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "native/answer_test/answer_test.h"

namespace lcpbench {
namespace {

constexpr double kNoDeadline = std::numeric_limits<double>::infinity();

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
    bare_ = false;
    contacts_.load(*contact);
    contacts_.input.polishes_answers = polishes_;
    judge_.load(contacts_.input);
    implied_velocity_.resize(contacts_.moving());
    return;
  }
  bare_ = true;
  bare_test_.load(problem.lcp());
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
  const bool passes =
      bare_ ? finish_matrix(engine, answer) <= kClaimedBackwardError && !bare_test_.disproves(answer.z, kNoDeadline)
            : finish_contacts(answer) <= kClaimedResidual;
  if (passes) return;
  answer.claim = Claim::kNumericalFailure;
  answer.detail = "residual";
  answer.z.setZero();
}

/// @returns the velocity residual with its estimated rounding, relative to max|q|
double LemkeFinish::finish_contacts(Answer& answer) {
  release_friction(contacts_.input, answer.z);
  if (polishes_) {
    plain_ = answer.z;
    if (polish_contacts(answer)) {
      const double residual = judge_.complete(answer.z.data()).certain;
      if (residual <= kClaimedResidual) {
        test_velocity(answer);
        return residual;
      }
    }
    answer.z = plain_;
    answer.velocity.resize(0);
  }
  return judge_.complete(answer.z.data()).certain;
}

bool LemkeFinish::polish_contacts(Answer& answer) {
  answer.velocity.resize(contacts_.moving());
  if (!judge_.polish_answer(basic_.data(), answer.velocity.data(), answer.z.data())) return false;
  clip(answer.z);
  release_friction(contacts_.input, answer.z);
  return answer.velocity.allFinite();
}

/// Leaves the velocity of the basis where it is that of the impulses. What was clipped has no part in that of the
/// others.
void LemkeFinish::test_velocity(Answer& answer) {
  if (!(judge_.lost() <= kMostLostToVelocity)) return answer.velocity.resize(0);
  judge_.respond(answer.z.data(), implied_velocity_.data());
  const Eigen::Map<const Vector> v(contacts_.input.v, contacts_.moving());
  if (is_velocity_of_impulses(v, implied_velocity_, 0x1p-52, answer.velocity)) return;
  answer.velocity = implied_velocity_;
}

double LemkeFinish::finish_matrix(lemke::LoadedEngine& engine, Answer& answer) {
  const bool has_basis = answer.counters.pivots > 0;  // else z = 0 without one
  if (polishes_ && has_basis) {
    plain_ = answer.z;
    if (engine.refine(answer.z.data())) {
      clip(answer.z);
      const double error = bare_test_.backward_error(answer.z);
      if (error <= kClaimedBackwardError) return error;
    }
    answer.z = plain_;
  }
  return bare_test_.backward_error(answer.z);
}

}  // namespace lcpbench
