#include "native/auto/island_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "core/timed_solve.h"
#include "native/proofs/doubtful_inertia.h"

namespace lcpbench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Residual at which iterative methods end where no error is stated. What one claims with a residual above kPoor times
/// that is an iterate as others are.
constexpr double kDefaultAim = 1e-9, kPoor = 100;

/// Of a unit of work of a dense method, about. A load() knows no time limit: one that is likely to take longer than
/// kLoadAtOnceS is left to solve(), and one that would outlast the deadline is not begun.
constexpr double kSecondsPerWork = 1e-10, kLoadAtOnceS = 0.05;

/// What the work of a turn grows by from one round to the next. All turns of a method before its last one then take a
/// third of that.
constexpr double kGrowth = 4;

/// Part of the time that is left, for the test of the best iterate.
constexpr double kTimeForTest = 0.05;

}  // namespace

IslandSolver::IslandSolver(Methods& shared, const std::shared_ptr<LaterEngines>& later, double error, bool is_whole)
    : error_(error), own_(later), shared_(shared), task_(is_whole) {
  task_.methods = &own_;
}

void IslandSolver::load(const Problem& problem, const Vector& v, const Load& how) {
  task_.load(problem, v);
  task_.methods = how.in_turn ? &shared_ : &own_;
  own_.begin(problem, task_.v, task_.is_whole);
  guess_.load(how.after_guess, rest_.rests());
  rest_.load();
  best_.resize(problem.size());
  if (guess_.waits()) return;
  choose();
  load_first();
}

void IslandSolver::update(const Vector& v) {
  task_.set_velocity(v);
  guess_.set_velocity();
  rest_.set_velocity();
  own_.set_velocity(task_.v);
  if (guess_.waits()) return;
  task_.methods = &own_;
  choose();
  load_first();
}

/// What comes first at the velocity now.
void IslandSolver::choose() {
  const ContactProblem& contact = task_.contact();
  task_.order.choose(*task_.problem, task_.idle, task_.aim_of(error_));
  // Only contact_lemke tells what has a solution from what has none.
  if (contact.frictional() && may_be_singular(contact)) task_.order.put_first(AutoMethod::kContactLemke);
  first_ = rest_.first();
  if (first_ == IslandRest::First::kInteriorPoint) task_.order.put_rest_first();
}

/// Of those that solve() needs first; into shared ones only the memory is taken.
void IslandSolver::load_first() {
  const Problem& problem = *task_.problem;
  if (task_.order.turns().empty()) return;
  if (first_ == IslandRest::First::kActiveSets) {
    if (task_.methods == &shared_) return shared_.reserve(AutoMethod::kContactLemke, problem, true);
    own_.loaded(AutoMethod::kContactLemke);  // it judges the impulses, and mostly has the first turn
    own_.loaded_least_energy();
    return;
  }
  const AutoMethod method = task_.order.turns().front().method;
  if (task_.methods == &shared_) return shared_.reserve(method, problem, false);
  if (Methods::load_work(method, problem, task_.idle) * kSecondsPerWork <= kLoadAtOnceS) own_.loaded(method);
}

void IslandSolver::solve(const Vector* start, const AutoLimits& limits, Answer& answer, AutoReport& report) {
  task_.begin(limits);
  rest_.begin();
  if (start != nullptr && start->size() != task_.problem->size()) start = nullptr;
  // The contacts of the last answer hold again.
  const bool guesses = start != nullptr && guess_.is_worth_it(*start);
  if (start != nullptr && rest_.still_rests(*start, guesses, answer, report)) {
    ++report.sticking;
    guess_.note(true);
    return;
  }
  if (guesses) {
    const bool was_right = guess_.solve(*start, answer, report) && rest_.accepts(answer);
    guess_.note(was_right);
    report.sticking += was_right ? 1 : 0;
    if (was_right) return;
  }
  // Rest, if it is likely; else the methods.
  if (task_.methods == &shared_) shared_.begin(*task_.problem, task_.v, task_.is_whole);
  if (guess_.waits()) choose();
  guess_.stop_waiting();
  const bool is_least_energy =
      first_ == IslandRest::First::kActiveSets && rest_.find_by_active_sets(start != nullptr, answer, report);
  if (!is_least_energy && !take_turns(start, answer, report)) return;
  if (answer.claim != Claim::kSolved) return;
  // An answer that moves, or nearly rests, gives way to rest.
  using From = IslandRest::From;
  rest_.improve(is_least_energy ? From::kLeastEnergy : is_iterate_ ? From::kIterate : From::kMethod, answer, report);
  if (rest_.rests()) guess_.note(true);
}

