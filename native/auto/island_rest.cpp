#include "native/auto/island_rest.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/timed_solve.h"
#include "native/contacts/contact_impulses.h"
#include "native/friction_ipm/friction_ipm.h"

namespace lcpbench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A multiplication of LeastEnergy takes so many times as long as one of contact_lemke.
constexpr double kPriceOfLeastEnergy = 3;

/// Of the slip ratio, see slip_ratio(): friction may hold every contact up to 1. From this one on it did so on a
/// quarter of the steps.
constexpr double kStickingByFriction = 0.5;

/// Of the impulses of least energy, relative to the scale; less if a smaller error is stated. They are a solution to
/// rounding, or none.
constexpr double kLargestRestResidual = 1e-8;

/// Relative to max|v|: above this, a contact slips.
constexpr double kSlippingShare = 1e-7;

/// Residual of the first convex problem of friction_ipm that may be one of rest, and the least to which it is solved.
constexpr double kNearlyConvex = 1e-2, kFinestError = 1e-12;

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

void IslandRest::load() {
  has_rest_ = false;
  if (Rest::takes(task_.contact())) rest_.reserve(task_.contact().ngc());
}

/// The convex problem comes first where friction may hold all contacts, these have more ways to press than to move, and
/// it takes less work than the first method. Soft contacts with more ways to press than to move mostly all do;
/// LeastEnergy then works in the coordinates, and finds slip, too.
IslandRest::First IslandRest::first() const {
  const ContactProblem& contact = task_.contact();
  const bool may_rest = contact.frictional() && redundancy(contact, task_.idle) > 1 && LeastEnergy::takes(contact) &&
                        (contact.is_soft() || slip_ratio(contact, task_.v) <= kStickingByFriction);
  if (!may_rest) return First::kMethods;
  const double by_active_sets = work_of_active_sets();
  if (by_active_sets <= Order::kLeastWork) return First::kActiveSets;
  const double by_ipm = contact.is_soft() ? kInfinity : work_of_interior_point();
  if (!(std::min(by_active_sets, by_ipm) <= task_.order.likely_work())) return First::kMethods;
  return by_active_sets <= by_ipm ? First::kActiveSets : First::kInteriorPoint;
}

bool IslandRest::still_rests(const Vector& start, bool may_balance, Answer& answer, AutoReport& report) {
  if (!Rest::takes(task_.contact()) || !Rest::may_hold(task_.contact(), task_.v, start)) return false;
  const double imbalance = loaded_rest().imbalance(start);
  if (!(imbalance <= Rest::kNearByPivots)) return false;
  const auto holds = [this](double missing) {
    return missing <= Rest::kBalanced && rest_.residual_speed() <= Rest::kStill;
  };
  const bool is_held = holds(imbalance);
  if (!is_held && !may_balance) return false;
  Vector z = start;
  if (!is_held) {
    report.add({.iterations = 0, .pivots = 0, .factorizations = 1}, "");
    rest_.bring_into_cones(z);
    if (!task_.loaded_sticking().balance(z, 1, rest_.touching()) || !holds(rest_.imbalance(z))) return false;
  }
  if (!task_.passes(z, answer) || answer.claim != Claim::kSolved) return false;
  rest_.write_velocity(answer.velocity);
  return rests_ = true;
}

bool IslandRest::accepts(Answer& answer) {
  if (!Rest::takes(task_.contact()) || !Rest::may_hold(task_.contact(), task_.v, answer.z)) return true;
  const double imbalance = loaded_rest().imbalance(answer.z);
  rests_ = imbalance <= Rest::kBalanced && rest_.residual_speed() <= Rest::kStill;
  if (rests_) rest_.write_velocity(answer.velocity);
  return rests_ || !(imbalance <= Rest::kNear);
}

