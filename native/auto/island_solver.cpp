#include "native/auto/island_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>
#include <variant>

#include "core/timed_solve.h"
#include "native/contacts/contact_impulses.h"
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

/// Of the slip ratio, see slip_ratio(): friction may hold every contact up to 1. From this one on it did so on a quarter
/// of the steps.
constexpr double kStickingByFriction = 0.5;

/// What the work of a turn grows by from one round to the next. All turns of a method before its last one then take a
/// third of that.
constexpr double kGrowth = 4;

/// Part of the time that is left, for the test of the best iterate.
constexpr double kTimeForTest = 0.05;

std::size_t index(AutoMethod method) { return static_cast<std::size_t>(method); }

/// The fastest slip at velocity v, over the largest mu times the fastest approach: friction may hold every contact
/// where that is at most 1. Offsets count as approach. O(nonzeros)
double slip_ratio(const ContactProblem& contact, const Vector& v) {
  double slip = 0, approach = 0;
  Index direction = 0;
  for (const int edges : contact.edges) {  // the other half of the directions is opposite
    for (Index t = 0; t < edges / 2; ++t) slip = std::max(slip, std::abs(dot_column(contact.D, direction + t, v)));
    direction += edges;
  }
  for (Index c = 0; c < contact.nc(); ++c) {
    approach = max_or_infinity(approach, -(dot_column(contact.N, c, v) + contact.offset(c)));
  }
  return slip > 0 ? slip / (contact.mu.maxCoeff() * approach) : 0;
}

}  // namespace

IslandSolver::IslandSolver(Methods& shared, const std::shared_ptr<LaterEngines>& later, double error, bool is_whole)
    : error_(error), is_whole_(is_whole), own_(later), shared_(shared), methods_(&own_) {}

void IslandSolver::load(const Problem& problem, const Vector& v, const Load& how) {
  problem_ = &problem;
  v_ = v;
  methods_ = how.in_turn ? &shared_ : &own_;
  has_sticking_ = has_test_ = has_rest_ = false;
  own_.begin(problem, v_, is_whole_);
  if (Rest::takes(*problem.contact())) rest_.reserve(problem.contact()->ngc());
  best_.resize(problem.size());
  waits_ = how.after_guess && (rested_ || StickingContacts::is_worth_a_guess(*problem.contact(), false));
  pauses_ = how.after_guess && steps_without_guess_ > 0;
  if (pauses_) --steps_without_guess_;
  waits_ = waits_ && !pauses_;
  if (waits_) return;
  choose();
  load_first();
}

/// What comes first at the velocity now.
void IslandSolver::choose() {
  const ContactProblem& contact = *problem_->contact();
  order_.choose(*problem_, idle_, aim_of(error_));
  // Only contact_lemke tells what has a solution from what has none.
  if (contact.frictional() && may_be_singular(contact)) order_.put_first(AutoMethod::kContactLemke);
  rests_ = when_to_rest();
  if (rests_ == Rests::kByInteriorPoint) order_.put_rest_first();
}

/// Of those that solve() needs first; into shared ones only the memory is taken.
void IslandSolver::load_first() {
  if (order_.turns().empty()) return;
  if (rests_ == Rests::kByActiveSets) {
    if (methods_ == &shared_) return shared_.reserve(AutoMethod::kContactLemke, *problem_, true);
    methods_->loaded(AutoMethod::kContactLemke);  // it judges the impulses, and mostly has the first turn
    methods_->loaded_least_energy();
    return;
  }
  const AutoMethod first = order_.turns().front().method;
  if (methods_ == &shared_) return shared_.reserve(first, *problem_, false);
  if (Methods::load_work(first, *problem_, idle_) * kSecondsPerWork <= kLoadAtOnceS) methods_->loaded(first);
}

void IslandSolver::update(const Vector& v) {
  v_ = v;
  if (has_sticking_) sticking_->set_velocity(v_);
  has_rest_ = pauses_ = false;
  own_.set_velocity(v_);
  if (waits_) return;
  methods_ = &own_;
  choose();
  load_first();
}

