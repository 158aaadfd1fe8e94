#include "native/auto/sticking_contacts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <variant>

#include "native/contacts/contact_impulses.h"

namespace lcpbench {
namespace {

// Sizes of an island, contacts times coordinates, from which a guess takes less time than contact_lemke.

/// Where contact_lemke is loaded already.
constexpr Index kLeastLoaded = 800;
/// Where it is not: with separate bodies, and with one block of G, such as a robot's.
constexpr Index kLeastUnloaded = 200;
constexpr Index kLeastUnloadedBlock = 30;

/// W of the contact with the largest normal impulse, relative to its effective mass 1 / (a'G*a). With S = A'G*A, a step
/// multiplies A'u + b of the sticking contacts by (I + S W)^-1.
constexpr double kStiffness = 1e9;
/// Contacts with a smaller share of the largest normal impulse are weighted as if they had this share.
constexpr double kLeastLoad = 1e-2;
/// Likewise in balance(), over the heaviest coordinate, by its power.
constexpr std::array kStiffBalance{1e10, 1e14};
/// Contacts that touch take at least changes as if they had this share of the largest normal impulse: a brick at the
/// edge of what carries it needs them.
constexpr double kLeastShare = 1e-6;
constexpr int kMaxBalances = 24, kMaxRounds = 16;
constexpr int kMaxSteps = 8;

/// Velocities A'u + b, relative to scale_: at the first no further step is taken, at the second the guess may stand.
constexpr double kStickingStill = 1e-15;
constexpr double kLargestHeldSpeed = 1e-9;
/// A step that does not reduce them by this factor is limited by rounding.
constexpr double kProgress = 0.5;

/// Relative to the largest normal impulse: a smaller pull, and a smaller excess of friction over mu f_N, is rounding.
constexpr double kNoImpulse = 1e-9;
/// Relative to the same: an impulse that is further outside of its cone after the first step refutes the guess, since
/// later steps change impulses too little to bring it back.
constexpr double kFarOut = 1e-3;
/// To what part of the boundary of its cone friction that balance() found outside is brought.
constexpr double kInside = 1 - 1e-3;
/// The least share of contacts that pressed in the last answer.
constexpr double kLeastPressing = 0.25;
/// In the last answer a lambda above this part of max|v| is slip.
constexpr double kSlip = 1e-6;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

}  // namespace

void ColumnImpulses::load(const ContactProblem& contact) {
  contact_ = &contact;
  impulses_.resize(system_.column_count());
}

void ColumnImpulses::read(const Vector& z) {
  Index direction = contact_->nc();
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    double* const f = of(c);
    const int edges = contact_->edges[c];
    f[0] = z(static_cast<Index>(c));
    for (int t = 0; t + 1 < system_.contacts()[c].columns; ++t) {
      f[1 + t] = z(direction + t) - z(direction + edges / 2 + t);
    }
    direction += edges;
  }
}

/// Impulses along a direction d, of which A has one of each pair d and -d, go to d where positive, else to -d.
void ColumnImpulses::write(Vector& z) const {
  z.setZero();
  Index direction = contact_->nc();
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    const StickingColumns& contact = system_.contacts()[c];
    const double* const f = impulses_.data() + contact.first;
    const int edges = contact_->edges[c];
    z(static_cast<Index>(c)) = f[0];
    for (int t = 0; t + 1 < contact.columns; ++t) {
      z(direction + t) = std::max(f[1 + t], 0.0);
      z(direction + edges / 2 + t) = std::max(-f[1 + t], 0.0);
    }
    direction += edges;
  }
}

double ColumnImpulses::friction(std::size_t contact) const {
  const StickingColumns& columns = system_.contacts()[contact];
  double sum = 0;
  for (int t = 1; t < columns.columns; ++t) sum += std::abs(impulses_[columns.first + at(t)]);
  return sum;
}

void ColumnImpulses::scale_friction(std::size_t contact, double factor) {
  double* const f = of(contact);
  for (int t = 1; t < system_.contacts()[contact].columns; ++t) f[t] *= factor;
}

double ColumnImpulses::largest_normal() const {
  double largest = 0;
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) largest = std::max(largest, normal(c));
  return largest;
}

bool ColumnImpulses::are_in_cones(double tolerance) const {
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    const double upper_bound = contact_->mu(static_cast<Index>(c)) * std::max(normal(c), 0.0);
    if (normal(c) < -tolerance || friction(c) > upper_bound + tolerance) return false;
  }
  return true;
}

