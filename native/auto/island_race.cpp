#include "native/auto/island_race.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>
#include <variant>

#include "core/timed_solve.h"
#include "native/auto/prediction.h"
#include "native/proofs/doubtful_inertia.h"

namespace lcpbench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Digits that iterative methods take where no error is stated.
constexpr double kDefaultDigits = 9;

/// A load() knows no time limit: what is predicted to take longer, in ns, is left to solve().
constexpr double kLoadAtOnce = 5e7;

/// Of what friction_ipm takes to find rest: the shape of what is nearly certain.
constexpr double kShapeOfRest = 4;

/// Of the convex problem of rest, which decides whether it comes before the race: friction may hold every contact up to
/// a slip ratio of 1. From this one on it did so on a quarter of the steps.
constexpr double kStickingByFriction = 0.5;

/// Of the work of a race, over the least predicted and over that of ContactFarkas; and what a multiplication of the
/// latter takes. It takes about as many steps as its tableau has columns.
constexpr double kWorkOverProof = 4, kNsOfProof = 0.25;

/// Part of the time that is left, for the test of the best iterate.
constexpr double kTimeForTest = 0.05;

constexpr std::array kFrictional{AutoMethod::kContactLemke, AutoMethod::kFrictionIpm, AutoMethod::kContactIpm,
                                 AutoMethod::kPsor, AutoMethod::kOverRelaxedPsor};
constexpr std::array kFrictionless{AutoMethod::kActiveSet, AutoMethod::kVelocityIpm, AutoMethod::kPsor,
                                   AutoMethod::kContactLemke};
static_assert(kFrictional.size() <= Race::kMostEntrants && kFrictionless.size() <= Race::kMostEntrants);

}  // namespace

IslandRace::IslandRace(Methods& shared, const std::shared_ptr<LaterEngines>& later, double error, bool is_whole)
    : error_(error), is_whole_(is_whole), own_(later), shared_(shared), methods_(&own_) {}

void IslandRace::load(const Problem& problem, const Vector& v, const Load& how) {
  problem_ = &problem;
  v_ = v;
  methods_ = how.in_turn ? &shared_ : &own_;
  count_ = 0;
  has_sticking_ = has_test_ = has_rest_ = false;
  own_.begin(problem, v_, is_whole_);
  if (Rest::takes(*problem.contact())) rest_.reserve(problem.contact()->ngc());
  waits_ = how.after_guess && (rested_ || StickingContacts::is_worth_a_guess(*problem.contact(), false));
  pauses_ = how.after_guess && steps_without_guess_ > 0;
  if (pauses_) --steps_without_guess_;
  waits_ = waits_ && !pauses_;
  if (waits_) return;
  enter();
  load_first();
}

/// The methods that take the problem.
void IslandRace::enter() {
  const ContactProblem& contact = *problem_->contact();
  count_ = 0;
  const std::span methods = contact.frictional() ? std::span<const AutoMethod>(kFrictional) : kFrictionless;
  for (const AutoMethod method : methods) {
    if (Methods::takes(method, *problem_)) order_[count_++] = method;
  }
  const bool has_head_start = count_ > 0 && Methods::is_dense(order_[0]);
  first_ = has_head_start ? predict_load(order_[0], *problem_, idle_) : Entrant{.load_cost = kInfinity};
  features_.begin(contact, idle_);
  race_.reserve(problem_->size());
  choose();
}

/// How to begin at the velocity now.
void IslandRace::choose() {
  has_predictions_ = false;
  order_of_rest_ = order();
  if (order_of_rest_ == Order::kInteriorPointFirst) expect_rest();
}

std::span<const Entrant> IslandRace::entrants() {
  const std::span all{entrants_.data(), count_};
  if (has_predictions_) return all;
  has_predictions_ = true;
  const double digits = error_ > 0 ? -std::log10(aim_of(error_)) : kDefaultDigits;
  const auto& features = features_.measure(*problem_->contact(), v_, digits);
  for (std::size_t k = 0; k < count_; ++k) entrants_[k] = predict(order_[k], *problem_, idle_, features);
  // Only contact_lemke tells what has a solution from what has none.
  const bool first_proves = order_[0] == AutoMethod::kContactLemke && problem_->contact()->frictional();
  if (first_proves && may_be_singular(*problem_->contact())) entrants_[0].cost = predicted();
  return all;
}

