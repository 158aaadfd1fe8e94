#pragma once

#include "core/friction_model.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench {

/// The model by which a solver's answer to a problem is measured: that of the solver, or the pyramid if the problem has
/// no friction. The view `judged` of a store has the same rule.
FrictionModel friction_model(FrictionModel of_solver, const Problem& problem);

/// Measures the errors of an answer by the conditions of another model of friction. The new measures replace those of
/// the pyramid. A problem without friction, and an answer that is not usable, keep their measures, and so does the
/// model kPyramid. Soft contacts without friction get optimum_distance, whatever the model.
///
/// kCone, the round Coulomb cone. A contact without friction keeps its row. The tangents of a contact with friction are
/// the directions 0 and edges / 4 of its regular polygon. Let f_t be its friction impulse, u_t the velocity v+ along
/// the tangents, w_t = u_t + offset + compliance f_t, M_tt the larger of the two diagonal entries of M, and P the
/// nearest point of the disc of radius mu M_tt max(f_N, 0). The contact has two residuals [m/s]:
///
///     | min(M_nn f_N, w_N) |    and    | M_tt f_t - P(M_tt f_t - w_t) |
///
/// The second is zero exactly if |f_t| <= mu f_N, and w_t is zero, or f_t is opposite to w_t and |f_t| = mu f_N [Alart,
/// Curnier 1991]. rho and the rule of `solved` are those of the pyramid. The worst row is the cone row of the contact:
/// its z is |u_t|, its w is mu f_N - |f_t|. The model's error is the residual itself. natural_residual,
/// complementarity_j and forward_velocity are NaN. Where why_no_cone() has a reason, the answer is not
/// measured: Errors::unresolved.
///
/// kConvex, Anitescu's convex relaxation [2006]. Its answer has the least 1/2 |v+ - v|_G^2 + 1/2 f'R f, R the
/// compliances. A contact with friction has one residual, m | f - P(f - w / m) |. P is the nearest point of the cone
/// |f_t| <= mu f_N, w the relative velocity with offsets and compliance, m the larger of M_nn and M_tt. The
/// residual is zero exactly if f is in the cone, w_N >= mu |w_t| and f'w = 0. The model's error stays that of the round
/// Coulomb cone. The answer gets optimum_distance.
void measure_friction(FrictionModel model, const Problem& problem, const Answer& answer, Errors& errors);

}  // namespace lcpbench
