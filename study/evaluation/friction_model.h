#pragma once

#include "core/friction_model.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench {

/// The model by which a solver's answer to a problem is measured: that of the solver, or the pyramid if the problem has
/// no friction. The view `judged` of a store has the same rule.
FrictionModel friction_model(FrictionModel of_solver, const Problem& problem);

/// Measures the errors of an answer by the conditions of another model of friction, the round Coulomb cone [Alart,
/// Curnier 1991] or Anitescu's convex relaxation [2006]; docs/explanation/verdicts.md has their residuals. The new
/// measures replace those of the pyramid. A problem without friction, and an answer that is not usable, keep their
/// measures, and so does the model kPyramid. Soft contacts without friction get optimum_distance, whatever the model,
/// and so does every answer to kConvex.
///
/// The worst row is the cone row of the contact: its z is |u_t|, its w is mu f_N - |f_t|. natural_residual,
/// complementarity_j and forward_velocity are NaN. Where why_no_cone() has a reason, the answer is not measured:
/// Errors::unresolved. The model's error is always that of the round Coulomb cone.
void measure_friction(FrictionModel model, const Problem& problem, const Answer& answer, Errors& errors);

}  // namespace lcpbench
