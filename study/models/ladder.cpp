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
#include "study/evaluation/fastest_contact.h"
#include "study/evaluation/friction_model.h"

namespace lcpbench {
namespace {

/// Turning ends after so many passes, or if a pass from the third on does not reduce the error by this factor.
constexpr double kLeastGain = 2;
constexpr int kMostPasses = 8;
/// Largest velocity_residual_relative, by the round cone, at which an answer of the relaxed cone counts as kRest.
constexpr double kRests = 1e-8;

enum class SolvedBy { kNothing, kPyramid, kRelaxedCone, kCone };

struct Traits {
  const char* name;
  SolvedBy by;
  int edges = 0;           ///< of a pyramid
  bool is_turned = false;  ///< solved again with edges against the slip of the last pass
};

/// In the order of ContactModel.
constexpr std::array kTraits{Traits{"nothing", SolvedBy::kNothing},
                             Traits{"normals", SolvedBy::kPyramid},
                             Traits{"rest", SolvedBy::kRelaxedCone},
                             Traits{"4", SolvedBy::kPyramid, 4},
                             Traits{"4-turned", SolvedBy::kPyramid, 4, true},
                             Traits{"8", SolvedBy::kPyramid, 8},
                             Traits{"8-turned", SolvedBy::kPyramid, 8, true},
                             Traits{"16", SolvedBy::kPyramid, 16},
                             Traits{"16-turned", SolvedBy::kPyramid, 16, true},
                             Traits{"soft", SolvedBy::kRelaxedCone},
                             Traits{"relaxed", SolvedBy::kRelaxedCone},
                             Traits{"cone-rough", SolvedBy::kCone},
                             Traits{"cone", SolvedBy::kCone}};
static_assert(kTraits.size() == kContactModels.size());

const Traits& traits_of(ContactModel model) { return kTraits[static_cast<std::size_t>(model)]; }

/// Solves by a new solver.
TimedAnswer run(const Spec& spec, const Problem& problem, double time_limit_s) {
  const std::unique_ptr<Solver> solver = make_solver(spec);
  TimedAnswer timed;
  const TimedRequest request{.time_limit_s = time_limit_s, .repeat_until_s = kRepeatUntilS};
  timed_solve(*solver, problem, request, timed);
  return timed;
}

/// The contacts with compliances of at least M_nn error / (speed of the fastest contact) [1/kg]: an impulse that alone
/// changes the normal velocity by that speed then gives way by `error` [m/s].
ContactProblem softened(const ContactProblem& contacts, double error) {
  ContactProblem soft = contacts;
  soft.compliance_n = soft.compliance_t = Vector::Zero(contacts.nc());
  const double fastest = fastest_contact(contacts, contacts.v).m_per_s;
  Vector z = Vector::Zero(lcp_size(contacts));
  for (Index c = 0; c < contacts.nc(); ++c) {
    z(c) = 1;
    const Vector moved = post_impact_velocity(contacts, z) - contacts.v;
    const double diagonal = dot_column(contacts.N, c, moved);
    const double compliance = fastest > 0 ? error / fastest * diagonal : 0.0;
    soft.compliance_n(c) = std::max(contacts.normal_compliance(c), compliance);
    if (contacts.edges[static_cast<std::size_t>(c)] > 0) {
      soft.compliance_t(c) = std::max(contacts.tangential_compliance(c), compliance);
    }
    z(c) = 0;
  }
  return soft;
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

double Ladder::error_of(const Vector& z, double Errors::*measure) {
  Answer answer;
  answer.claim = Claim::kSolved;
  answer.z = z;
  Errors errors = evaluator_.errors(answer);
  measure_friction(FrictionModel::kCone, reference_, answer, errors);
  return errors.*measure;
}

/// Writes impulses, their velocity, and the residual of the round cone's conditions.
void Ladder::take(const TangentImpulses& impulses, ModelAnswer& to) {
  to.impulses = pyramid_impulses(contacts(), impulses);
  to.velocity = post_impact_velocity(contacts(), to.impulses);
  to.error_m_per_s = error_of(to.impulses, &Errors::velocity_residual_m_per_s);
}

void Ladder::solve_pyramid(int edges, const std::vector<double>& angles, ModelAnswer& to, TangentImpulses& impulses) {
  const Problem problem("pyramid", with_pyramid(contacts(), edges, angles));
  const TimedAnswer timed = run(solver_of(to.model, 0), problem, time_limit_s_);
  to.claim = timed.answer.claim;
  to.time_s = (to.passes == 0 ? 0.0 : to.time_s) + seconds(timed);
  ++to.passes;
  if (to.claim != Claim::kSolved) return;
  impulses = tangent_impulses(contacts(), edges, angles, timed.answer.z);
  take(impulses, to);
  to.solver_error_m_per_s = Evaluator(problem).errors(timed.answer).velocity_residual_m_per_s;
}

/// The pass with the smallest error, with the time and the number of all passes.
ModelAnswer Ladder::pyramid(ContactModel model, double error) {
  ModelAnswer best{.model = model};
  TangentImpulses impulses;
  std::vector<double> angles(static_cast<std::size_t>(contacts().nc()), 0.0);
  const Traits& traits = traits_of(model);
  solve_pyramid(traits.edges, angles, best, impulses);
  ModelAnswer last = best;
  while (traits.is_turned && last.answered() && !last.meets(error) && last.passes < kMostPasses) {
    angles = slip_angles(contacts(), impulses, last.velocity);
    ModelAnswer now{.model = model, .time_s = last.time_s, .passes = last.passes};
    solve_pyramid(traits.edges, angles, now, impulses);
    const bool gains = now.answered() && now.error_m_per_s * kLeastGain <= last.error_m_per_s;
    last = now;
    if (now.answered() && now.error_m_per_s < best.error_m_per_s) best = now;
    best.passes = now.passes;
    best.time_s = now.time_s;
    if (!gains && now.passes > 2) break;
  }
  return best;
}

ModelAnswer Ladder::by_cone(ContactModel model, double error) {
  ModelAnswer to{.model = model};
  const bool relaxed = traits_of(model).by == SolvedBy::kRelaxedCone;
  const Problem problem = model == ContactModel::kSoft ? Problem("soft", softened(contacts(), error)) : reference_;
  const TimedAnswer timed = run(solver_of(model, error), problem, time_limit_s_);
  to.claim = timed.answer.claim;
  to.time_s = seconds(timed);
  to.passes = 1;
  if (timed.answer.z.size() == 0 || !timed.answer.z.allFinite()) return to;
  if (to.claim != Claim::kSolved && to.claim != Claim::kIterationLimit && to.claim != Claim::kNumericalFailure) {
    return to;
  }
  const std::vector<double> not_turned(static_cast<std::size_t>(contacts().nc()), 0.0);
  take(tangent_impulses(contacts(), 4, not_turned, timed.answer.z), to);
  if (!relaxed) to.solver_error_m_per_s = to.error_m_per_s;
  if (relaxed && model != ContactModel::kRest) {
    Errors errors = Evaluator(problem).errors(timed.answer);
    measure_friction(friction_model(FrictionModel::kConvex, problem), problem, timed.answer, errors);
    to.solver_error_m_per_s = errors.velocity_residual_m_per_s;
  }
  if (model == ContactModel::kRest && !(error_of(to.impulses, &Errors::velocity_residual_relative) <= kRests)) {
    if (to.claim == Claim::kSolved) to.claim = Claim::kUnsolvable;
    to.impulses.resize(0);
    to.velocity.resize(0);
    to.error_m_per_s = ModelAnswer::kNone;
  }
  return to;
}

ModelAnswer Ladder::nothing() {
  ModelAnswer to{.model = ContactModel::kNothing,
                 .claim = Claim::kSolved,
                 .impulses = Vector::Zero(reference_.size()),
                 .velocity = contacts().v};
  to.error_m_per_s = error_of(to.impulses, &Errors::velocity_residual_m_per_s);
  to.solver_error_m_per_s = to.time_s = 0;
  return to;
}

ModelAnswer Ladder::climb(ContactModel model, double error) {
  switch (traits_of(model).by) {
    case SolvedBy::kNothing: return nothing();
    case SolvedBy::kPyramid: return pyramid(model, error);
    default: return by_cone(model, error);
  }
}

std::vector<LadderIsland> ladder_islands(const Problem& problem, const std::string& file, double time_limit_s) {
  if (problem.contact() == nullptr) throw InputError(fmt::format("{}: a bare LCP has no contacts to model", file));
  if (problem.contact()->has_rows()) {
    throw InputError(
        fmt::format("{}: field 'rows': models of friction are compared on contacts without bounded rows", file));
  }
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
  // kConeRough may err as much as the chosen model: the comparison is with kCone.
  if (!result.met || result.chosen.model == ContactModel::kCone) return result;
  result.next = ladder.climb(ContactModel::kCone, error);
  if (result.next.answered()) {
    result.change_m_per_s = fastest_contact(ladder.contacts(), result.chosen.velocity - result.next.velocity).m_per_s;
  }
  return result;
}

}  // namespace lcpbench
