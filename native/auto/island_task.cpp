#include "native/auto/island_task.h"

#include <algorithm>
#include <variant>

#include "native/proofs/doubtful_inertia.h"

namespace lcpbench {

void IslandTask::load(const Problem& loaded, const Vector& velocity) {
  problem = &loaded;
  v = velocity;
  has_sticking_ = has_test_ = false;
}

void IslandTask::set_velocity(const Vector& velocity) {
  v = velocity;
  if (has_sticking_) sticking_->set_velocity(v);
}

void IslandTask::begin(const AutoLimits& of_this_solve) {
  limits = of_this_solve;
  progress.fill(Progress::kNone);
}

double IslandTask::largest_claimed() const {
  return may_be_singular(contact()) ? kSureResidual : kClaimedResidual;
}

double IslandTask::aim_of(double error) const {
  return std::holds_alternative<BlockInertia>(contact().inertia) ? error : std::min(error, largest_claimed());
}

bool IslandTask::passes(const Vector& z, Answer& answer) {
  answer.clear();
  answer.z = z;
  answer.claim = Claim::kSolved;
  return loaded_test().settle(answer, limits.deadline_s) || answer.claim == Claim::kUnsolvable;
}

bool IslandTask::disproves(Answer& answer) {
  answer.clear();
  loaded_test().settle_ray(answer, limits.deadline_s);
  return answer.claim == Claim::kUnsolvable;
}

AnswerTest& IslandTask::loaded_test() {
  if (!has_test_) test_.load(*problem);
  has_test_ = true;
  test_.set_velocity(v);
  test_.allow(aim_of(limits.error));
  return test_;
}

StickingContacts& IslandTask::loaded_sticking() {
  if (sticking_ == nullptr) sticking_ = std::make_unique<StickingContacts>(is_whole);
  if (!has_sticking_) sticking_->load(*problem, v);
  has_sticking_ = true;
  return *sticking_;
}

}  // namespace lcpbench