bool ColumnImpulses::bring_inside() {
  bool were_inside = true;
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    double& f = *of(c);
    const double sum = friction(c), upper_bound = contact_->mu(static_cast<Index>(c)) * f;
    if (f >= 0 && sum <= upper_bound) continue;
    were_inside = false;
    f = std::max(f, 0.0);
    scale_friction(c, sum > 0 ? kInside * std::max(upper_bound, 0.0) / sum : 0);
  }
  return were_inside;
}

bool StickingContacts::takes(const ContactProblem& contact) {
  return std::holds_alternative<BlockInertia>(contact.inertia) || std::holds_alternative<DenseInertia>(contact.inertia);
}

bool StickingContacts::is_worth_a_guess(const ContactProblem& contact, bool is_loaded) {
  const auto* bodies = std::get_if<BlockInertia>(&contact.inertia);
  const Index unloaded = bodies == nullptr || bodies->blocks.size() == 1 ? kLeastUnloadedBlock : kLeastUnloaded;
  const Index least = is_loaded ? kLeastLoaded : unloaded;
  return contact.frictional() && !contact.is_soft() && contact.nc() * contact.ngc() >= least && takes(contact);
}

bool StickingContacts::sticking(const ContactProblem& contact, const Vector& v, const Vector& start) {
  if (start.size() != lcp_size(contact) || !start.allFinite()) return false;
  const double largest_slip = kSlip * v.lpNorm<Eigen::Infinity>();
  Index lambda = contact.nc() + cols(contact.D);
  Index pressed = 0;
  for (Index c = 0; c < contact.nc(); ++c) {
    pressed += start(c) > 0 ? 1 : 0;
    if (contact.edges[at(c)] == 0) continue;
    if (start(c) > 0 && contact.mu(c) > 0 && !(start(lambda) <= largest_slip)) return false;
    ++lambda;
  }
  return pressed > 0 && static_cast<double>(pressed) >= kLeastPressing * static_cast<double>(contact.nc());
}

void StickingContacts::load(const Problem& problem, const Vector& v) {
  problem_ = &problem;
  contact_ = problem.contact();
  has_test_ = false;
  if (!follow_) from_nothing_ = true;
  system_.load(*contact_);
  impulses_.load(*contact_);
  velocities_.resize(system_.column_count());
  scaled_.resize(system_.column_count());
  sticking_.resize(system_.contacts().size());
  weights_.resize(system_.contacts().size());
  for (Vector* room : {&v_, &u_, &step_, &residual_}) room->setZero(contact_->ngc());
  set_velocity(v);
}

void StickingContacts::set_velocity(const Vector& v) {
  v_ = v;
  if (has_test_) test_.set_velocity(v);
}

bool StickingContacts::solve(const Vector& start, int tries, double deadline_s, Answer& answer, Counters& work) {
  find_velocities(v_);
  scale_ = 0;
  for (const double q : velocities_) scale_ = max_or_infinity(scale_, std::abs(q));
  if (!(scale_ > 0 && scale_ <= std::numeric_limits<double>::max())) return false;
  impulses_.read(start);
  for (std::size_t c = 0; c < sticking_.size(); ++c) sticking_[c] = impulses_.normal(c) > 0 ? 1 : 0;
  for (int guess = 0;; ++guess) {
    weigh();
    ++work.factorizations;
    if (!system_.factor(weights_)) return false;
    if (guess == 0 ? starts(start) : is_confirmed(iterate(velocity_residual()))) break;
    if (guess + 1 >= tries) return false;
    find_velocities(u_);
    if (!change_guess()) return false;
  }
  if (!std::holds_alternative<BlockInertia>(contact_->inertia)) {  // AnswerTest finds out whether blocks are definite
    std::fill(weights_.begin(), weights_.end(), 0.0);
    if (!system_.factor(weights_)) return false;
  }
  answer.clear();
  answer.claim = Claim::kSolved;
  answer.z.resize(problem_->size());
  impulses_.write(answer.z);
  if (!has_test_) {
    const bool is_one = !contact_->has_offset();  // else contacts that nothing moves count for themselves
    if (is_one) islands_.take_as_one(*contact_);
    test_.load(*problem_, is_one ? &islands_ : nullptr);
    test_.set_velocity(v_);
    has_test_ = true;
  }
  return test_.settle(answer, deadline_s);
}

