#include "native/lemke/lemke_finish.h"

#include <algorithm>
#include <cmath>

#include "native/answer_test/answer_test.h"

namespace lcpbench {
namespace {

/// What is negative is a slack of the ratio test, or rounding; the test tells whether it mattered.
void clip(Vector& z) {
  for (double& value : z) {
    if (value < 0) value = 0;
  }
}

}  // namespace

void LemkeFinish::load(const Problem& problem) {
  const Index n = problem.size();
  plain_.resize(n);
  basic_.resize(static_cast<std::size_t>(n));
  if (const ContactProblem* contact = problem.contact()) {
    bare_ = false;
    contacts_.load(*contact);
    contacts_.input.polishes_answers = true;
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
  clip(answer.z);
  plain_ = answer.z;
  const bool is_better = bare_ ? polish_matrix(engine, answer) : polish_contacts(answer);
  if (is_better) return;
  answer.z = plain_;
  answer.velocity.resize(0);
}

bool LemkeFinish::polish_contacts(Answer& answer) {
  answer.velocity.resize(contacts_.moving());
  if (!judge_.polish_answer(basic_.data(), answer.velocity.data(), answer.z.data())) return false;
  clip(answer.z);
  release_friction(contacts_.input, answer.z);
  if (!answer.velocity.allFinite() || !(judge_.complete(answer.z.data()).certain <= kClaimedResidual)) return false;
  test_velocity(answer);
  return true;
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

bool LemkeFinish::polish_matrix(lemke::LoadedEngine& engine, Answer& answer) {
  const bool has_basis = answer.counters.pivots > 0;  // else z = 0 without one
  if (!has_basis || !engine.refine(answer.z.data())) return false;
  clip(answer.z);
  return bare_test_.backward_error(answer.z) <= kClaimedBackwardError;
}

}  // namespace lcpbench
