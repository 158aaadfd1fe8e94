#include "native/contact_test.h"

namespace lcpbench {

void ContactTest::load(const Problem& problem) {
  bare_ = problem.contact() == nullptr;
  if (bare_) return;
  contacts_.load(*problem.contact());
  judge_.load(contacts_.input);
  completed_.resize(problem.size());
}

bool ContactTest::passes(const Vector& z) {
  if (bare_) return true;
  completed_ = z;
  return judge_.complete(completed_.data()).certain <= kClaimedResidual;
}

}  // namespace lcpbench
