#pragma once

#include <optional>

#include "core/answer/contact_residual.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench {

/// Measures the answers to one contact problem: the part of an Evaluator that needs v, N, D, mu and G, which an LCP's q
/// and M do not show.
class ContactEvaluation {
 public:
  /// @param contact  finite, must outlive this object
  explicit ContactEvaluation(const ContactProblem& contact) : contact_(contact) {}

  /// @param answer  usable @param model  by whose conditions: see measure_friction()
  Errors errors(const Answer& answer, FrictionModel model);
  /// Of a z that is finite and of the right length; NaN where it cannot be known.
  double forward_velocity(const Vector& z) const;
  void set_certified_velocity(const Vector& v_star) { v_star_ = numbers(v_star); }
  bool proven_positive_definite() const { return contact_.inertia.proven_positive_definite(); }
  /// See Errors::optimum_distance. @pre contact_.lcp, why_no_round_cone() is ""
  double optimum_distance(const Vector& z);

 private:
  bool measure(const Answer& answer, FrictionModel model, Errors& errors);
  WorstRow describe(const ContactResidual::Worst& worst, FrictionModel model,
                    const ContactResidual::Point& point);
  double work_gain(const ContactResidual::Point& point) const;
  double forward_velocity(const QuadVector& velocity) const;

  ContactResidual contact_;
  std::optional<QuadVector> v_star_;
};

}  // namespace lcpbench
