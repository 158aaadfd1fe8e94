#include "native/auto/attempts.h"

#include <algorithm>
#include <variant>

#include "native/active_set/active_set.h"
#include "native/contact_lemke/contact_lemke.h"
#include "native/contacts/block_inverse.h"

namespace lcpbench {
namespace {

/// Of the time that is left, for each try but the last.
constexpr double kShareOfTime = 0.6;

/// Whether the solver takes a problem of this size; else load() is refused, and update() must not be called.
bool takes(const Solver& solver, const Problem& problem) { return problem.size() <= solver.capabilities().max_size; }

}  // namespace

SharedMethods::SharedMethods() : later_(std::make_shared<LaterEngines>()) {}

Solver& SharedMethods::of(AutoMethod method) {
  std::unique_ptr<Solver>& solver = solvers_[static_cast<std::size_t>(method)];
  if (solver == nullptr) solver = make_method(method, later_);
  return *solver;
}

void SharedMethods::reserve(AutoMethod method, const Problem& problem) {
  if (method == AutoMethod::kActiveSet) {
    static_cast<ActiveSet&>(of(method)).reserve(problem);
  } else {
    static_cast<ContactLemke&>(of(method)).reserve(problem);
  }
}

void Attempts::load(const Problem& problem, const Vector& v) {
  problem_ = &problem;
  v_ = v;
  loaded_.fill(false);
  is_put_off_ = false;
  sweeps_ = worthwhile_sweeps(settings_, problem);
  plan_ = plan_for(settings_, problem, v, sweeps_);
  load_own(plan_.front().method);
  reserve_what_follows();
}

bool Attempts::load_when_needed(const Problem& problem, const Vector& v) {
  problem_ = &problem;
  v_ = v;
  loaded_.fill(false);
  sweeps_ = worthwhile_sweeps(settings_, problem);
  plan_ = plan_for(settings_, problem, v, sweeps_);
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
  own_[index]->load(*problem_);
  loaded_[index] = true;
  if (v_ != problem_->contact()->v && takes(*own_[index], *problem_)) own_[index]->update(v_);
}

void Attempts::reserve_what_follows() {
  for (const AutoTry& next : plan_) {
    if (is_dense(next.method) && !is_loaded(next.method) && fits_in_advance(next.method, *problem_)) {
      shared_.reserve(next.method, *problem_);
    }
  }
}

void Attempts::update(const Vector& v) {
  is_put_off_ = false;
  v_ = v;
  plan_ = plan_for(settings_, *problem_, v, sweeps_);
  set_velocity(v);
  const AutoMethod first = plan_.front().method;
  if (!is_loaded(first)) load_own(first);
  reserve_what_follows();
}

void Attempts::set_velocity(const Vector& v) {
  v_ = v;
  for (std::size_t k = 0; k < kAutoMethods; ++k) {
    if (loaded_[k] && takes(*own_[k], *problem_)) own_[k]->update(v_);
  }
}

/// A solver of this method that holds the problem.
Solver& Attempts::ready(AutoMethod method) {
  if (!is_loaded(method) && is_dense(method) && fits_in_advance(method, *problem_)) {
    Solver& solver = shared_.of(method);
    solver.load(*problem_);
    if (takes(solver, *problem_)) solver.update(v_);
    return solver;
  }
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

void Attempts::solve(const SolveRequest& request, const AutoLimits& limits, Answer& answer, AutoReport& report) {
  SolveRequest now_request = request;
  for (const AutoTry& next : plan_) {
    if (is_left_out(next)) continue;
    if (tried(next, now_request, &next + 1 == plan_.end(), limits, answer, report)) return;
    now_request.start = nullptr;  // it may have been what misled the method
  }
}

void Attempts::respond(const Answer& answer, Vector& u) {
  if (answered_by_ == AutoMethod::kContactLemke) {
    static_cast<ContactLemke&>(*answered_).respond(answer.z, u);
  } else {
    const ContactProblem& contact = *problem_->contact();
    Vector impulse = Vector::Zero(v_.size());
    std::visit([&](const auto& N) { impulse += N * answer.z.head(N.cols()); }, contact.N);
    std::visit([&](const auto& D) { impulse += D * answer.z.segment(contact.nc(), D.cols()); }, contact.D);
    u = v_;
    BlockInverse(contact.inertia).add_product(impulse, u);
  }
}

}  // namespace lcpbench
