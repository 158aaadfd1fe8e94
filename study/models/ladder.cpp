#include "study/models/ladder.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "core/error.h"
#include "core/islands.h"
#include "core/registry.h"
#include "core/round_cone.h"
#include "core/selection.h"
#include "core/timed_solve.h"
#include "study/evaluation/friction_model.h"

namespace lcpbench {
namespace {

constexpr double kShortSolveS = 0.01;
constexpr double kRepeatUntilS = 2e-4;

enum class SolvedBy { kNothing, kPyramid, kRelaxedCone, kCone };

struct Traits {
  const char* name;
  SolvedBy by;
  int edges = 0;  ///< of a pyramid
};

/// In the order of ContactModel.
constexpr std::array kTraits{Traits{"nothing", SolvedBy::kNothing},
                             Traits{"normals", SolvedBy::kPyramid},
                             Traits{"4", SolvedBy::kPyramid, 4},
                             Traits{"8", SolvedBy::kPyramid, 8},
                             Traits{"16", SolvedBy::kPyramid, 16},
                             Traits{"relaxed", SolvedBy::kRelaxedCone},
                             Traits{"cone-rough", SolvedBy::kCone},
                             Traits{"cone", SolvedBy::kCone}};
static_assert(kTraits.size() == kContactModels.size());

const Traits& traits_of(ContactModel model) { return kTraits[static_cast<std::size_t>(model)]; }

/// Solves by a new solver. If load and solve take less than kShortSolveS, a second run replaces the first.
TimedAnswer run(const Spec& spec, const Problem& problem, double time_limit_s) {
  const std::unique_ptr<Solver> solver = make_solver(spec);
  TimedAnswer timed;
  const TimedRequest request{.time_limit_s = time_limit_s, .repeat_until_s = kRepeatUntilS};
  timed_solve(*solver, problem, request, timed);
  if (timed.times.setup_wall_s + timed.times.solve_wall_s < kShortSolveS) {
    timed_solve(*solver, problem, request, timed);
  }
  return timed;
}

double seconds(const TimedAnswer& timed) { return timed.times.setup_cpu_s + timed.times.solve_cpu_s; }

}  // namespace

const char* to_string(ContactModel model) { return traits_of(model).name; }

Spec solver_of(ContactModel model, double error) {
  const SolvedBy by = traits_of(model).by;
  if (by != SolvedBy::kRelaxedCone && by != SolvedBy::kCone) return {"auto", {}};
  Spec spec{"cone_ipm", {{"cone", "true"}}};
  if (by == SolvedBy::kRelaxedCone) spec.options.emplace_back("slip", "none");
  if (model == ContactModel::kConeRough && std::isfinite(error)) {
    spec.options.emplace_back("error", fmt::format("{}", error));
  }
  return spec;
}

Ladder::Ladder(ContactProblem tangents, double time_limit_s)
    : reference_("island", std::move(tangents)), time_limit_s_(time_limit_s), evaluator_(reference_) {}

double Ladder::error_of(const Vector& z) {
  Answer answer;
  answer.claim = Claim::kSolved;
  answer.z = z;
  Errors errors = evaluator_.errors(answer);
  measure_friction(FrictionModel::kCone, reference_, answer, errors);
  return errors.velocity_residual_m_per_s;
}

/// Writes impulses, their velocity, and the residual of the round cone's conditions.
void Ladder::take(const TangentImpulses& impulses, ModelAnswer& to) {
  to.impulses = pyramid_impulses(contacts(), impulses);
  to.velocity = post_impact_velocity(contacts(), to.impulses);
  to.error_m_per_s = error_of(to.impulses);
}

ModelAnswer Ladder::pyramid(ContactModel model) {
  ModelAnswer to{.model = model};
  const int edges = traits_of(model).edges;
  const Problem problem("pyramid", with_pyramid(contacts(), edges));
  const TimedAnswer timed = run(solver_of(model, 0), problem, time_limit_s_);
  to.claim = timed.answer.claim;
  to.time_s = seconds(timed);
  if (to.claim != Claim::kSolved) return to;
  take(tangent_impulses(contacts(), edges, timed.answer.z), to);
  to.solver_error_m_per_s = Evaluator(problem).errors(timed.answer).velocity_residual_m_per_s;
  return to;
}

ModelAnswer Ladder::by_cone(ContactModel model, double error) {
  ModelAnswer to{.model = model};
  const TimedAnswer timed = run(solver_of(model, error), reference_, time_limit_s_);
  to.claim = timed.answer.claim;
  to.time_s = seconds(timed);
  if (timed.answer.z.size() == 0 || !timed.answer.z.allFinite()) return to;
  if (to.claim != Claim::kSolved && to.claim != Claim::kIterationLimit && to.claim != Claim::kNumericalFailure) {
    return to;
  }
  take(tangent_impulses(contacts(), 4, timed.answer.z), to);
  to.solver_error_m_per_s = to.error_m_per_s;
  if (traits_of(model).by == SolvedBy::kRelaxedCone) {
    Errors errors = evaluator_.errors(timed.answer);
    measure_friction(friction_model(FrictionModel::kConvex, reference_), reference_, timed.answer, errors);
    to.solver_error_m_per_s = errors.velocity_residual_m_per_s;
  }
  return to;
}

ModelAnswer Ladder::nothing() {
  ModelAnswer to{.model = ContactModel::kNothing,
                 .claim = Claim::kSolved,
                 .impulses = Vector::Zero(reference_.size()),
                 .velocity = contacts().v};
  to.error_m_per_s = error_of(to.impulses);
  to.solver_error_m_per_s = to.time_s = 0;
  return to;
}

ModelAnswer Ladder::climb(ContactModel model, double error) {
  switch (traits_of(model).by) {
    case SolvedBy::kNothing: return nothing();
    case SolvedBy::kPyramid: return pyramid(model);
    default: return by_cone(model, error);
  }
}

std::vector<LadderIsland> ladder_islands(const Problem& problem, const std::string& file, double time_limit_s) {
  if (problem.contact() == nullptr) throw InputError(fmt::format("{}: a bare LCP has no contacts to model", file));
  if (const std::string why = why_no_round_cone(*problem.contact()); !why.empty()) {
    throw InputError(fmt::format("{}: field 'D': the friction names no round cone: {}", file, why));
  }
  const ContactProblem tangents = with_tangents(*problem.contact());
  std::vector<LadderIsland> islands;
  for (Island& island : find_islands(tangents)) {
    ContactProblem contacts = select_coordinates(select_contacts(tangents, island.contacts), island.coordinates);
    auto ladder = std::make_unique<Ladder>(std::move(contacts), time_limit_s);
    islands.push_back({std::move(island.contacts), std::move(island.coordinates), std::move(ladder)});
  }
  return islands;
}

Climb climb(Ladder& ladder, double error) {
  Climb result;
  for (const ContactModel model : kClimbed) {
    ModelAnswer now = ladder.climb(model, error);
    result.spent_s += now.time_s;
    result.met = now.meets(error);
    const bool better = now.answered() && !(result.chosen.error_m_per_s <= now.error_m_per_s);
    if (result.met || better || !result.chosen.answered()) result.chosen = std::move(now);
    if (result.met) break;
  }
  return result;
}

}  // namespace lcpbench