/// The convex problem comes first where friction may hold all contacts, these have more ways to press than to move, and
/// it takes less work than the first method. Soft contacts with more ways to press than to move mostly all do;
/// LeastEnergy then works in the coordinates, and finds slip, too.
IslandSolver::Rests IslandSolver::when_to_rest() const {
  const ContactProblem& contact = *problem_->contact();
  const bool may_rest = contact.frictional() && redundancy(contact, idle_) > 1 && LeastEnergy::takes(contact) &&
                        (contact.is_soft() || slip_ratio(contact, v_) <= kStickingByFriction);
  if (!may_rest) return Rests::kAfterwards;
  const double by_active_sets = work_of_active_sets();
  if (by_active_sets <= Order::kLeastWork) return Rests::kByActiveSets;
  const double by_ipm = contact.is_soft() ? kInfinity : work_of_interior_point();
  if (!(std::min(by_active_sets, by_ipm) <= order_.likely_work())) return Rests::kAfterwards;
  return by_active_sets <= by_ipm ? Rests::kByActiveSets : Rests::kByInteriorPoint;
}

void IslandSolver::solve(const Vector* start, const AutoLimits& limits, Answer& answer, AutoReport& report) {
  limits_ = limits;
  knows_no_rest_ = false;
  progress_.fill(Progress::kNone);
  if (start != nullptr && start->size() != problem_->size()) start = nullptr;
  if (start != nullptr && still_rests(*start, answer, report)) {
    wrong_guesses_ = 0;
    rested_ = true;
    return;
  }
  rested_ = false;
  const bool guesses_now = guesses(start);
  const bool found = guesses_now && sticks_again(*start, limits, answer, report);
  if (guesses_now) {
    wrong_guesses_ = found ? 0 : wrong_guesses_ + 1;
    steps_without_guess_ = wrong_guesses_;
  }
  if (found) return;
  if (methods_ == &shared_) shared_.begin(*problem_, v_, is_whole_);
  if (std::exchange(waits_, false)) choose();
  const bool rests_first = rests_ == Rests::kByActiveSets && rests(start != nullptr, limits, answer, report);
  if (!rests_first && !take_turns(start, limits, answer, report)) return;
  if (answer.claim != Claim::kSolved) return;
  const bool moves = !rests_first && slips(answer);
  if (moves && !may_rest_instead(answer)) return;
  const bool is_sought = moves && !find_rest(limits, answer, report);  // it may slip by a method's error alone
  // Impulses of pivots are at the bounds of their cones; those of the interior point have room on all sides.
  if (!settle_at_rest(answer, report) && !is_sought) rests_by_interior_point(limits, answer, report);
  if (rested_) wrong_guesses_ = steps_without_guess_ = 0;
}

/// The methods take turns until one has an answer. A turn ends after a budget of work, never of time, so that the same
/// data give the same answer on every machine, unless the deadline ends the solve. In the next round those that have
/// not given up begin anew, with kGrowth times the work. With friction they begin from nothing: a start may lead to
/// another of several solutions, or mislead.
/// @returns whether the answer is one
bool IslandSolver::take_turns(const Vector* start, const AutoLimits& limits, Answer& answer, AutoReport& report) {
  const ContactProblem& contact = *problem_->contact();
  const double now_s = wall_clock_s(), deadline_s = now_s + (1 - kTimeForTest) * (limits.deadline_s - now_s);
  const double error = aim_of(limits.error);
  // An iterate with such a residual is an answer, if all methods have had a turn and none has a better one.
  const double acceptable = error > 0 ? error : largest_claimed();
  const Vector* const guess = contact.frictional() ? nullptr : start;
  bool seeks_proof = contact.frictional() && may_be_unsolvable(contact);  // without friction active_set proves it
  bool is_out_of_time = false, goes_on = true;
  answer.clear();  // what no method overwrites is not the last step's
  best_residual_ = kInfinity;
  for (double budget = 1; goes_on && !is_out_of_time; budget *= kGrowth) {
    goes_on = false;
    for (const auto& [method, work, price] : order_.turns()) {
      Progress& progress = progress_[index(method)];
      if (progress == Progress::kEnded) continue;
      if (is_too_late_for(method, deadline_s)) {
        is_out_of_time = true;
        continue;
      }
      BudgetedSolver& solver = methods_->loaded(method);
      if (progress == Progress::kNone) report.count(method);
      const bool has_ended =
          solver.solve_within({.start = guess, .error = error, .work = budget * work, .deadline_s = deadline_s}, answer);
      progress = has_ended ? Progress::kEnded : Progress::kBegun;
      goes_on = goes_on || !has_ended;
      bool claims = has_ended && (answer.claim == Claim::kSolved || answer.claim == Claim::kUnsolvable);
      const bool may_be_poor = error == 0 && !Methods::is_dense(method) && answer.claim == Claim::kSolved;
      if (!claims || may_be_poor) claims = !(note_iterate(solver, method, answer) > kPoor * kDefaultAim) && claims;
      if (claims) {
        answered_by_ = method;
        report.add(answer.counters, Methods::is_dense(method) ? std::string_view(answer.detail) : "");
        if (answer.velocity.size() > contact.ngc()) {  // of a rigid equivalent
          answer.velocity = Vector(answer.velocity.head(contact.ngc()));
        }
        return true;
      }
    }
    if (std::exchange(seeks_proof, false) && disproves(answer)) return true;
    if (best_residual_ <= acceptable && passes(best_, answer)) break;
  }
  report.add({}, "");
  if (answer.claim == Claim::kSolved || answer.claim == Claim::kUnsolvable) return true;
  take_best(is_out_of_time || !(wall_clock_s() < deadline_s) ? Claim::kTimeLimit : answer.claim, answer);
  return answer.claim == Claim::kSolved;
}