/// By the normal impulses: contacts that press more take more of a change.
void StickingContacts::weigh() {
  const double largest = impulses_.largest_normal();
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    const double share = largest > 0 ? impulses_.normal(c) / largest : 1;
    weights_[c] = sticking_[c] != 0 ? kStiffness * system_.strength(c) * std::max(share, kLeastLoad) : 0;
  }
}

/// The first guess, in two ways by the same factors: the least impulses, and those nearest to the last answer's. The
/// way that found the last answer comes first. @pre velocities_ are those of v_
bool StickingContacts::starts(const Vector& start) {
  for (int way = 0; way < 2; ++way) {
    if (way > 0) impulses_.read(start);
    if (way > 0 && from_nothing_) find_velocities(v_);
    if (!from_nothing_) {  // u = v + G* A f
      residual_.setZero();
      system_.add_columns(impulses_.all().data(), residual_);
      u_ = v_;
      system_.add_response(residual_, u_);
    }
    if (is_confirmed(iterate(from_nothing_ ? release_all() : velocity_residual()))) return true;
    from_nothing_ = !from_nothing_;
  }
  return false;
}

/// Takes all impulses away. @pre velocities_ are those of v_ @returns what velocity_residual() would, cheaper
double StickingContacts::release_all() {
  std::fill(impulses_.all().begin(), impulses_.all().end(), 0.0);
  u_ = v_;
  residual_.setZero();
  return held_residual();
}

/// Steps until no sticking contact moves, rounding limits them, or the guess is refuted.
/// @param residual velocity_residual() before them
/// @returns the same after the last, except where the first refutes the guess: then what it was before
double StickingContacts::iterate(double residual) {
  for (int step = 0; step < kMaxSteps && residual > kStickingStill; ++step) {
    const double before = residual;
    improve();
    if (step == 0 && !impulses_.are_in_cones(kFarOut * impulses_.largest_normal())) return residual;
    residual = velocity_residual();
    if (!(residual <= kProgress * before)) break;
  }
  return residual;
}

/// One step of the augmented Lagrangian method: u -= y and f -= W (w - A'y) with (G + A W A') y = A W w - r. W is zero
/// for contacts that do not stick. It leaves r = 0 but for rounding; velocities_ become those of the new u for sticking
/// contacts alone.
/// @pre w = A'u + b is in velocities_ and r in residual_, as velocity_residual() and release_all() leave them
void StickingContacts::improve() {
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    const StickingColumns& contact = system_.contacts()[c];
    for (std::size_t t = contact.first; t < contact.first + at(contact.columns); ++t) {
      scaled_[t] = sticking_[c] != 0 ? weights_[c] * velocities_[t] : 0;
    }
  }
  step_ = -residual_;
  system_.add_columns(scaled_.data(), step_);
  system_.solve(step_);
  u_ -= step_;
  system_.multiply(step_, scaled_.data());
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    if (sticking_[c] == 0) continue;
    const StickingColumns& contact = system_.contacts()[c];
    for (std::size_t t = contact.first; t < contact.first + at(contact.columns); ++t) {
      velocities_[t] -= scaled_[t];
      impulses_.all()[t] -= weights_[c] * velocities_[t];
    }
  }
}

/// The residuals of both equations as velocities at the contacts: A'u + b where they stick, and A'D^-1 r with
/// r = A f - G (u - v) and the diagonal D of G. Leaves r in residual_. @returns the largest of both, relative to scale_
double StickingContacts::velocity_residual() {
  residual_.setZero();
  system_.add_columns(impulses_.all().data(), residual_);
  step_ = u_ - v_;
  system_.subtract_inertia(step_, residual_);
  step_ = residual_;
  system_.respond_by_diagonal(step_);
  system_.multiply(step_, scaled_.data());
  double largest = 0;
  for (const double change : scaled_) largest = max_or_infinity(largest, std::abs(change));
  find_velocities(u_);
  return std::max(held_residual(), largest / scale_);
}

/// The largest velocity of a sticking contact, relative to scale_.
double StickingContacts::held_residual() const {
  double largest = 0;
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    if (sticking_[c] == 0) continue;
    const double* const w = velocities_.data() + system_.contacts()[c].first;
    for (int t = 0; t < system_.contacts()[c].columns; ++t) largest = max_or_infinity(largest, std::abs(w[t]));
  }
  return largest / scale_;
}

/// A'u + b of all contacts, in velocities_.
void StickingContacts::find_velocities(const Vector& u) {
  system_.multiply(u, velocities_.data());
  if (!contact_->has_offset()) return;
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    velocities_[system_.contacts()[c].first] += contact_->offset(static_cast<Index>(c));
  }
}