bool IslandRest::find_by_active_sets(bool is_warm, Answer& answer, AutoReport& report) {
  if (!(wall_clock_s() < task_.limits.deadline_s)) return false;
  LeastEnergy& least_energy = task_.methods->loaded_least_energy();
  Counters work{.iterations = 0, .pivots = 0, .factorizations = 0};
  const bool found = least_energy.solve(is_warm, task_.limits.deadline_s, work.pivots);
  report.add(work, "");
  if (!found) return false;
  knows_no_rest_ = true;
  // The exact test takes as long as the solve: it is left out where contacts that press clearly separate.
  if (!task_.contact().is_soft() && least_energy.separates(task_.v)) return false;
  auto& judge = static_cast<ContactLemke&>(task_.methods->loaded(AutoMethod::kContactLemke));
  const contact_lemke::Residual residual = judge.complete(least_energy.z().data());
  const double error = task_.limits.error;
  const double tolerance = error > 0 ? std::min(error, kLargestRestResidual) : kLargestRestResidual;
  if (!(residual.velocity <= tolerance && residual.certain <= kClaimedResidual)) return false;
  answer.clear();
  answer.claim = Claim::kSolved;
  answer.z = least_energy.z().view();
  task_.answered_by = AutoMethod::kContactLemke;
  ++report.least_energy;
  return true;
}

void IslandRest::improve(From from, Answer& answer, AutoReport& report) {
  const bool moves = from != From::kLeastEnergy && slips(answer);
  if (moves && is_refuted(answer)) return;
  const bool is_found = !moves || find(answer, report);  // if not, it may slip by a method's error alone
  // Impulses of pivots are at the bounds of their cones; those of the interior point have room on all sides.
  const bool is_settled = settle(answer, report) && (rests_ || from != From::kIterate);
  if (!is_settled && is_found) find_by_interior_point(answer, report);
}

/// Whether some contact slips without parting at mu times the speed of its slip: only then is the answer not that of
/// least energy.
bool IslandRest::slips(const Answer& answer) {
  const ContactProblem& contact = task_.contact();
  const double tolerance = kSlippingShare * task_.v.lpNorm<Eigen::Infinity>();
  has_u_ = false;
  Index lambda = contact.nc() + cols(contact.D);
  for (Index c = 0; c < contact.nc(); ++c) {
    if (contact.edges[static_cast<std::size_t>(c)] == 0) continue;
    const double slip = answer.z(lambda++);
    if (contact.mu(c) == 0 || slip <= tolerance) continue;
    if (answer.z(c) > 0) return true;
    find_velocity(answer);
    const double parting = dot_column(contact.N, c, u_) + contact.offset(c);
    if (!(parting >= contact.mu(c) * (slip - tolerance))) return true;
  }
  return false;
}

/// Whether contacts, of which some slip in the answer, are proven not to rest all, or no rest was found before.
bool IslandRest::is_refuted(const Answer& answer) {
  // friction_ipm solves the convex problem first, unless its turn ends before.
  constexpr AutoMethod kConvex = AutoMethod::kFrictionIpm;
  const bool has_convex = task_.answered_by == kConvex && task_.progress_of(kConvex) == IslandTask::Progress::kEnded;
  if (knows_no_rest_ || has_convex) return true;
  if (!Rest::takes(task_.contact()) || !loaded_rest().is_possible()) return true;
  find_velocity(answer);
  return rest_.is_refuted(u_);
}

/// The velocity of the answer into u_. @pre has_u_: it is there already
void IslandRest::find_velocity(const Answer& answer) {
  if (std::exchange(has_u_, true)) return;
  u_.resize(task_.contact().ngc());
  if (answer.velocity.size() == u_.size()) {
    u_ = answer.velocity;
  } else {
    task_.methods->respond(task_.answered_by, answer.z, u_);
  }
}

/// Solves the convex problem of rest, by what takes less work; by the other if that decides nothing. @returns whether
/// its solution is an answer
bool IslandRest::find(Answer& answer, AutoReport& report) {
  const double by_active_sets = LeastEnergy::takes(task_.contact()) ? work_of_active_sets() : kInfinity;
  const double by_ipm = work_of_interior_point();
  for (const bool active_sets : {by_active_sets <= by_ipm, by_active_sets > by_ipm}) {
    if (knows_no_rest_ || !((active_sets ? by_active_sets : by_ipm) < kInfinity)) continue;
    if (active_sets ? find_by_active_sets(false, answer, report) : find_by_interior_point(answer, report)) return true;
  }
  return false;
}

