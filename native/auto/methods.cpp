#include "native/auto/methods.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <variant>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/active_set/active_set.h"
#include "native/answer_test/answer_test.h"
#include "native/answer_test/contact_solvability.h"
#include "native/contact_lemke/contact_lemke.h"
#include "native/friction_ipm/friction_ipm.h"
#include "native/sor/psor.h"

namespace lcpbench {

SolverDefinition lcpbench_solver_velocity_ipm();

namespace {

/// Of a brief try of contact_lemke, per contact and at least: three times what most of the collected steps take.
constexpr std::int64_t kPivotsPerContact = 15;
constexpr std::int64_t kFewestPivots = 50;
/// A second path mostly takes longer than friction_ipm, which follows.
constexpr std::int64_t kBriefRungs = 1;

/// Of a brief try of friction_ipm.
constexpr double kBriefResidual = 1e-8;

void limit_lemke(ContactLemke& lemke, const AutoTry& now, const Problem& problem, const AutoLimits& limits,
                 const Counters& done) {
  std::int64_t pivots = limits.max_pivots > 0 ? limits.pivots(done) : 0;
  if (now.brief) {
    const std::int64_t own = kFewestPivots + kPivotsPerContact * problem.contact()->nc();
    pivots = pivots > 0 ? std::min(pivots, own) : own;
  }
  lemke.limit_pivots(pivots);
  lemke.limit_rungs(now.brief ? kBriefRungs : 0);
  const double accepted = ContactLemkeSettings{}.accept_residual;
  lemke.accept(limits.error > 0 ? std::min(limits.error, accepted) : accepted);
}

/// Where another method may reach the stated error, an answer that does not is none. A brief try comes before those.
void refuse_above_error(ContactLemke& lemke, const AutoLimits& limits, Answer& answer) {
  if (!(limits.error > 0 && answer.claim == Claim::kSolved)) return;
  if (lemke.complete(answer.z.data()).velocity <= limits.error) return;
  answer.claim = Claim::kNumericalFailure;
}

/// The stated error, as far as AnswerTest allows it: that of contacts whose inertia is not given by blocks, or that
/// need not have a solution, is that of the verdict.
double aim_of(const AutoLimits& limits, const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  const bool is_judged_by_bodies =
      std::holds_alternative<BlockInertia>(contact.inertia) && !ContactSolvability::is_asked(contact);
  return is_judged_by_bodies ? limits.error : std::min(limits.error, kClaimedResidual);
}

void limit_friction_ipm(LimitedFrictionIpm& ipm, const AutoTry& now, const Problem& problem, const AutoLimits& limits) {
  ipm.unlimit_rounds();
  if (now.brief) ipm.limit_rounds(now.rounds, kBriefResidual);
  if (limits.error > 0) ipm.aim_at(aim_of(limits, problem));
}

void limit_psor(LimitedPsor& psor, const AutoTry& now, const Problem& problem, const AutoLimits& limits) {
  psor.take_parts(now.exact);
  psor.unlimit_sweeps();
  if (now.brief) psor.limit_sweeps(now.sweeps, kSweptResidual);
  if (limits.error > 0) psor.aim_at(aim_of(limits, problem));
}

}  // namespace

double AutoLimits::time() const { return std::isinf(deadline_s) ? deadline_s : deadline_s - wall_clock_s(); }

std::unique_ptr<Solver> make_method(AutoMethod method, const std::shared_ptr<LaterEngines>& later) {
  switch (method) {
    case AutoMethod::kContactLemke: return std::make_unique<ContactLemke>(ContactLemkeSettings{}, later);
    case AutoMethod::kVelocityIpm: return lcpbench_solver_velocity_ipm().make({});
    case AutoMethod::kFrictionIpm: return make_friction_ipm();
    case AutoMethod::kPsor: return make_limited_psor();
    default: return std::make_unique<ActiveSet>(ActiveSetSettings{});
  }
}

bool ends_at_limit(const AutoLimits& limits, const Problem& problem, Answer& answer, const AutoReport& report) {
  const bool in_time = limits.time() > 0;
  if (in_time && !limits.exhausted(report.counters())) return false;
  answer.claim = in_time ? Claim::kIterationLimit : Claim::kTimeLimit;
  answer.z.resize(problem.size());
  answer.z.setZero();
  answer.detail.clear();
  answer.velocity.resize(0);
  return true;
}

void run_try(const AutoTry& now, Solver& solver, const Problem& problem, const SolveRequest& request,
             const AutoLimits& limits, Answer& answer, AutoReport& report) {
  report.count(now.method);
  switch (now.method) {
    case AutoMethod::kActiveSet:
      static_cast<ActiveSet&>(solver).limit_iterations(limits.max_pivots > 0 ? limits.pivots(report.counters()) : 0);
      break;
    case AutoMethod::kContactLemke:
      limit_lemke(static_cast<ContactLemke&>(solver), now, problem, limits, report.counters());
      break;
    case AutoMethod::kFrictionIpm:
      limit_friction_ipm(static_cast<LimitedFrictionIpm&>(solver), now, problem, limits);
      break;
    case AutoMethod::kPsor: limit_psor(static_cast<LimitedPsor&>(solver), now, problem, limits); break;
    default: break;
  }
  solver.solve(request, answer);
  if (now.method == AutoMethod::kContactLemke && now.brief) {
    refuse_above_error(static_cast<ContactLemke&>(solver), limits, answer);
  }
  const bool tells_rung = is_dense(now.method) && !(now.brief && answer.claim != Claim::kSolved);
  report.add(answer.counters, tells_rung ? std::string_view(answer.detail) : std::string_view());
}

bool gave_up(Claim claim, const AutoLimits& limits, const AutoReport& report) {
  switch (claim) {
    case Claim::kNumericalFailure:
    case Claim::kUnsupported: return true;
    case Claim::kIterationLimit: return !limits.exhausted(report.counters());
    case Claim::kTimeLimit: return limits.time() > 0;
    default: return false;
  }
}

}  // namespace lcpbench