/// The first convex problem of friction_ipm finds rest.
void IslandRace::expect_rest() {
  const std::size_t ipm = entrant_of(AutoMethod::kFrictionIpm);
  if (ipm == count_) return;
  const double least = predicted();
  entrants_[ipm].cost = std::min(cost_of_interior_point(), least);
  entrants_[ipm].shape = kShapeOfRest;
}

double IslandRace::predicted() {
  double least = kInfinity;
  for (const Entrant& entrant : entrants()) least = std::min(least, entrant.cost);
  return count_ > 0 ? least : 0;
}

/// Of those that solve() needs first; into shared ones only the memory is taken.
void IslandRace::load_first() {
  if (count_ == 0) return;
  if (order_of_rest_ == Order::kActiveSetsFirst) {
    if (methods_ == &shared_) return shared_.reserve(AutoMethod::kContactLemke, *problem_, true);
    methods_->loaded(AutoMethod::kContactLemke);  // it judges the impulses, and mostly is the first in the race
    methods_->loaded_least_energy();
    return;
  }
  const bool has_head_start = first_.load_cost <= Race::kHeadStart;
  const std::size_t first = has_head_start ? 0 : race_.first(entrants());
  if (methods_ == &shared_) return shared_.reserve(order_[first], *problem_, false);
  if (has_head_start || entrants_[first].load_cost <= kLoadAtOnce) methods_->loaded(order_[first]);
}

/// count_ where it has not entered.
std::size_t IslandRace::entrant_of(AutoMethod method) const {
  const auto end = order_.begin() + static_cast<std::ptrdiff_t>(count_);
  return static_cast<std::size_t>(std::find(order_.begin(), end, method) - order_.begin());
}

void IslandRace::update(const Vector& v) {
  v_ = v;
  if (has_sticking_) sticking_->set_velocity(v_);
  has_rest_ = pauses_ = false;
  own_.set_velocity(v_);
  if (waits_) return;
  methods_ = &own_;
  features_.forget_slip();
  choose();
  load_first();
}

/// The convex problem comes first where friction may hold all contacts, these have more ways to press than to move, and
/// no method of the race is predicted to end sooner. Soft contacts with more ways to press than to move mostly all do;
/// LeastEnergy then works in the coordinates, and finds slip, too.
IslandRace::Order IslandRace::order() {
  const ContactProblem& contact = *problem_->contact();
  const bool may_rest = contact.frictional() && features_.redundancy() > 1 && LeastEnergy::takes(contact) &&
                        (contact.is_soft() || features_.slip_ratio(contact, v_) <= kStickingByFriction);
  if (!may_rest) return Order::kRaceFirst;
  const double by_active_sets = cost_of_active_sets();
  if (by_active_sets <= Race::kHeadStart) return Order::kActiveSetsFirst;
  const double least = predicted();
  const double by_ipm = contact.is_soft() ? kInfinity : cost_of_interior_point();
  if (!(std::min(by_active_sets, by_ipm) <= least)) return Order::kRaceFirst;
  return by_active_sets <= by_ipm ? Order::kActiveSetsFirst : Order::kInteriorPointFirst;
}

void IslandRace::solve(const Vector* start, const AutoLimits& limits, Answer& answer, AutoReport& report) {
  limits_ = limits;
  knows_no_rest_ = has_raced_ = false;
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
  if (waits_) enter();
  waits_ = false;
  const bool rests_first = order_of_rest_ == Order::kActiveSetsFirst && rests(start != nullptr, limits, answer, report);
  if (!rests_first && !race(start, limits, answer, report)) return;
  if (answer.claim != Claim::kSolved) return;
  const bool moves = !rests_first && slips(answer);
  if (moves && !may_rest_instead(answer)) return;
  const bool looked = moves && !find_rest(limits, answer, report);  // what slips may do so by a method's error alone
  // Impulses of pivots are at the bounds of their cones; those of the interior point have room on all sides.
  if (!settle_at_rest(answer, report) && !looked) rests_by_interior_point(limits, answer, report);
  if (rested_) wrong_guesses_ = steps_without_guess_ = 0;
}