/// The methods take turns until one has an answer. A turn ends after a budget of work, never of time, so that the same
/// data give the same answer on every machine, unless the deadline ends the solve. In the next round those that have
/// not given up begin anew, with kGrowth times the work. With friction they begin from nothing: a start may lead to
/// another of several solutions, or mislead.
/// @returns whether the answer is one
bool IslandSolver::take_turns(const Vector* start, Answer& answer, AutoReport& report) {
  using Progress = IslandTask::Progress;
  const ContactProblem& contact = task_.contact();
  const double now_s = wall_clock_s(), deadline_s = now_s + (1 - kTimeForTest) * (task_.limits.deadline_s - now_s);
  const double error = task_.aim_of(task_.limits.error);
  // An iterate with such a residual is an answer, if all methods have had a turn and none has a better one.
  const double acceptable = error > 0 ? error : task_.largest_claimed();
  const Vector* const guess = contact.frictional() ? nullptr : start;
  bool seeks_proof = contact.frictional() && may_be_unsolvable(contact);  // without friction active_set proves it
  bool is_out_of_time = false, goes_on = true;
  answer.clear();  // what no method overwrites is not the last step's
  best_residual_ = kInfinity;
  is_iterate_ = false;
  for (double budget = 1; goes_on && !is_out_of_time; budget *= kGrowth) {
    goes_on = false;
    for (const auto& [method, work, price] : task_.order.turns()) {
      Progress& progress = task_.progress_of(method);
      if (progress == Progress::kEnded) continue;
      if (is_too_late_for(method, deadline_s)) {
        is_out_of_time = true;
        continue;
      }
      BudgetedSolver& solver = task_.methods->loaded(method);
      if (progress == Progress::kNone) report.count(method);
      const bool has_ended =
          solver.solve_within({.start = guess, .error = error, .work = budget * work, .deadline_s = deadline_s}, answer);
      progress = has_ended ? Progress::kEnded : Progress::kBegun;
      goes_on = goes_on || !has_ended;
      bool claims = has_ended && (answer.claim == Claim::kSolved || answer.claim == Claim::kUnsolvable);
      const bool may_be_poor = error == 0 && !Methods::is_dense(method) && answer.claim == Claim::kSolved;
      if (!claims || may_be_poor) claims = !(note_iterate(solver, method, answer) > kPoor * kDefaultAim) && claims;
      if (claims) {
        task_.answered_by = method;
        report.add(answer.counters, Methods::is_dense(method) ? std::string_view(answer.detail) : "");
        if (answer.velocity.size() > contact.ngc()) {  // of a rigid equivalent
          answer.velocity = Vector(answer.velocity.head(contact.ngc()));
        }
        return true;
      }
    }
    if (std::exchange(seeks_proof, false) && task_.disproves(answer)) return true;
    if (best_residual_ <= acceptable && task_.passes(best_, answer)) {
      is_iterate_ = error == 0 && best_residual_ > kPoor * kDefaultAim;
      break;
    }
  }
  report.add({}, "");
  if (answer.claim == Claim::kSolved || answer.claim == Claim::kUnsolvable) return true;
  take_best(is_out_of_time || !(wall_clock_s() < deadline_s) ? Claim::kTimeLimit : answer.claim, answer);
  return answer.claim == Claim::kSolved;
}

/// Whether nothing may begin any more: the deadline is over, or the load of a dense method would outlast it.
bool IslandSolver::is_too_late_for(AutoMethod method, double deadline_s) {
  const double work = task_.methods->has(method) ? 0 : Methods::load_work(method, *task_.problem, task_.idle);
  return !(wall_clock_s() + kSecondsPerWork * work < deadline_s);
}

/// Keeps the method's best iterate, if it is better than that of the others. @returns its residual
double IslandSolver::note_iterate(BudgetedSolver& solver, AutoMethod method, const Answer& answer) {
  const double residual = solver.residual(answer);
  if (residual < best_residual_) {
    best_residual_ = residual;
    best_ = answer.z;
    task_.answered_by = method;
  }
  return residual;
}

/// Hands out the best iterate: as the answer, if it passes the test of one.
void IslandSolver::take_best(Claim otherwise, Answer& answer) {
  if (best_residual_ <= std::max(task_.limits.error, kClaimedQuadResidual) && task_.passes(best_, answer)) return;
  answer.velocity.resize(0);
  answer.farkas.resize(0);
  answer.z.resize(task_.problem->size());
  answer.z.setZero();
  answer.claim = otherwise == Claim::kSolved ? Claim::kNumericalFailure : otherwise;
  if (!(best_residual_ < 1)) return;  // that of z = 0
  answer.z = best_;
  std::array<char, 64> text{};
  const int length = std::snprintf(text.data(), text.size(), "best residual %.2g", best_residual_);
  answer.detail.assign(text.data(), static_cast<std::size_t>(length));
}

}  // namespace lcpbench
