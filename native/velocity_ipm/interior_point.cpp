#include "native/velocity_ipm/interior_point.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/entries.h"
#include "core/timed_solve.h"
#include "native/contacts/contact_impulses.h"

namespace lcpbench {
namespace {

/// kShift max|M_ii| I is added to M in each step. Without it contacts that push against each other would have no
/// central path.
constexpr double kShift = 1e-12;

constexpr double kBoundaryFraction = 0.995;  // of the step to the nearest boundary [Mehrotra 1992]
constexpr double kShortestStep = 0x1p-26;    // shorter ones were cut by rounding, not by the problem

// So many steps without the residual falling to a half: no solution (the impulses grow without bound), or rounding.
constexpr int kMostIdleSteps = 25;
constexpr double kProgress = 0.5;
/// Of begin_near(): the residual of the point to start from, over the residual that the change of q makes.
constexpr double kRoom = 3;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

void InteriorPoint::load(std::unique_ptr<WhitenedNormals> normals, const ContactProblem& contact,
                         CoupledCompliance coupled) {
  coupled_ = std::move(coupled);
  normals_ = std::move(normals);
  keeps_points_ = false;
  if (!loaded()) return;
  N_ = contact.N;
  b_ = contact.b;
  cost_ = normals_->cost();
  units_.load(contact);
  compliance_ = contact.compliance_n;
  diagonal_ = normals_->squared_norms();
  if (compliance_.size() > 0) diagonal_ += compliance_;
  if (!coupled_.empty()) diagonal_ += coupled_.diagonal();
  shifts_.setConstant(contact.nc(), contact.nc() > 0 ? kShift * diagonal_.maxCoeff() : 0);
  if (compliance_.size() > 0) shifts_ += compliance_;
  for (Point* point : {&point_, &step_}) point->resize(contact.nc(), normals_->coordinates());
  for (Vector* vector : {&primal_residual_, &target_, &contacts_, &q_, &best_impulses_}) {
    vector->resize(contact.nc());
  }
  for (Vector* vector : {&dual_residual_, &coordinates_}) vector->resize(normals_->coordinates());
  set_velocity(contact.v);
}

void InteriorPoint::set_velocity(const Vector& v) {
  project_velocity(v);
  units_.clear();
  IslandUnits::Row largest;
  for (Index j = 0; j < q_.size(); ++j) {
    double velocity = 0, terms = 0, entries = 0;
    for_each_entry(N_, j, [&](Index i, double entry) {
      velocity += entry * v_(i);
      terms += std::abs(entry * v_(i));
      ++entries;
    });
    const double offset = b_.size() > 0 && !is_idle(j) ? b_(j) : 0;
    const IslandUnits::Row row = row_of_units(true, velocity, terms, entries, offset, std::abs(offset));
    largest.approach = max_or_infinity(largest.approach, row.approach);
    largest.floor = max_or_infinity(largest.floor, row.floor);
    units_.add_row(j, row);
  }
  scale_ = largest.approach > 0 ? std::max(largest.approach, largest.floor) : 0;
  if (units_.several()) scale_islands();
  measure_q(0);
}

void InteriorPoint::set_velocity(const Vector& v, const Vector& offset, double scale, double speed) {
  units_.clear();
  project_velocity(v);
  q_ += offset;
  scale_ = scale;
  measure_q(speed);
}

/// v_ = v, q_ = N'v + b.
void InteriorPoint::project_velocity(const Vector& v) {
  v_ = v;
  std::visit([&](const auto& N) { q_.noalias() = N.transpose() * v; }, N_);
  if (b_.size() > 0) q_ += b_;
}

void InteriorPoint::scale_islands() {
  units_.choose(v_);
  if (units_.largest_scale() > 0) scale_ = units_.largest_scale();
  units_.scale(v_);
  for (Index j = 0; j < q_.size(); ++j) q_(j) *= units_.of_contact(j);
}

/// @param f in the units of the islands
void InteriorPoint::write_impulses(const Vector& f, Vector& z) const {
  z = f;
  if (!units_.several()) return;
  for (Index j = 0; j < q_.size(); ++j) z(j) /= units_.of_contact(j);
}

/// Whether nothing moves the contact, and its q, a positive offset, asks for nothing.
bool InteriorPoint::is_idle(Index contact) const {
  return b_.size() > 0 && diagonal_(contact) == 0 && q_(contact) > 0;
}

/// speed_: the largest |q|, but no more than kFar times the largest approach and `speed`: a contact may be open by far
/// more. 0 where z = 0 is the solution of all that is asked. Infinity also for NaN, which must not pass for zero. An
/// idle contact's offset is cut to it.
void InteriorPoint::measure_q(double speed) {
  constexpr double kFar = 100;
  double largest = 0, approach = 0;
  for (Index i = 0; i < q_.size(); ++i) {
    if (is_idle(i)) continue;
    largest = max_or_infinity(largest, std::abs(q_(i)));
    approach = max_or_infinity(approach, -q_(i));
  }
  speed_ = scale_ > 0 ? std::min(largest, kFar * std::max(approach, speed)) : 0;
  for (Index i = 0; i < q_.size(); ++i) {
    if (is_idle(i)) q_(i) = std::min(q_(i), speed_);
  }
}

/// y = 0, s of the size of q, and f such that f and s are as far from their boundaries in the same unit; less far where
/// a contact is open by more than any other approaches. The solution where nothing approaches.
void InteriorPoint::set_start() {
  if (speed_ == 0) {
    for (Vector* vector : {&point_.f, &point_.s, &point_.y}) vector->setZero();
    return;
  }
  const double largest = diagonal_.maxCoeff();
  point_.y.setZero();
  point_.s = q_.cwiseAbs().cwiseMax(0.1 * speed_);
  for (Index i = 0; i < q_.size(); ++i) {
    const double stops = point_.s(i) > speed_ ? speed_ * (speed_ / point_.s(i)) : point_.s(i);
    point_.f(i) = stops / (diagonal_(i) > 0 ? diagonal_(i) : largest);
  }
}

/// @pre relative_residual(point_.f)
void InteriorPoint::evaluate_residuals() {
  dual_residual_ = point_.y - coordinates_;
  normals_->project(point_.y, primal_residual_);
  work_ += cost_.product;
  add_yielding(point_.f, primal_residual_);
  primal_residual_ += q_ - point_.s;
}

bool InteriorPoint::factor(Counters& counters) {
  ++counters.factorizations;
  work_ += cost_.factor;
  contacts_.array() = point_.f.array() / (point_.s.array() + shifts_.array() * point_.f.array());
  return contacts_.allFinite() && factor_with(contacts_);
}

bool InteriorPoint::factor_with(const Vector& weights) {
  if (coupled_.empty()) return normals_->factor(weights);
  return coupled_.factor(weights) && normals_->factor_coupled(coupled_);
}

/// The Newton step towards f s + target_, residuals zero.
void InteriorPoint::find_direction() {
  const auto f = point_.f.array();
  const auto denominator = point_.s.array() + shifts_.array() * f;
  const auto solve_for_impulses = [this, f, denominator](const Vector& velocities, Vector& impulses) {
    if (coupled_.empty()) {
      impulses.array() = (target_.array() - f * velocities.array()) / denominator;
    } else {
      impulses.array() = target_.array() / f - velocities.array();
      coupled_.apply_weights(impulses);
    }
  };
  solve_for_impulses(primal_residual_, contacts_);
  normals_->combine(contacts_, step_.y);
  step_.y -= dual_residual_;
  normals_->solve(step_.y);
  normals_->project(step_.y, step_.s);
  work_ += 2 * cost_.product + cost_.solve;
  contacts_ = step_.s + primal_residual_;
  solve_for_impulses(contacts_, step_.f);
  step_.s += primal_residual_ + shifts_.cwiseProduct(step_.f);
  if (!coupled_.empty()) coupled_.add_product(step_.f, step_.s);
}

/// The longest step <= 1 that leaves f and s nonnegative.
double InteriorPoint::longest_step() const {
  double step = 1.0;
  for (Index i = 0; i < q_.size(); ++i) {
    if (step_.f(i) < 0) step = std::min(step, -point_.f(i) / step_.f(i));
    if (step_.s(i) < 0) step = std::min(step, -point_.s(i) / step_.s(i));
  }
  return step;
}

double InteriorPoint::gap_after(double step) const {
  return (point_.f + step * step_.f).dot(point_.s + step * step_.s);
}

/// s += R f
void InteriorPoint::add_yielding(const Vector& f, Vector& s) const {
  if (compliance_.size() > 0) s += compliance_.cwiseProduct(f);
  if (!coupled_.empty()) coupled_.add_product(f, s);
}

/// max |min(M_ii f_i, w_i)| over the scale, with w = M f + q: the evaluation's measure, in double. Infinity for NaN.
/// Leaves W f in coordinates_ and M f in contacts_.
double InteriorPoint::relative_residual(const Vector& f) {
  normals_->combine(f, coordinates_);
  normals_->project(coordinates_, contacts_);
  add_yielding(f, contacts_);
  work_ += 2 * cost_.product;
  double worst = 0;
  for (Index i = 0; i < q_.size(); ++i) {
    const double off = std::abs(std::min(contacts_(i) + q_(i), diagonal_(i) * f(i)));
    if (!std::isfinite(off)) return kInfinity;
    worst = std::max(worst, off);
  }
  return worst / scale_;
}

void InteriorPoint::keep_points() {
  keeps_points_ = true;
  for (Kept& kept : kept_) kept.point.resize(q_.size(), normals_->coordinates());
}

/// Keeps the point in the place for residuals of its size. Points with smaller residuals are of an older offset and go.
void InteriorPoint::keep(double residual) {
  const int quarters = residual < 1 ? -std::ilogb(residual) / 2 : 0;
  const std::size_t at = std::min(static_cast<std::size_t>(quarters), kKept - 1);
  kept_[at].point = point_;
  kept_[at].residual = residual;
  for (std::size_t k = at + 1; k < kKept; ++k) kept_[k].residual = 0;
}

void InteriorPoint::forget_steps() {
  best_ = least_residual_ = kInfinity;
  idle_steps_ = 0;
}

void InteriorPoint::begin() {
  for (Kept& kept : kept_) kept.residual = 0;
  set_start();
  forget_steps();
}

void InteriorPoint::begin_near(double residual) {
  const Kept* nearest = nullptr;
  for (const Kept& kept : kept_) {
    if (kept.residual > 0 && (nearest == nullptr || kept.residual >= kRoom * residual)) nearest = &kept;
  }
  if (nearest == nullptr || speed_ == 0) return begin();  // without an approach z = 0, whatever was kept
  point_ = nearest->point;
  forget_steps();
}

InteriorPoint::Stop InteriorPoint::iterate(double work, double deadline_s, std::int64_t max_iterations,
                                           Counters& counters) {
  if (speed_ == 0) return Stop::kConverged;
  const double contacts = static_cast<double>(q_.size());
  for (const double end = work_ + work;;) {
    const double residual = relative_residual(point_.f);
    if (residual <= settings_.tolerance) return Stop::kConverged;
    idle_steps_ = residual < kProgress * best_ ? 0 : idle_steps_ + 1;
    best_ = std::min(best_, residual);
    if (idle_steps_ > kMostIdleSteps) return Stop::kStalled;
    if (counters.iterations >= max_iterations) return Stop::kIterationLimit;
    if (!(wall_clock_s() < deadline_s)) return Stop::kTimeLimit;
    if (keeps_points_) keep(residual);
    evaluate_residuals();
    if (!factor(counters)) return Stop::kBreakdown;
    const double gap = point_.f.dot(point_.s);
    target_ = -point_.f.cwiseProduct(point_.s);
    find_direction();
    const double predicted = gap_after(longest_step()) / gap;
    const double centering = predicted * predicted * predicted;  // [Mehrotra 1992]
    target_.array() += centering * gap / contacts - step_.f.array() * step_.s.array();
    find_direction();
    const double length = std::min(1.0, kBoundaryFraction * longest_step());
    if (!(step_.f.allFinite() && step_.s.allFinite())) return Stop::kBreakdown;
    if (!(length >= kShortestStep) || !(gap > std::numeric_limits<double>::min())) return Stop::kStalled;
    point_.f += length * step_.f;
    point_.s += length * step_.s;
    point_.y += length * step_.y;
    ++counters.iterations;
    if (work_ >= end) return Stop::kWorkLimit;
  }
}

void InteriorPoint::pressed_contacts(Vector& f) const {
  for (Index i = 0; i < q_.size(); ++i) f(i) = diagonal_(i) * point_.f(i) > point_.s(i) ? point_.f(i) : 0;
}

/// Brings the velocities of the pressed contacts to zero: M df = -w on them, solved as the least-squares problem that
/// redundant contacts make of it, (M + I / weight) df = -w, in velocity space, to which R adds as 1 / weight does. The
/// steps repair what the weight leaves; it stands 1e8 above the diagonal of M, halfway in digits between the problem
/// and its rounding.
void InteriorPoint::finish(Counters& counters) {
  constexpr double kWeight = 1e8;
  constexpr int kRounds = 6;
  if (speed_ == 0) return;
  double best = relative_residual(point_.f);
  Vector& f = step_.f;
  Vector& weights = step_.s;
  pressed_contacts(f);
  const double largest = diagonal_.maxCoeff();
  for (Index i = 0; i < f.size(); ++i) {
    const double yields = compliance_.size() > 0 ? compliance_(i) : 0;
    weights(i) = f(i) > 0 ? kWeight / (largest + kWeight * yields) : 0;
  }
  ++counters.factorizations;
  work_ += cost_.factor;
  if (!factor_with(weights)) return;
  const auto weigh = [&](Vector& velocities) {
    if (coupled_.empty()) {
      velocities = weights.cwiseProduct(velocities);
    } else {
      coupled_.apply_weights(velocities);
    }
  };
  for (int round = 0; round < kRounds; ++round) {
    target_ = f.cwiseMax(0.0);
    const double residual = relative_residual(target_);
    if (residual < best) {
      best = residual;
      point_.f = target_;
    } else if (round > 0) {
      return;
    }
    // df = -weights (w + W'dy) with (I + W weights W') dy = -W weights w.
    contacts_ += q_;
    weigh(contacts_);
    f = target_ - contacts_;
    normals_->combine(contacts_, step_.y);
    normals_->solve(step_.y);
    normals_->project(step_.y, contacts_);
    work_ += 2 * cost_.product + cost_.solve;
    weigh(contacts_);
    f += contacts_;
  }
}

void InteriorPoint::drop_parting() {
  pressed_contacts(step_.f);
  point_.f.swap(step_.f);
}

bool InteriorPoint::iterated(Stop stop, Answer& answer) {
  stop_ = stop;
  if (speed_ == 0) {  // z = 0 solves it
    answer.claim = Claim::kSolved;
    return false;
  }
  write_impulses(point_.f, answer.z);
  if (stop_ != Stop::kIterationLimit && stop_ != Stop::kTimeLimit) return true;
  answer.claim = stop_ == Stop::kTimeLimit ? Claim::kTimeLimit : Claim::kIterationLimit;
  return false;
}

double InteriorPoint::best(Vector& z) {
  if (speed_ == 0) {
    z.setZero();
    return 0;
  }
  pressed_contacts(step_.f);
  for (const Vector* impulses : {&point_.f, &step_.f}) {
    const double residual = relative_residual(*impulses);
    if (!(residual < least_residual_)) continue;
    least_residual_ = residual;
    best_impulses_ = *impulses;
  }
  if (least_residual_ < kInfinity) write_impulses(best_impulses_, z);
  return least_residual_;
}

void InteriorPoint::conclude(Answer& answer) {
  write_impulses(point_.f, answer.z);
  const double residual = relative_residual(point_.f);
  answer.claim = residual <= accepted_ ? Claim::kSolved : Claim::kNumericalFailure;
  if (stop_ == Stop::kStalled) answer.detail = "no step goes further";
  if (stop_ == Stop::kBreakdown) answer.detail = "the Newton system could not be solved";
}

}  // namespace lcpbench
