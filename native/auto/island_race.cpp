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
#include "native/proofs/contact_farkas.h"

namespace lcpbench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Digits that iterative methods take where no error is stated.
constexpr double kDefaultDigits = 9;

/// A load() knows no time limit: what is predicted to take longer, in ns, is left to solve().
constexpr double kLoadAtOnce = 5e7;

/// Of LeastEnergy::work().
constexpr double kNsPerMultiplication = 0.25;
/// What friction_ipm takes with its load to find rest, over the load: the median of 184 measured problems is 2.5. The
/// shape of the distribution is that of what is nearly certain.
constexpr double kRestOverLoad = 3, kShapeOfRest = 4;

/// Guesses which contacts hold, on islands whose first method is loaded. On others those after the first hardly ever
/// find it.
constexpr int kStickingTries = 3;

/// Of the impulses of least energy, relative to max|q|; less if a smaller error is stated. They are a solution to
/// rounding, or none.
constexpr double kLargestRestResidual = 1e-8;

/// Of the convex problem of rest, which decides whether it comes before the race: friction may hold every contact up to
/// a slip ratio of 1. From this one on it did so on a quarter of the steps.
constexpr double kStickingByFriction = 0.5;
/// Relative to max|v|: above this, a contact slips.
constexpr double kSlippingShare = 1e-7;

/// Residual of the first convex problem of friction_ipm that may be one of rest, and the least to which it is solved.
constexpr double kNearlyConvex = 1e-2, kFinestError = 1e-12;

/// Steps of the interior point after which its velocity may show that there is no rest.
constexpr int kStepsToRefute = 3;

/// Part of the time that is left, for the test of the best iterate.
constexpr double kTimeForTest = 0.05;

