#pragma once

#include "core/contact_problem.h"

namespace lcpbench {

/// Looks for a proof that contacts, also with friction, have no solution.
///
/// Impulses change the velocity within the range of X only (G = X diag(alpha) X'; X = G* where that is given, I where G
/// is). So there is no solution if some u >= 0, zero for contacts with compliance, has X'N u = 0 and (N'v + b)'u < 0:
/// no impulse changes (N'v+ + b)'u. Without friction there is either a solution or such a u. [Farkas 1902] ActiveSet
/// looks for it among the normals alone; what double does not decide, Lemke's method in 113 bits does, by the ray on
/// which its path ends.
class ContactFarkas {
 public:
  /// @param contact  kept by reference: only its v may change until the next load()
  void load(const ContactProblem& contact) { contact_ = &contact; }

  /// Whether a proof is found. Cost: a solve by ActiveSet, rarely one in 113 bits. Allocates. @pre load()
  /// @param v  velocity before the impact (ngc), in place of the v of load()
  /// @param deadline_s  on wall_clock_s(): false after it. The proof in 113 bits is not interrupted.
  bool proves_unsolvable(const Vector& v, double deadline_s);

  /// The u (nc) of the last proof, up to a factor, rounded to doubles. @pre proves_unsolvable() was true
  const Vector& proof() const { return proof_; }

 private:
  const ContactProblem* contact_ = nullptr;
  Vector proof_;
};

}  // namespace lcpbench
