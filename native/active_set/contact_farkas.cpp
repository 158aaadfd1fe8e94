#include "native/active_set/contact_farkas.h"

#include <utility>
#include <vector>

#include "core/timed_solve.h"
#include "native/active_set/active_set.h"

namespace lcpbench {

bool ContactFarkas::proves_unsolvable(const Vector& v, double deadline_s) {
  std::vector<Index> hard;
  for (Index c = 0; c < contact_->nc(); ++c) {
    if (!(contact_->normal_compliance(c) > 0)) hard.push_back(c);
  }
  const double left_s = deadline_s - wall_clock_s();
  if (hard.empty() || !(left_s > 0)) return false;
  ContactProblem normals;
  normals.v = v;
  normals.N = Matrix(to_dense(contact_->N)(Eigen::all, hard));
  normals.D = Matrix(v.size(), 0);
  normals.edges.assign(hard.size(), 0);
  normals.mu = Vector::Zero(static_cast<Index>(hard.size()));
  normals.inertia = contact_->inertia;
  if (contact_->has_offset()) normals.b = contact_->b(hard);
  ActiveSet solver{ActiveSetSettings{}};
  solver.load(Problem("", std::move(normals)));
  Answer answer;
  solver.solve({.time_limit_s = left_s}, answer);
  if (answer.claim != Claim::kUnsolvable) return false;
  proof_.setZero(contact_->nc());
  proof_(hard) = static_cast<const Vector&>(answer.farkas);
  return true;
}

}  // namespace lcpbench
