#pragma once

#include <vector>

#include "core/contact_problem.h"
#include "core/solver.h"

namespace lcpbench {

/// The largest velocity residual, relative to the scale of the island (ContactScale), of contacts that solvers claim as
/// solved: half of what the evaluation allows, which leaves room for the rounding of a test in double.
inline constexpr double kClaimedResidual = 5e-5;

/// With singular inertia no answer is claimed as solved that leaves more, relative to the scale: the problem may miss a
/// solution by that little.
inline constexpr double kSureResidual = 1e-9;

/// Whether the inertia is given in a form that may be singular: by factors or as G*.
bool may_be_singular(const ContactProblem& contact);

/// Whether ContactFarkas may find a proof that there is no solution: some contact has no compliance, and the inertia
/// may be singular or an offset b is negative. Without such a proof tangential offsets, too, may leave no solution.
bool may_be_unsolvable(const ContactProblem& contact);

/// The test of answers to contacts on inertia that double does not prove to be what the solvers and their tests
/// factored: factors that may be dependent, a given G* of coordinates far apart in scale.
/// It shares no factorization with them.
class DoubtfulInertia {
 public:
  /// load() then allocates nothing for this problem.
  void reserve(const ContactProblem& contact);
  void load(const ContactProblem& contact);

  bool is_doubtful() const { return is_doubtful_; }

  /// Whether the inertia may be singular for all that is known of it: factors that are fewer than the coordinates or in
  /// doubt, and any given G*.
  bool may_be_singular() const { return may_be_singular_; }

  /// Whether the answer's residual by ContactResidual, in 113 bits, is within what solvers claim; its velocity, where
  /// it has one, is then that of its impulses. False where 113 bits do not tell the rank, and above 200 coordinates. No
  /// doubt: true, at no cost.
  /// @param contact  as loaded @param v  before the impact
  bool confirms(const ContactProblem& contact, const Eigen::Ref<const Vector>& v, Answer& answer) {
    return !is_doubtful_ || confirms_in_quad(contact, v, answer);
  }

 private:
  bool confirms_in_quad(const ContactProblem& contact, const Eigen::Ref<const Vector>& v, Answer& answer);

  bool is_doubtful_ = false;
  bool may_be_singular_ = false;
  std::vector<double> work_;
};

}  // namespace lcpbench