/// Whether the impulses are in their cones, no sticking contact moves, and no other has a negative clearance().
/// Impulses that are outside by rounding are brought back. @param residual velocity_residual() now
bool StickingContacts::is_confirmed(double residual) {
  bool is_trimmed = false;  // impulses were brought back into their cones
  const double tolerance = kNoImpulse * impulses_.largest_normal();
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    double& f = *impulses_.of(c);
    if (f < -tolerance) return false;
    is_trimmed = is_trimmed || f < 0;
    f = std::max(f, 0.0);
    const double upper_bound = contact_->mu(static_cast<Index>(c)) * f, friction = impulses_.friction(c);
    if (friction <= upper_bound) continue;
    if (!(friction <= upper_bound + tolerance)) return false;
    impulses_.scale_friction(c, upper_bound / friction);
    is_trimmed = true;
  }
  if (!((is_trimmed ? velocity_residual() : residual) <= kLargestHeldSpeed)) return false;
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    if (sticking_[c] == 0 && !(clearance(c) >= -kLargestHeldSpeed * scale_)) return false;
  }
  return true;
}

/// The least of (N + mu d)'u + b over the contact's directions d. Where it is not negative at any contact, w >= 0 and u
/// is of least energy. @pre velocities_ are those of u_, of all contacts
double StickingContacts::clearance(std::size_t contact) const {
  const double* const w = velocities_.data() + system_.contacts()[contact].first;
  double slip = 0;
  for (int t = 1; t < system_.contacts()[contact].columns; ++t) slip = std::max(slip, std::abs(w[t]));
  return w[0] - contact_->mu(static_cast<Index>(contact)) * slip;
}

/// Releases contacts that pull; those with a negative clearance() become sticking ones. @returns whether any changed
/// @pre as clearance()
bool StickingContacts::change_guess() {
  const double largest = impulses_.largest_normal();
  bool changes = false;
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    const bool pulls = sticking_[c] != 0 && impulses_.normal(c) < -kNoImpulse * largest;
    const bool approaches = sticking_[c] == 0 && clearance(c) < -kLargestHeldSpeed * scale_;
    if (pulls) std::fill_n(impulses_.of(c), system_.contacts()[c].columns, 0.0);
    if (pulls || approaches) sticking_[c] = approaches ? 1 : 0;
    changes = changes || pulls || approaches;
  }
  return changes;
}

bool StickingContacts::balance(Vector& z, int power, double touching) {
  impulses_.read(z);
  const double largest = impulses_.largest_normal();
  if (!(largest > 0)) return false;
  double heaviest = 0;
  for (Index i = 0; i < v_.size(); ++i) heaviest = std::max(heaviest, system_.mass(i));
  // So large that G matters little beside A W A': the contacts alone then decide where the changes go.
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    const double share = std::max(impulses_.normal(c) / largest, kLeastShare);
    const bool touches = contact_->offset(static_cast<Index>(c)) <= touching;
    weights_[c] = touches ? kStiffBalance[at(power - 1)] * heaviest * std::pow(share, power) : 0;
  }
  if (!system_.factor(weights_)) return false;
  for (int round = 0; round < kMaxRounds; ++round) {
    add_missing_momentum();
    if (impulses_.bring_inside()) {
      impulses_.write(z);
      return true;
    }
  }
  return false;
}

/// Steps towards A f = -G v, until the residual gets no smaller.
void StickingContacts::add_missing_momentum() {
  double last = std::numeric_limits<double>::infinity();
  for (int step = 0; step < kMaxBalances; ++step) {
    residual_.setZero();
    system_.add_columns(impulses_.all().data(), residual_);
    step_ = -v_;
    system_.subtract_inertia(step_, residual_);
    step_ = -residual_;
    system_.respond_by_diagonal(residual_);
    const double missing = std::sqrt(std::abs(residual_.dot(step_)));
    if (!(missing > 0 && missing <= kProgress * last)) return;
    last = missing;
    system_.solve(step_);
    system_.multiply(step_, scaled_.data());
    for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
      const StickingColumns& contact = system_.contacts()[c];
      for (std::size_t t = contact.first; t < contact.first + at(contact.columns); ++t) {
        impulses_.all()[t] += weights_[c] * scaled_[t];
      }
    }
  }
}

}  // namespace lcpbench