/// With friction it begins from nothing: a start may lead to another of several solutions, or mislead.
/// @returns whether the answer is one
bool IslandRace::race(const Vector* start, const AutoLimits& limits, Answer& answer, AutoReport& report) {
  has_raced_ = true;
  const double now_s = wall_clock_s();
  const double error = aim_of(limits.error);
  const Race::End end = race_.run(*this,
                                  {.size = problem_->size(),
                                   .start = problem_->contact()->frictional() ? nullptr : start,
                                   .error = error,
                                   .aim = error > 0 ? error : std::pow(10, -kDefaultDigits),
                                   .accepted = largest_claimed(),
                                   .proof_at = work_before_proof(),
                                   .ends_early = limits.error == 0,
                                   .deadline_s = now_s + (1 - kTimeForTest) * (limits.deadline_s - now_s)},
                                  answer);
  for (std::size_t k = 0; k < count_; ++k) {
    if (race_.has_run(k)) report.count(order_[k]);
  }
  answered_by_ = order_[race_.winner()];
  const bool claimed = end == Race::End::kClaimed;
  const bool has_stage =
      claimed && (answered_by_ == AutoMethod::kContactLemke || answered_by_ == AutoMethod::kActiveSet);
  report.add(claimed ? answer.counters : Counters{}, has_stage ? std::string_view(answer.detail) : "");
  if (!claimed) {
    take_best(end, answer);
    return answer.claim == Claim::kSolved;
  }
  const Index ngc = problem_->contact()->ngc();
  if (answer.velocity.size() > ngc) answer.velocity = Vector(answer.velocity.head(ngc));  // of a rigid equivalent
  return true;
}

/// After this work of the race a proof that there is no solution is looked for: what has one mostly ends before, and
/// else loses little. Infinity: there is always one, as far as such proofs tell.
double IslandRace::work_before_proof() {
  const ContactProblem& contact = *problem_->contact();
  if (!contact.frictional() || !may_be_unsolvable(contact)) return kInfinity;  // without friction active_set proves it
  const auto rows = static_cast<double>(contact.ngc()), width = rows + static_cast<double>(contact.nc());
  return kWorkOverProof * std::max(predicted(), kNsOfProof * rows * width * width);
}

bool IslandRace::disproves(Answer& answer) {
  answer.clear();
  loaded_test().settle_ray(answer, limits_.deadline_s);
  return answer.claim == Claim::kUnsolvable;
}

/// The stated error, as far as AnswerTest allows it: that of contacts whose inertia is not given by blocks is that of
/// the verdict.
double IslandRace::aim_of(double error) const {
  const ContactProblem& contact = *problem_->contact();
  return std::holds_alternative<BlockInertia>(contact.inertia) ? error : std::min(error, largest_claimed());
}

/// The largest residual that AnswerTest confirms.
double IslandRace::largest_claimed() const {
  return may_be_singular(*problem_->contact()) ? kSureResidual : kClaimedResidual;
}

AnswerTest& IslandRace::loaded_test() {
  if (!has_test_) test_.load(*problem_, AnswerTest::Bodies::kOneByOne);
  has_test_ = true;
  test_.set_velocity(v_);
  test_.allow(aim_of(limits_.error));
  return test_;
}

bool IslandRace::passes(const Vector& best, Answer& answer) {
  answer.clear();
  answer.z = best;
  answer.claim = Claim::kSolved;
  return loaded_test().settle(answer, limits_.deadline_s) || answer.claim == Claim::kUnsolvable;
}

/// Hands out the best iterate: as the answer, if it passes the test of one.
void IslandRace::take_best(Race::End end, Answer& answer) {
  const Claim claim = end == Race::End::kTimeLimit     ? Claim::kTimeLimit
                      : answer.claim == Claim::kSolved ? Claim::kNumericalFailure
                                                       : answer.claim;
  const double residual = race_.best_residual();
  if (residual <= std::max(limits_.error, kClaimedQuadResidual) && passes(race_.best(), answer)) return;
  answer.velocity.resize(0);
  answer.farkas.resize(0);
  answer.z.resize(problem_->size());
  answer.z.setZero();
  answer.claim = claim;
  if (!(residual < 1)) return;  // that of z = 0
  answer.z = race_.best();
  std::array<char, 64> text{};
  const int length = std::snprintf(text.data(), text.size(), "best residual %.2g", residual);
  answer.detail.assign(text.data(), static_cast<std::size_t>(length));
}

}  // namespace lcpbench