/// Whether nothing may begin any more: the deadline is over, or the load of a dense method would outlast it.
bool IslandSolver::is_too_late_for(AutoMethod method, double deadline_s) {
  const double load_s = methods_->has(method) ? 0 : kSecondsPerWork * Methods::load_work(method, *problem_, idle_);
  return !(wall_clock_s() + load_s < deadline_s);
}

/// Keeps the method's best iterate, if it is better than that of the others. @returns its residual
double IslandSolver::note_iterate(BudgetedSolver& solver, AutoMethod method, const Answer& answer) {
  const double residual = solver.residual(answer);
  if (residual < best_residual_) {
    best_residual_ = residual;
    best_ = answer.z;
    answered_by_ = method;
  }
  return residual;
}

bool IslandSolver::disproves(Answer& answer) {
  answer.clear();
  loaded_test().settle_ray(answer, limits_.deadline_s);
  return answer.claim == Claim::kUnsolvable;
}

/// The stated error, as far as AnswerTest allows it: that of contacts whose inertia is not given by blocks is that of
/// the verdict.
double IslandSolver::aim_of(double error) const {
  const ContactProblem& contact = *problem_->contact();
  return std::holds_alternative<BlockInertia>(contact.inertia) ? error : std::min(error, largest_claimed());
}

/// The largest residual that AnswerTest confirms.
double IslandSolver::largest_claimed() const {
  return may_be_singular(*problem_->contact()) ? kSureResidual : kClaimedResidual;
}

AnswerTest& IslandSolver::loaded_test() {
  if (!has_test_) test_.load(*problem_);
  has_test_ = true;
  test_.set_velocity(v_);
  test_.allow(aim_of(limits_.error));
  return test_;
}

/// Whether z is an answer, or leads to a proof that there is none. Writes that.
bool IslandSolver::passes(const Vector& z, Answer& answer) {
  answer.clear();
  answer.z = z;
  answer.claim = Claim::kSolved;
  return loaded_test().settle(answer, limits_.deadline_s) || answer.claim == Claim::kUnsolvable;
}

/// Hands out the best iterate: as the answer, if it passes the test of one.
void IslandSolver::take_best(Claim otherwise, Answer& answer) {
  if (best_residual_ <= std::max(limits_.error, kClaimedQuadResidual) && passes(best_, answer)) return;
  answer.velocity.resize(0);
  answer.farkas.resize(0);
  answer.z.resize(problem_->size());
  answer.z.setZero();
  answer.claim = otherwise == Claim::kSolved ? Claim::kNumericalFailure : otherwise;
  if (!(best_residual_ < 1)) return;  // that of z = 0
  answer.z = best_;
  std::array<char, 64> text{};
  const int length = std::snprintf(text.data(), text.size(), "best residual %.2g", best_residual_);
  answer.detail.assign(text.data(), static_cast<std::size_t>(length));
}

}  // namespace lcpbench
