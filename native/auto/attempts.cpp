#include "native/auto/attempts.h"

#include <algorithm>

#include "native/active_set/active_set.h"
#include "native/answer_test/answer_test.h"
#include "native/auto/islands.h"
#include "native/contact_lemke/contact_lemke.h"
#include "native/sor/psor.h"

namespace lcpbench {
namespace {

/// Of the time that is left, for each try but the last.
constexpr double kShareOfTime = 0.6;

/// Whether the solver takes a problem of this size; else load() is refused, and update() must not be called.
bool takes(const Solver& solver, const Problem& problem) { return problem.size() <= solver.capabilities().max_size; }

/// Guesses which contacts hold, on large islands. On small ones those after the first hardly ever find it.
constexpr int kHeldTries = 3;

/// Of the impulses of least energy, relative to max|q|; less if a smaller error is stated. They are a solution to
/// rounding, or none.
constexpr double kLargestRestResidual = 1e-8;

/// A contact slips if its lambda is more than this part of max|N'v + b|.
constexpr double kSlipping = 1e-9;
/// Where one slips faster than that, over max|N'v + b|, rest is hardly ever a solution.
constexpr double kFastSlip = 2;

bool slips_slowly(const ContactProblem& contact, const Vector& v, const Vector& z) {
  double scale = 0;
  for (Index c = 0; c < contact.nc(); ++c) {
    scale = std::max(scale, std::abs(dot_column(contact.N, c, v) + contact.offset(c)));
  }
  const Index impulses = contact.nc() + cols(contact.D);
  if (z.size() == impulses) return false;
  const double fastest = z.tail(z.size() - impulses).maxCoeff();
  return fastest > kSlipping * scale && fastest <= kFastSlip * scale;
}

}  // namespace

SharedMethods::SharedMethods() : later_(std::make_shared<LaterEngines>()) {}

Solver& SharedMethods::of(AutoMethod method) {
  std::unique_ptr<Solver>& solver = solvers_[static_cast<std::size_t>(method)];
  if (solver == nullptr) solver = make_method(method, later_);
  return *solver;
}

Solver& SharedMethods::holding(AutoMethod method, const Problem& problem, const Vector& v) {
  Solver& solver = of(method);
  bool& holds = holds_[static_cast<std::size_t>(method)];
  if (holds) return solver;
  solver.load_finite(problem);
  holds = true;
  if (v != problem.contact()->v && takes(solver, problem)) solver.update(v);
  return solver;
}

void SharedMethods::reserve(AutoMethod method, const Problem& problem) {
  if (method == AutoMethod::kActiveSet) {
    static_cast<ActiveSet&>(of(method)).reserve(problem);
  } else {
    static_cast<ContactLemke&>(of(method)).reserve(problem);
  }
}

void Attempts::begin(const Problem& problem, const Vector& v) {
  problem_ = &problem;
  v_ = v;
  loaded_.fill(false);
  has_least_energy_ = false;
  has_held_ = false;
  friction_may_hold_ = friction_may_hold(*problem.contact(), true);
  is_put_off_ = waits_ = takes_turns_ = false;
}

void Attempts::load(const Problem& problem, const Vector& v, bool in_turn) {
  begin(problem, v);
  load_methods(in_turn);
}

void Attempts::load_to_hold(const Problem& problem, const Vector& v, bool in_turn) {
  begin(problem, v);
  if (!friction_may_hold(*problem.contact(), false)) return load_methods(in_turn);
  if (scope_ == Scope::kWhole && !friction_may_hold_ && steps_without_guess_ > 0) {
    --steps_without_guess_;
    return load_methods(in_turn);
  }
  waits_ = true;
  in_turn_ = in_turn;
}

void Attempts::load_methods(bool in_turn) {
  const Problem& problem = *problem_;
  const Vector& v = v_;
  waits_ = false;
  sweeps_ = worthwhile_sweeps(settings_, problem);
  plan_ = plan_for(settings_, problem, v, sweeps_, idle_);
  const AutoMethod first = plan_.front().method;
  takes_turns_ = in_turn && is_dense(first) && fits_in_advance(first, problem);
  if (!takes_turns_) load_own(first);
  reserve_what_follows();
}

bool Attempts::load_when_needed(const Problem& problem, const Vector& v) {
  begin(problem, v);
  sweeps_ = worthwhile_sweeps(settings_, problem);
  plan_ = plan_for(settings_, problem, v, sweeps_, idle_);
  is_put_off_ = true;
  bool can_wait = false;
  for (const AutoTry& next : plan_) {
    if (is_left_out(next)) continue;
    can_wait = is_dense(next.method) && fits_in_advance(next.method, problem);
    break;
  }
  if (!can_wait) {
    load(problem, v);
  } else {
    reserve_what_follows();
  }
  return can_wait;
}

/// Sparse methods that were put off. Not friction_ipm or psor in full: contact_lemke may take a hundred times as long.
bool Attempts::is_left_out(const AutoTry& now) const {
  if (!is_put_off_ || is_loaded(now.method)) return false;
  return now.method == AutoMethod::kVelocityIpm || (!is_dense(now.method) && now.brief);
}

void Attempts::load_own(AutoMethod method) {
  const auto index = static_cast<std::size_t>(method);
  if (own_[index] == nullptr) own_[index] = make_method(method, shared_.later_engines());
  if (method == AutoMethod::kContactLemke)
    static_cast<ContactLemke&>(*own_[index]).expect_one_island(scope_ == Scope::kWhole);
  own_[index]->load_finite(*problem_);
  loaded_[index] = true;
  if (v_ != problem_->contact()->v && takes(*own_[index], *problem_)) own_[index]->update(v_);
}

void Attempts::reserve_what_follows() {
  for (const AutoTry& next : plan_) {
    if (is_dense(next.method) && !is_loaded(next.method) && fits_in_advance(next.method, *problem_)) {
      shared_.reserve(next.method, *problem_);
    }
  }
  if (plan_.rest == AutoPlan::Rest::kNotSought || has_least_energy_) return;
  if (!takes_turns_ && least_energy_ == nullptr) least_energy_ = std::make_unique<LeastEnergy>();
  least_energy().reserve(*problem_->contact());
  if (plan_.rest == AutoPlan::Rest::kFirst && !takes_turns_) load_least_energy();
}

LeastEnergy& Attempts::least_energy() { return takes_turns_ ? shared_.least_energy() : *least_energy_; }

void Attempts::load_least_energy() {
  least_energy().load(*problem_->contact(), v_);
  has_least_energy_ = !takes_turns_;
}

void Attempts::update(const Vector& v) {
  if (waits_) return set_velocity(v);
  is_put_off_ = false;
  takes_turns_ = false;
  v_ = v;
  plan_ = plan_for(settings_, *problem_, v, sweeps_, idle_);
  set_velocity(v);
  const AutoMethod first = plan_.front().method;
  if (!is_loaded(first)) load_own(first);
  reserve_what_follows();
}

void Attempts::set_velocity(const Vector& v) {
  v_ = v;
  if (has_least_energy_) least_energy_->update(v_);
  if (has_held_) held_->set_velocity(v_);
  for (std::size_t k = 0; k < kAutoMethods; ++k) {
    if (loaded_[k] && takes(*own_[k], *problem_)) own_[k]->update(v_);
  }
}

/// A solver of this method that holds the problem.
Solver& Attempts::ready(AutoMethod method) {
  const bool is_shared = !is_loaded(method) && is_dense(method) && fits_in_advance(method, *problem_);
  if (is_shared) return shared_.holding(method, *problem_, v_);
  if (!is_loaded(method)) load_own(method);
  return own(method);
}

/// @returns whether that ends the solve.
bool Attempts::tried(const AutoTry& now, const SolveRequest& request, bool is_last, const AutoLimits& limits,
                     Answer& answer, AutoReport& report) {
  if (ends_at_limit(limits, *problem_, answer, report)) return true;
  answered_ = &ready(now.method);
  answered_by_ = now.method;
  const double time = std::max(limits.time(), 0.0);  // loading takes some
  run_try(now, *answered_, *problem_, {.start = request.start, .time_limit_s = is_last ? time : kShareOfTime * time},
          limits, answer, report);
  return !gave_up(answer.claim, limits, report);
}

/// Whether the start makes it likely that contacts hold.
bool Attempts::may_hold(const SolveRequest& request) const {
  return (friction_may_hold_ || waits_) && request.start != nullptr &&
         HeldContacts::held(*problem_->contact(), v_, *request.start);
}

/// Whether the contacts that pressed in the last step hold again.
bool Attempts::holds(const SolveRequest& request, const AutoLimits& limits, Answer& answer, AutoReport& report) {
  const double time = limits.time();
  if (!(time > 0) || limits.exhausted(report.counters())) return false;
  if (held_ == nullptr) held_ = std::make_unique<HeldContacts>(scope_ != Scope::kParts, scope_ == Scope::kWhole);
  if (!has_held_) held_->load(*problem_, v_);
  has_held_ = true;
  Counters work{.iterations = 0, .pivots = 0, .factorizations = 0};
  const bool found = held_->solve(*request.start, friction_may_hold_ ? kHeldTries : 1, limits.deadline_s, answer, work);
  report.add(work, "");
  if (!found) return false;
  answered_ = nullptr;
  answered_by_ = AutoMethod::kFrictionIpm;  // of which answers come with their velocity, too
  ++report.held;
  return true;
}

/// Whether the impulses of least energy are an answer: they are where one has no contact that slips.
bool Attempts::rests(const SolveRequest& request, const AutoLimits& limits, Answer& answer, AutoReport& report) {
  if (!(is_loaded(AutoMethod::kContactLemke) || fits_in_advance(AutoMethod::kContactLemke, *problem_))) return false;
  if (!(limits.time() > 0) || limits.exhausted(report.counters())) return false;
  if (!has_least_energy_) load_least_energy();
  Counters work{.pivots = limits.max_pivots > 0 ? limits.pivots(report.counters()) : 0};
  const bool found = least_energy().solve(request.start != nullptr, kShareOfTime * limits.time(), work.pivots);
  report.add(work, "");
  if (!found) return false;
  auto& judge = static_cast<ContactLemke&>(ready(AutoMethod::kContactLemke));
  const contact_lemke::Residual residual = judge.complete(least_energy().z().data());
  const double allowed = limits.error > 0 ? std::min(limits.error, kLargestRestResidual) : kLargestRestResidual;
  if (!(residual.velocity <= allowed && residual.certain <= kClaimedResidual)) return false;
  if (!judge.has_solution(limits.deadline_s)) return false;
  answer.clear();
  answer.claim = Claim::kSolved;
  answer.z = least_energy().z().view();
  answered_ = &judge;
  answered_by_ = AutoMethod::kContactLemke;
  ++report.least_energy;
  return true;
}

/// Whether looking for rest may be worth its cost, which is a small part of what contact_lemke's pivots took.
bool Attempts::may_have_missed_rest(const Answer& answer) const {
  if (plan_.rest != AutoPlan::Rest::kAfter || answered_by_ != AutoMethod::kContactLemke) return false;
  const ContactProblem& contact = *problem_->contact();
  const std::int64_t worth = std::max(contact.ngc() - idle_, cols(contact.D) / 4);
  return answer.claim == Claim::kSolved && answer.counters.pivots >= worth && slips_slowly(contact, v_, answer.z);
}

void Attempts::solve(const SolveRequest& request, const AutoLimits& limits, Answer& answer, AutoReport& report) {
  shared_.begin_solve();
  const bool held = may_hold(request);
  const bool found = held && holds(request, limits, answer, report);
  if (held && waits_) {
    wrong_guesses_ = found ? 0 : wrong_guesses_ + 1;
    steps_without_guess_ = wrong_guesses_;
  }
  if (found) return;
  if (waits_) load_methods(in_turn_);
  // An answer of active sets rests on few of the contacts that hold, and from it the guess would go wrong again. One of
  // friction_ipm rests on all of them.
  if (held && friction_may_hold_ && plan_.rest == AutoPlan::Rest::kFirst &&
      tried({AutoMethod::kFrictionIpm, true}, {}, false, limits, answer, report)) {
    return;
  }
  if (plan_.rest == AutoPlan::Rest::kFirst && rests(request, limits, answer, report)) return;
  SolveRequest now_request = request;
  for (const AutoTry& next : plan_) {
    if (is_left_out(next)) continue;
    if (tried(next, now_request, &next + 1 == plan_.end(), limits, answer, report)) {
      if (may_have_missed_rest(answer)) rests({}, limits, answer, report);
      return;
    }
    now_request.start = nullptr;  // it may have been what misled the method
  }
}

void Attempts::respond(const Answer& answer, Vector& u) {
  if (answered_by_ == AutoMethod::kContactLemke) {
    static_cast<ContactLemke&>(*answered_).respond(answer.z, u);
  } else if (answered_by_ == AutoMethod::kPsor) {
    static_cast<LimitedPsor&>(*answered_).respond(answer.z, u);
  } else {
    ContactProblem moving = *problem_->contact();
    moving.v = v_;
    u = post_impact_velocity(moving, answer.z);
  }
}

}  // namespace lcpbench
