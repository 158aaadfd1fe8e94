// How an island comes to rest: from the last impulses, by the convex problem of rest, and by settling an answer near
// it.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "core/timed_solve.h"
#include "native/auto/island_solver.h"
#include "native/friction_ipm/friction_ipm.h"

namespace lcpbench {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A multiplication of LeastEnergy takes so many times as long as one of contact_lemke.
constexpr double kPriceOfLeastEnergy = 3;

/// Guesses which contacts hold, on islands whose first method is loaded. On others those after the first hardly ever
/// find it.
constexpr int kStickingTries = 3;

/// Of the impulses of least energy, relative to the scale; less if a smaller error is stated. They are a solution to
/// rounding, or none.
constexpr double kLargestRestResidual = 1e-8;

/// Relative to max|v|: above this, a contact slips.
constexpr double kSlippingShare = 1e-7;

/// Residual of the first convex problem of friction_ipm that may be one of rest, and the least to which it is solved.
constexpr double kNearlyConvex = 1e-2, kFinestError = 1e-12;

}  // namespace

Rest& IslandSolver::loaded_rest() {
  if (!has_rest_) rest_.load(*problem_->contact(), v_);
  has_rest_ = true;
  return rest_;
}

StickingContacts& IslandSolver::loaded_sticking() {
  if (sticking_ == nullptr) sticking_ = std::make_unique<StickingContacts>(is_whole_);
  if (!has_sticking_) sticking_->load(*problem_, v_);
  has_sticking_ = true;
  return *sticking_;
}

/// Whether the impulses of the last step hold the island at rest: as they are, or balanced anew where that takes less
/// than to find them.
bool IslandSolver::still_rests(const Vector& start, Answer& answer, AutoReport& report) {
  const ContactProblem& contact = *problem_->contact();
  if (!Rest::takes(contact) || !Rest::may_hold(contact, v_, start)) return false;
  const double imbalance = loaded_rest().imbalance(start);
  if (!(imbalance <= Rest::kNearByPivots)) return false;
  const auto holds = [this](double left) { return left <= Rest::kBalanced && rest_.speed_left() <= Rest::kStill; };
  const bool is_held = holds(imbalance);
  if (!is_held && !guesses(&start)) return false;
  Vector z = start;
  if (!is_held) {
    report.add({.iterations = 0, .pivots = 0, .factorizations = 1}, "");
    rest_.bring_into_cones(z);
    if (!loaded_sticking().balance(z, 1, rest_.touching()) || !holds(rest_.imbalance(z))) return false;
  }
  if (!passes(z, answer) || answer.claim != Claim::kSolved) return false;
  rest_.write_velocity(answer.velocity);
  ++report.sticking;
  return true;
}

bool IslandSolver::guesses(const Vector* start) const {
  if (start == nullptr || pauses_) return false;
  const ContactProblem& contact = *problem_->contact();
  return StickingContacts::is_worth_a_guess(contact, !waits_) && StickingContacts::sticking(contact, v_, *start);
}

/// Whether the contacts that pressed in the last step hold again.
bool IslandSolver::sticks_again(const Vector& start, const AutoLimits& limits, Answer& answer, AutoReport& report) {
  Counters work{.iterations = 0, .pivots = 0, .factorizations = 0};
  const int tries = StickingContacts::is_worth_a_guess(*problem_->contact(), true) ? kStickingTries : 1;
  const bool found = loaded_sticking().solve(start, tries, limits.deadline_s, answer, work);
  report.add(work, "");
  if (!found) return false;
  const ContactProblem& contact = *problem_->contact();
  if (Rest::takes(contact) && Rest::may_hold(contact, v_, answer.z)) {
    const double imbalance = loaded_rest().imbalance(answer.z);
    rested_ = imbalance <= Rest::kBalanced && rest_.speed_left() <= Rest::kStill;
    if (rested_) rest_.write_velocity(answer.velocity);
    if (!rested_ && imbalance <= Rest::kNear) return false;  // from nothing it may rest exactly
  }
  ++report.sticking;
  return true;
}

/// Likely, of the convex problem of rest; infinity where the method does not take it.
double IslandSolver::work_of_active_sets() const {
  const bool is_small = Methods::takes(AutoMethod::kContactLemke, *problem_);
  return is_small ? kPriceOfLeastEnergy * LeastEnergy::work(*problem_->contact(), idle_) : kInfinity;
}

