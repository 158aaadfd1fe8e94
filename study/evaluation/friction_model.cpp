#include "study/evaluation/friction_model.h"

#include "study/evaluation/contact_evaluation.h"

namespace lcpbench {

FrictionModel friction_model(FrictionModel of_solver, const Problem& problem) {
  const ContactProblem* contact = problem.contact();
  return contact != nullptr && contact->frictional() ? of_solver : FrictionModel::kPyramid;
}

void measure_friction(FrictionModel model, const Problem& problem, const Answer& answer, Errors& errors) {
  const ContactProblem* contact = problem.contact();
  if (contact == nullptr || !errors.usable || !why_not({}, problem).empty()) return;
  model = friction_model(model, problem);
  if (model == FrictionModel::kPyramid) {
    if (contact->is_soft() && !contact->frictional()) {
      errors.optimum_distance = ContactEvaluation(*contact).optimum_distance(answer.z);
    }
    return;
  }
  const double least_violation = errors.least_violation_m_per_s;
  errors = ContactEvaluation(*contact).errors(answer, model);
  errors.least_violation_m_per_s = least_violation;
}

}  // namespace lcpbench
