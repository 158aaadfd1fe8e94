#pragma once

#include "core/friction_model.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench {

/// The model of a solver's answers to a problem: the pyramid where the problem has no friction. The view `judged` of a
/// store has the same rule.
FrictionModel friction_model(FrictionModel of_solver, const Problem& problem);

/// Replaces the measures of an answer's errors that are about the pyramid by those of another model of friction. No
/// change for the pyramid, but that optimum_distance is found where soft contacts have no friction.
///
/// Of the round Coulomb cone: A contact
/// without friction keeps its row. With friction, f_t and u_t are its friction impulse and the velocity v+ along the
/// tangents, which are the directions 0 and edges / 4 of its regular polygon; M_tt is the larger of their diagonal
/// entries. The two rows of a contact are
///
///     | min(M_nn f_N, w_N) |    and    | M_tt f_t - P(M_tt f_t - u_t) |,    [m/s]
///
/// P the nearest point of the disc of radius mu M_tt max(f_N, 0). Both are zero exactly where the contact pushes,
/// separates or neither, |f_t| <= mu f_N, and f_t is opposite to a slip and then at its limit [Alart, Curnier 1991].
/// rho and the rule of `solved` are those of the pyramid. The worst row is the contact's cone row: z is |u_t|, w is mu
/// f_N - |f_t|. The model's error is the answer's own residual. Natural residual, complementarity and forward error do not
/// apply. No change where the problem has no friction, or the answer is not usable. Friction
/// directions that name no cone (edges no multiple of 4) leave the answer without a measure.
///
/// Of the convex model [Anitescu 2006], whose answer has the least 1/2 |v+ - v|_G^2 + 1/2 f'R f, R the compliances: a
/// contact with friction has one row, m | f - P(f - w / m) |, P the nearest point of the cone |f_t| <= mu f_N, w the
/// velocity at the contact with offsets and compliance, m the larger of M_nn and M_tt. It is zero exactly where f is in
/// the cone, w_N >= mu |w_t| and f'w = 0. The model's error stays that of the round Coulomb cone, and optimum_distance
/// is found.
void measure_friction(FrictionModel model, const Problem& problem, const Answer& answer, Errors& errors);

/// measure_friction() of the round Coulomb cone.
inline void measure_cone(const Problem& problem, const Answer& answer, Errors& errors) {
  measure_friction(FrictionModel::kCone, problem, answer, errors);
}

}  // namespace lcpbench