/// Whether the first convex problem of friction_ipm is an answer. If its impulses are near those of rest, but none that
/// hold are found near them, it is solved once more, to rounding.
bool IslandRest::find_by_interior_point(Answer& answer, AutoReport& report) {
  using Progress = IslandTask::Progress;
  if (!task_.order.has(AutoMethod::kFrictionIpm)) return false;
  const Progress progress = task_.progress_of(AutoMethod::kFrictionIpm);
  const bool has_answer = std::ranges::any_of(task_.progress, [](Progress each) { return each != Progress::kNone; });
  auto& ipm = static_cast<FrictionIpmSolver&>(task_.methods->loaded(AutoMethod::kFrictionIpm));
  if (progress == Progress::kNone) report.count(AutoMethod::kFrictionIpm);
  const AutoMethod answered_by = std::exchange(task_.answered_by, AutoMethod::kFrictionIpm);
  const auto held = std::make_unique<Answer>();
  for (const double error : {task_.aim_of(task_.limits.error), kFinestError}) {
    if (error != kFinestError && progress == Progress::kEnded) continue;
    // The answer of another method has led to no proof.
    const auto stops = [&](const Vector& z) { return !has_answer && is_refuted_near(z); };
    if (!ipm.solve_convex({.error = error, .deadline_s = task_.limits.deadline_s}, stops, *held)) break;
    const bool claimed = held->claim == Claim::kSolved;
    if (!claimed) {
      if (!(ipm.residual(*held) < kNearlyConvex)) break;
      held->velocity.resize(0);
      held->claim = Claim::kSolved;
    }
    if (claimed && slips(*held)) break;
    const bool is_settled = settle(*held, report);
    if (!rests_ && !(is_settled && claimed)) continue;
    if (!claimed) {  // momentum in balance leaves a light body more speed than an answer may have
      rests_ = task_.passes(Vector(held->z), *held) && held->claim == Claim::kSolved;
      if (!rests_) continue;
      rest_.write_velocity(held->velocity);
    }
    answer = *held;
    return true;
  }
  knows_no_rest_ = true;
  task_.answered_by = answered_by;
  return false;
}

/// Whether the velocity of these impulses shows that contacts cannot all rest: they tend to ones with which all part.
bool IslandRest::is_refuted_near(const Vector& z) {
  u_.resize(task_.contact().ngc());
  task_.methods->respond(task_.answered_by, z, u_);
  return loaded_rest().is_refuted(u_);
}

/// Makes an answer that rests but for rounding or an iterative method's error rest exactly: impulses nearby that
/// balance the momentum to rounding, and the velocity zero. @returns false if it nearly rests, and none were found
bool IslandRest::settle(Answer& answer, AutoReport& report) {
  if (!Rest::takes(task_.contact()) || !Rest::may_hold(task_.contact(), task_.v, answer.z)) return true;
  if (!loaded_rest().is_possible()) return true;
  const double imbalance = rest_.imbalance(answer.z);
  bool may_be_imprecise = false;
  if (!(imbalance <= Rest::kRounding) && !balance(imbalance, answer, report, may_be_imprecise) &&
      !(imbalance <= Rest::kBalanced)) {
    return !may_be_imprecise;
  }
  rest_.write_velocity(answer.velocity);
  return rests_ = true;
}

/// Puts impulses that balance the momentum in place of those of an answer near them. @returns whether they were found
/// @param may_be_imprecise becomes true if there may be some that the method was not precise enough to lead to
bool IslandRest::balance(double imbalance, Answer& answer, AutoReport& report, bool& may_be_imprecise) {
  const bool is_precise = Methods::is_dense(task_.answered_by) && rest_.ratio_of_masses() < Rest::kUnlike;
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
    if (!task_.loaded_sticking().balance(held_->z, power, rest_.touching())) continue;
    if (!(rest_.imbalance(held_->z) <= Rest::kBalanced)) continue;
    if (!task_.passes(Vector(held_->z), *held_) || held_->claim != Claim::kSolved) continue;
    answer.z = held_->z;
    return true;
  }
  may_be_imprecise = !is_precise;
  return false;
}

/// Likely, of the convex problem of rest; infinity where the method does not take it.
double IslandRest::work_of_active_sets() const {
  const bool is_small = Methods::takes(AutoMethod::kContactLemke, *task_.problem);
  return is_small ? kPriceOfLeastEnergy * LeastEnergy::work(task_.contact(), task_.idle) : kInfinity;
}

double IslandRest::work_of_interior_point() const {
  return task_.order.has(AutoMethod::kFrictionIpm) ? task_.order.likely_work_of_rest() : kInfinity;
}

Rest& IslandRest::loaded_rest() {
  if (!has_rest_) rest_.load(task_.contact(), task_.v);
  has_rest_ = true;
  return rest_;
}

}  // namespace lcpbench