double IslandSolver::work_of_interior_point() const {
  return order_.has(AutoMethod::kFrictionIpm) ? order_.likely_work_of_rest() : kInfinity;
}

/// Whether the impulses of least energy are an answer: they are unless a contact with friction presses and slips.
bool IslandSolver::rests(bool is_warm, const AutoLimits& limits, Answer& answer, AutoReport& report) {
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
bool IslandSolver::rests_by_interior_point(const AutoLimits& limits, Answer& answer, AutoReport& report) {
  if (!order_.has(AutoMethod::kFrictionIpm)) return false;
  const Progress progress = progress_[static_cast<std::size_t>(AutoMethod::kFrictionIpm)];
  const bool has_answer = std::ranges::any_of(progress_, [](Progress each) { return each != Progress::kNone; });
  auto& ipm = static_cast<FrictionIpmSolver&>(methods_->loaded(AutoMethod::kFrictionIpm));
  if (progress == Progress::kNone) report.count(AutoMethod::kFrictionIpm);
  const AutoMethod answered_by = std::exchange(answered_by_, AutoMethod::kFrictionIpm);
  const auto held = std::make_unique<Answer>();
  for (const double error : {aim_of(limits.error), kFinestError}) {
    if (error != kFinestError && progress == Progress::kEnded) continue;
    // The answer of another method has led to no proof.
    const auto is_refuted = [&](const Vector& z) { return !has_answer && is_refuted_near(z); };
    if (!ipm.solve_convex({.error = error, .deadline_s = limits.deadline_s}, is_refuted, *held)) break;
    const bool claimed = held->claim == Claim::kSolved;
    if (!claimed) {
      if (!(ipm.residual(*held) < kNearlyConvex)) break;
      held->velocity.resize(0);
      held->claim = Claim::kSolved;
    }
    if (claimed && slips(*held)) break;
    const bool is_settled = settle_at_rest(*held, report);
    if (!rested_ && !(is_settled && claimed)) continue;
    if (!claimed) {  // momentum in balance leaves a light body more speed than an answer may have
      rested_ = passes(Vector(held->z), *held) && held->claim == Claim::kSolved;
      if (!rested_) continue;
      rest_.write_velocity(held->velocity);
    }
    answer = *held;
    return true;
  }
  knows_no_rest_ = true;
  answered_by_ = answered_by;
  return false;
}

/// Whether the velocity of these impulses shows that contacts cannot all rest: they tend to ones with which all part.
bool IslandSolver::is_refuted_near(const Vector& z) {
  answered_u_.resize(problem_->contact()->ngc());
  methods_->respond(answered_by_, z, answered_u_);
  return loaded_rest().is_refuted(answered_u_);
}

/// Whether some contact slips without parting at mu times the speed of its slip: only then is the answer not that of
/// least energy. Leaves its velocity in answered_u_ if it was needed.
bool IslandSolver::slips(const Answer& answer) {
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
void IslandSolver::find_velocity(const Answer& answer) {
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
bool IslandSolver::may_rest_instead(const Answer& answer) {
  if (knows_no_rest_ || answered_by_ == AutoMethod::kFrictionIpm) return false;
  if (!Rest::takes(*problem_->contact()) || !loaded_rest().is_possible()) return false;
  find_velocity(answer);
  return !rest_.is_refuted(answered_u_);
}

/// Solves the convex problem of rest, by what takes less work; by the other if that decides nothing. @returns whether
/// its solution is an answer
bool IslandSolver::find_rest(const AutoLimits& limits, Answer& answer, AutoReport& report) {
  const ContactProblem& contact = *problem_->contact();
  const double by_active_sets = LeastEnergy::takes(contact) ? work_of_active_sets() : kInfinity;
  const double by_ipm = work_of_interior_point();
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
bool IslandSolver::balance(double imbalance, Answer& answer, AutoReport& report) {
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
    if (!loaded_sticking().balance(held_->z, power, rest_.touching()) ||
        !(rest_.imbalance(held_->z) <= Rest::kBalanced))
      continue;
    if (!passes(Vector(held_->z), *held_) || held_->claim != Claim::kSolved) continue;
    answer.z = held_->z;
    return true;
  }
  is_unsettled_ = !is_precise;
  return false;
}

/// Makes an answer that rests but for rounding or an iterative method's error rest exactly: impulses nearby that
/// balance the momentum to rounding, and the velocity zero. @returns false if it nearly rests, and none were found
bool IslandSolver::settle_at_rest(Answer& answer, AutoReport& report) {
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

}  // namespace lcpbench