constexpr std::array kFrictional{AutoMethod::kContactLemke, AutoMethod::kFrictionIpm, AutoMethod::kProximalNewton,
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
  entrants_[ipm].cost = std::min(kRestOverLoad * entrants_[ipm].load_cost, least);
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

Rest& IslandRace::loaded_rest() {
  if (!has_rest_) rest_.load(*problem_->contact(), v_);
  has_rest_ = true;
  return rest_;
}

StickingContacts& IslandRace::loaded_sticking() {
  if (sticking_ == nullptr) sticking_ = std::make_unique<StickingContacts>(is_whole_);
  if (!has_sticking_) sticking_->load(*problem_, v_);
  has_sticking_ = true;
  return *sticking_;
}

/// Whether the impulses of the last step hold the island at rest as they are.
bool IslandRace::still_rests(const Vector& start, Answer& answer, AutoReport& report) {
  const ContactProblem& contact = *problem_->contact();
  if (!Rest::takes(contact) || !Rest::may_hold(contact, v_, start) || !(loaded_rest().imbalance(start) <= Rest::kBalanced)) return false;
  if (!passes(start, answer) || answer.claim != Claim::kSolved) return false;
  rest_.write_velocity(answer.velocity);
  ++report.sticking;
  return true;
}

bool IslandRace::guesses(const Vector* start) const {
  if (start == nullptr || pauses_) return false;
  return (waits_ || StickingContacts::is_worth_a_guess(*problem_->contact(), true)) &&
         StickingContacts::takes(*problem_->contact()) &&
         StickingContacts::sticking(*problem_->contact(), v_, *start);
}

/// Whether the contacts that pressed in the last step hold again.
bool IslandRace::sticks_again(const Vector& start, const AutoLimits& limits, Answer& answer, AutoReport& report) {
  Counters work{.iterations = 0, .pivots = 0, .factorizations = 0};
  const int tries = StickingContacts::is_worth_a_guess(*problem_->contact(), true) ? kStickingTries : 1;
  const bool found = loaded_sticking().solve(start, tries, limits.deadline_s, answer, work);
  report.add(work, "");
  if (!found) return false;
  const ContactProblem& contact = *problem_->contact();
  if (Rest::takes(contact) && Rest::may_hold(contact, v_, answer.z)) {
    const double imbalance = loaded_rest().imbalance(answer.z);
    rested_ = imbalance <= Rest::kBalanced;
    if (rested_) rest_.write_velocity(answer.velocity);
    if (!rested_ && imbalance <= Rest::kNear) return false;  // from nothing it may rest exactly
  }
  ++report.sticking;
  return true;
}

/// The convex problem comes first where friction may hold all contacts, these have more ways to press than to move, and
/// no method of the race is predicted to end sooner. Soft contacts with more ways to press than to move mostly all do;
/// LeastEnergy then works in the coordinates, and finds slip, too.
IslandRace::Order IslandRace::order() {
  const ContactProblem& contact = *problem_->contact();
  const bool may_rest = contact.frictional() && features_.redundancy() > 1 && LeastEnergy::takes(contact) &&
                        (contact.is_soft() || features_.slip_ratio(contact, v_) <= kStickingByFriction);
  if (!may_rest) return Order::kRaceFirst;
  const bool is_small = Methods::takes(AutoMethod::kContactLemke, *problem_);
  const double work = is_small ? kNsPerMultiplication * LeastEnergy::work(contact, idle_) : kInfinity;
  if (work <= Race::kHeadStart) return Order::kActiveSetsFirst;
  const std::size_t ipm = entrant_of(AutoMethod::kFrictionIpm);
  const double least = predicted();
  const double by_ipm = ipm < count_ && !contact.is_soft() ? kRestOverLoad * entrants()[ipm].load_cost : kInfinity;
  if (!(std::min(work, by_ipm) <= least)) return Order::kRaceFirst;
  return work <= by_ipm ? Order::kActiveSetsFirst : Order::kInteriorPointFirst;
}

/// Whether the impulses of least energy are an answer: they are unless a contact with friction presses and slips.
bool IslandRace::rests(bool is_warm, const AutoLimits& limits, Answer& answer, AutoReport& report) {
  if (!(wall_clock_s() < limits.deadline_s)) return false;
  LeastEnergy& least_energy = methods_->loaded_least_energy();
  Counters work{.iterations = 0, .pivots = 0, .factorizations = 0};
  const bool found = least_energy.solve(is_warm, limits.deadline_s, work.pivots);
  report.add(work, "");
  if (!found) return false;
  knows_no_rest_ = true;
  // The exact test takes as long as the solve: it is left out where contacts that press clearly separate.
  if (!problem_->contact()->is_soft() && least_energy.separates(v_)) return false;
  auto& judge = static_cast<ContactLemke&>(methods_->loaded(AutoMethod::kContactLemke));
  const contact_lemke::Residual residual = judge.complete(least_energy.z().data());
  const double allowed = limits.error > 0 ? std::min(limits.error, kLargestRestResidual) : kLargestRestResidual;
  if (!(residual.velocity <= allowed && residual.certain <= kClaimedResidual)) return false;
  answer.clear();
  answer.claim = Claim::kSolved;
  answer.z = least_energy.z().view();
  answered_by_ = AutoMethod::kContactLemke;
  ++report.least_energy;
  return true;
}

/// Whether the first convex problem of friction_ipm is an answer. If its impulses are near those of rest, but none that
/// hold are found near them, it is solved once more, to rounding.
bool IslandRace::rests_by_interior_point(const AutoLimits& limits, Answer& answer, AutoReport& report) {
  const std::size_t entrant = entrant_of(AutoMethod::kFrictionIpm);
  if (entrant == count_) return false;
  bool has_run = has_raced_ && race_.has_run(entrant);
  ResumableSolver& ipm = methods_->loaded(AutoMethod::kFrictionIpm);
  if (!has_run) report.count(AutoMethod::kFrictionIpm);
  const AutoMethod answered_by = std::exchange(answered_by_, AutoMethod::kFrictionIpm);
  const auto held = std::make_unique<Answer>();
  for (const double error : {aim_of(limits.error), kFinestError}) {
    if (has_raced_ && has_run && error != kFinestError && race_.has_ended(entrant)) continue;
    if (!has_run || error == kFinestError) ipm.begin(nullptr, error);
    has_run = true;
    bool has_ended = false;
    for (int step = 1; !has_ended && !ipm.residual_tells(); ++step) {
      has_ended = ipm.go_on(1, limits.deadline_s, *held);
      if (!has_ended && step % kStepsToRefute == 0 && is_refuted_by(ipm, *held)) {
        knows_no_rest_ = true;
        answered_by_ = answered_by;
        return false;
      }
    }
    const bool claimed = has_ended && held->claim == Claim::kSolved;
    if (!claimed) {
      held->z.resize(problem_->size());
      if (!(ipm.best(held->z) < kNearlyConvex)) break;
      held->velocity.resize(0);
      held->claim = Claim::kSolved;
    }
    if (claimed && slips(*held)) break;
    const bool is_settled = settle_at_rest(*held, report);
    if (!rested_ && !(is_settled && claimed)) continue;
    answer = *held;
    return true;
  }
  knows_no_rest_ = true;
  answered_by_ = answered_by;
  return false;
}

/// Whether the velocity that the method has come to shows that contacts cannot all rest: it tends to one with which they
/// all part. @param scratch is written over
bool IslandRace::is_refuted_by(ResumableSolver& method, Answer& scratch) {
  scratch.z.resize(problem_->size());
  if (!(method.best(scratch.z) < kInfinity)) return false;
  answered_u_.resize(problem_->contact()->ngc());
  methods_->respond(answered_by_, scratch.z, answered_u_);
  return loaded_rest().is_refuted(answered_u_);
}

/// Whether some contact slips without parting at mu times the speed of its slip: only then is the answer not that of
/// least energy. Leaves its velocity in answered_u_ if it was needed.
bool IslandRace::slips(const Answer& answer) {
  const ContactProblem& contact = *problem_->contact();
  const double most = kSlippingShare * v_.lpNorm<Eigen::Infinity>();
  has_answered_u_ = false;
  Index lambda = contact.nc() + cols(contact.D);
  for (Index c = 0; c < contact.nc(); ++c) {
    if (contact.edges[static_cast<std::size_t>(c)] == 0) continue;
    const double slip = answer.z(lambda++);
    if (contact.mu(c) == 0 || slip <= most) continue;
    if (answer.z(c) > 0) return true;
    find_velocity(answer);
    const double parting = dot_column(contact.N, c, answered_u_) + contact.offset(c);
    if (!(parting >= contact.mu(c) * (slip - most))) return true;
  }
  return false;
}

/// The velocity of the answer into answered_u_.
void IslandRace::find_velocity(const Answer& answer) {
  if (has_answered_u_) return;
  has_answered_u_ = true;
  answered_u_.resize(problem_->contact()->ngc());
  if (answer.velocity.size() == answered_u_.size()) {
    answered_u_ = answer.velocity;
  } else {
    methods_->respond(answered_by_, answer.z, answered_u_);
  }
}

/// Whether no proof is found that contacts, of which some slip in an answer, could not all rest.
bool IslandRace::may_rest_instead(const Answer& answer) {
  if (knows_no_rest_ || answered_by_ == AutoMethod::kFrictionIpm) return false;
  if (!Rest::takes(*problem_->contact()) || !loaded_rest().is_possible()) return false;
  find_velocity(answer);
  return !rest_.is_refuted(answered_u_);
}

/// Solves the convex problem of rest, by what takes less work; by the other if that decides nothing. @returns whether
/// its solution is an answer
bool IslandRace::find_rest(const AutoLimits& limits, Answer& answer, AutoReport& report) {
  const ContactProblem& contact = *problem_->contact();
  const bool is_small = Methods::takes(AutoMethod::kContactLemke, *problem_) && LeastEnergy::takes(contact);
  const std::size_t ipm = entrant_of(AutoMethod::kFrictionIpm);
  const double by_active_sets = is_small ? kNsPerMultiplication * LeastEnergy::work(contact, idle_) : kInfinity;
  const double by_ipm = ipm < count_ ? kRestOverLoad * entrants()[ipm].load_cost : kInfinity;
  for (const bool active_sets : {by_active_sets <= by_ipm, by_active_sets > by_ipm}) {
    if (knows_no_rest_ || !((active_sets ? by_active_sets : by_ipm) < kInfinity)) continue;
    const bool found =
        active_sets ? rests(false, limits, answer, report) : rests_by_interior_point(limits, answer, report);
    if (found) return true;
  }
  return false;
}

/// Puts impulses that balance the momentum in place of those of an answer near them. @returns whether they were found;
/// is_unsettled_: there may be some all the same, which the method was not precise enough to lead to
bool IslandRace::balance(double imbalance, Answer& answer, AutoReport& report) {
  const bool is_precise = Methods::is_dense(answered_by_) && rest_.ratio_of_masses() < Rest::kUnlike;
  if (held_ == nullptr) held_ = std::make_unique<Answer>();
  *held_ = answer;
  rest_.bring_into_cones(held_->z);
  if (!(imbalance < kInfinity)) imbalance = rest_.imbalance(held_->z);
  const bool is_near = imbalance <= (is_precise ? Rest::kNearByPivots : Rest::kNear);
  if (!is_near) return false;
  const Vector near = held_->z;
  for (int power = 1; power <= 2; ++power) {
    held_->z = near;
    report.add({.iterations = 0, .pivots = 0, .factorizations = 1}, "");
    if (!loaded_sticking().balance(held_->z, power) || !(rest_.imbalance(held_->z) <= Rest::kBalanced)) continue;
    if (!passes(Vector(held_->z), *held_) || held_->claim != Claim::kSolved) continue;
    answer.z = held_->z;
    return true;
  }
  is_unsettled_ = !is_precise;
  return false;
}

/// Makes an answer that rests but for rounding or an iterative method's error rest exactly: impulses nearby that
/// balance the momentum to rounding, and the velocity zero. @returns false if it nearly rests, and none were found
bool IslandRace::settle_at_rest(Answer& answer, AutoReport& report) {
  const ContactProblem& contact = *problem_->contact();
  if (!Rest::takes(contact) || !Rest::may_hold(contact, v_, answer.z)) return true;
  Rest& rest = loaded_rest();
  if (!rest.is_possible()) return true;
  is_unsettled_ = false;
  const double imbalance = rest.imbalance(answer.z);
  if (!(imbalance <= Rest::kRounding) && !balance(imbalance, answer, report) && !(imbalance <= Rest::kBalanced)) {
    return !is_unsettled_;
  }
  rest.write_velocity(answer.velocity);
  return rested_ = true;
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
  if (moves && !(may_rest_instead(answer) && find_rest(limits, answer, report))) return;
  // Impulses of pivots are at the bounds of their cones; those of the interior point have room on all sides.
  if (!settle_at_rest(answer, report)) rests_by_interior_point(limits, answer, report);
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

/// The stated error, as far as AnswerTest allows it: that of contacts whose inertia is not given by blocks, or that
/// need not have a solution, is that of the verdict.
double IslandRace::aim_of(double error) const {
  const ContactProblem& contact = *problem_->contact();
  const bool is_judged_by_bodies =
      std::holds_alternative<BlockInertia>(contact.inertia) && !may_be_unsolvable(contact);
  return is_judged_by_bodies ? error : std::min(error, largest_claimed());
}

/// The largest residual that AnswerTest confirms.
double IslandRace::largest_claimed() const {
  return may_be_singular(*problem_->contact()) ? kSureResidual : kClaimedResidual;
}

bool IslandRace::passes(const Vector& best, Answer& answer) {
  answer.clear();
  answer.z = best;
  answer.claim = Claim::kSolved;
  if (!has_test_) test_.load(*problem_, AnswerTest::Bodies::kOneByOne);
  has_test_ = true;
  test_.set_velocity(v_);
  test_.allow(aim_of(limits_.error));
  return test_.settle(answer, limits_.deadline_s) || answer.claim == Claim::kUnsolvable;
}

/// Hands out the best iterate: as the answer, if it passes the test of one.
void IslandRace::take_best(Race::End end, Answer& answer) {
  const Claim claim = end == Race::End::kTimeLimit    ? Claim::kTimeLimit
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
