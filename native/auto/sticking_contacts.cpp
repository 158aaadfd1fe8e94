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
constexpr int kMostBalances = 24, kMostRounds = 16;
constexpr int kMostSteps = 8;

/// Velocities A'u + b, relative to scale_: at the first no further step is taken, at the second the guess may stand.
constexpr double kStickingStill = 1e-15;
constexpr double kLargestMiss = 1e-9;
/// A step that does not reduce them by this factor is limited by rounding.
constexpr double kProgress = 0.5;

/// Relative to the largest normal impulse: a smaller pull, and a smaller excess of friction over mu f_N, is rounding.
constexpr double kNoImpulse = 1e-9;
/// Relative to the same: an impulse that is further outside of its cone after the first step refutes the guess.
constexpr double kFarOut = 1e-3;
/// The least share of contacts that pressed in the last answer.
constexpr double kLeastPressing = 0.25;
/// In the last answer a lambda above this part of max|v| is slip.
constexpr double kSlip = 1e-6;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

}  // namespace

bool StickingContacts::is_worth_a_guess(const ContactProblem& contact, bool is_loaded) {
  const auto* bodies = std::get_if<BlockInertia>(&contact.inertia);
  const Index unloaded = bodies == nullptr || bodies->blocks.size() == 1 ? kLeastUnloadedBlock : kLeastUnloaded;
  const Index least = is_loaded ? kLeastLoaded : unloaded;
  return contact.frictional() && !contact.is_soft() && contact.nc() * contact.ngc() >= least && takes(contact);
}

bool StickingContacts::takes(const ContactProblem& contact) {
  return std::holds_alternative<BlockInertia>(contact.inertia) || std::holds_alternative<DenseInertia>(contact.inertia);
}

void StickingContacts::load(const Problem& problem, const Vector& v) {
  problem_ = &problem;
  contact_ = problem.contact();
  has_test_ = false;
  if (!follow_) from_loads_ = true;
  system_.load(*contact_);
  take_room();
  set_velocity(v);
}

void StickingContacts::take_room() {
  impulses_.resize(system_.column_count());
  misses_.resize(system_.column_count());
  scaled_.resize(system_.column_count());
  sticking_.resize(system_.contacts().size());
  weights_.resize(system_.contacts().size());
  for (Vector* room : {&v_, &u_, &step_, &residual_}) room->setZero(contact_->ngc());
}

void StickingContacts::set_velocity(const Vector& v) {
  v_ = v;
  if (has_test_) test_.set_velocity(v);
}

/// A'u + b of all contacts, in misses_.
void StickingContacts::find_misses(const Vector& u) {
  system_.multiply(u, misses_.data());
  if (!contact_->has_offset()) return;
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) misses_[system_.contacts()[c].first] += offset(c);
}

/// Sets scale_, and leaves A'v + b in misses_.
void StickingContacts::measure_scale() {
  find_misses(v_);
  scale_ = 0;
  for (const double q : misses_) scale_ = max_or_infinity(scale_, std::abs(q));
}

bool StickingContacts::sticking(const ContactProblem& contact, const Vector& v, const Vector& start) {
  if (start.size() != lcp_size(contact) || !start.allFinite()) return false;
  const double most = kSlip * v.lpNorm<Eigen::Infinity>();
  Index lambda = contact.nc() + cols(contact.D);
  Index pressed = 0;
  for (Index c = 0; c < contact.nc(); ++c) {
    pressed += start(c) > 0 ? 1 : 0;
    if (contact.edges[at(c)] == 0) continue;
    if (start(c) > 0 && contact.mu(c) > 0 && !(start(lambda) <= most)) return false;
    ++lambda;
  }
  return pressed > 0 && static_cast<double>(pressed) >= kLeastPressing * static_cast<double>(contact.nc());
}

/// The impulses of the last answer; contacts that pressed in it are taken to stick.
void StickingContacts::take_start(const Vector& start) {
  const Index nc = contact_->nc();
  Index direction = nc;
  for (Index c = 0; c < nc; ++c) {
    const StickingColumns& contact = system_.contacts()[at(c)];
    double* const f = impulses_.data() + contact.first;
    const int edges = contact_->edges[at(c)];
    f[0] = start(c);
    for (int t = 0; t + 1 < contact.columns; ++t) f[1 + t] = start(direction + t) - start(direction + edges / 2 + t);
    sticking_[at(c)] = f[0] > 0 ? 1 : 0;
    direction += edges;
  }
}

double StickingContacts::largest_load() const {
  double largest = 0;
  for (const StickingColumns& contact : system_.contacts()) largest = std::max(largest, impulses_[contact.first]);
  return largest;
}

/// By the normal impulses: contacts that press more take more of a change.
void StickingContacts::weigh() {
  const double largest = largest_load();
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    const double share = largest > 0 ? impulses_[system_.contacts()[c].first] / largest : 1;
    weights_[c] = sticking_[c] != 0 ? kStiffness * system_.strength(c) * std::max(share, kLeastLoad) : 0;
  }
}

/// u := v + G* A f
void StickingContacts::respond() {
  residual_.setZero();
  system_.add_columns(impulses_.data(), residual_);
  u_ = v_;
  system_.add_response(residual_, u_);
}

/// The residuals of both equations as velocities at the contacts: A'u + b where they stick, and A'D^-1 r with
/// r = A f - G (u - v) and the diagonal D of G. Leaves r in residual_. @returns the largest of both, relative to scale_
double StickingContacts::miss() {
  residual_.setZero();
  system_.add_columns(impulses_.data(), residual_);
  step_ = u_ - v_;
  system_.subtract_inertia(step_, residual_);
  step_ = residual_;
  system_.respond_by_diagonal(step_);
  system_.multiply(step_, scaled_.data());
  double largest = 0;
  for (const double change : scaled_) largest = max_or_infinity(largest, std::abs(change));
  find_misses(u_);
  return std::max(largest_held_miss(), largest / scale_);
}

double StickingContacts::largest_held_miss() const {
  double largest = 0;
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    if (sticking_[c] == 0) continue;
    const double* const w = misses_.data() + system_.contacts()[c].first;
    for (int t = 0; t < system_.contacts()[c].columns; ++t) largest = max_or_infinity(largest, std::abs(w[t]));
  }
  return largest / scale_;
}

/// One step of the augmented Lagrangian method: u -= y and f -= W (w - A'y) with (G + A W A') y = A W w - r. W is zero
/// for contacts that do not stick. It leaves r = 0 but for rounding; misses_ becomes that of the new u for sticking
/// contacts alone.
/// @pre w = A'u + b is in misses_ and r in residual_, as miss() and let_go() leave them
void StickingContacts::improve() {
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    const StickingColumns& contact = system_.contacts()[c];
    for (std::size_t t = contact.first; t < contact.first + at(contact.columns); ++t) {
      scaled_[t] = sticking_[c] != 0 ? weights_[c] * misses_[t] : 0;
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
      misses_[t] -= scaled_[t];
      impulses_[t] -= weights_[c] * misses_[t];
    }
  }
}

/// Takes all impulses away. @pre measure_scale() was the last to fill misses_ @returns what miss() would, cheaper
double StickingContacts::let_go() {
  std::fill(impulses_.begin(), impulses_.end(), 0.0);
  u_ = v_;
  residual_.setZero();
  return largest_held_miss();
}

/// Whether no impulse is further out of its cone than kFarOut: later steps change impulses too little to bring it back.
bool StickingContacts::may_be_confirmed() const {
  const double far = kFarOut * largest_load();
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    const double* const f = impulses_.data() + system_.contacts()[c].first;
    double friction = 0;
    for (int t = 1; t < system_.contacts()[c].columns; ++t) friction += std::abs(f[t]);
    if (f[0] < -far || friction > contact_->mu(static_cast<Index>(c)) * std::max(f[0], 0.0) + far) return false;
  }
  return true;
}

/// Steps until no sticking contact moves, rounding limits them, or the guess is refuted. @param now miss() before them
/// @returns miss() after the last, except where the first refutes the guess: then `now`
double StickingContacts::approach(double now) {
  for (int step = 0; step < kMostSteps && now > kStickingStill; ++step) {
    const double before = now;
    improve();
    if (step == 0 && !may_be_confirmed()) return now;
    now = miss();
    if (!(now <= kProgress * before)) break;
  }
  return now;
}

/// Whether the impulses are in their cones, no sticking contact moves, and no other has a negative clearance().
/// Impulses that are outside by rounding are brought back. @param left what miss() returned last
bool StickingContacts::is_confirmed(double left) {
  bool is_trimmed = false;  // impulses were brought back into their cones
  const double largest = largest_load();
  const double none = kNoImpulse * largest;
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    double* const f = impulses_.data() + system_.contacts()[c].first;
    if (f[0] < -none) return false;
    is_trimmed = is_trimmed || f[0] < 0;
    f[0] = std::max(f[0], 0.0);
    const double most = contact_->mu(static_cast<Index>(c)) * f[0];
    double friction = 0;
    for (int t = 1; t < system_.contacts()[c].columns; ++t) friction += std::abs(f[t]);
    if (friction <= most) continue;
    if (!(friction <= most + none)) return false;
    for (int t = 1; t < system_.contacts()[c].columns; ++t) f[t] *= most / friction;
    is_trimmed = true;
  }
  if (!((is_trimmed ? miss() : left) <= kLargestMiss)) return false;
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    if (sticking_[c] == 0 && !(clearance(c) >= -kLargestMiss * scale_)) return false;
  }
  return true;
}

/// The least of (N + mu d)'u + b over the contact's directions d. Where it is not negative at any contact, w >= 0 and u
/// is of least energy. @pre misses_ are those of u_, of all contacts
double StickingContacts::clearance(std::size_t contact) const {
  const double* const w = misses_.data() + system_.contacts()[contact].first;
  double slip = 0;
  for (int t = 1; t < system_.contacts()[contact].columns; ++t) slip = std::max(slip, std::abs(w[t]));
  return w[0] - contact_->mu(static_cast<Index>(contact)) * slip;
}

/// Releases contacts that pull; those with a negative clearance() become sticking ones. @returns whether any changed
/// @pre as clearance()
bool StickingContacts::change_guess() {
  const double largest = largest_load();
  bool changes = false;
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    double* const f = impulses_.data() + system_.contacts()[c].first;
    const bool pulls = sticking_[c] != 0 && f[0] < -kNoImpulse * largest;
    const bool approaches = sticking_[c] == 0 && clearance(c) < -kLargestMiss * scale_;
    if (pulls) std::fill_n(f, system_.contacts()[c].columns, 0.0);
    if (pulls || approaches) sticking_[c] = approaches ? 1 : 0;
    changes = changes || pulls || approaches;
  }
  return changes;
}

/// z of the impulses: those along a direction d, of which A has one of each pair d and -d, go to d where positive, else
/// to -d. The lambdas stay zero: the test sets them.
void StickingContacts::write(Vector& z) const {
  z.setZero();
  Index direction = contact_->nc();
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    const double* const f = impulses_.data() + system_.contacts()[c].first;
    const int edges = contact_->edges[c];
    z(static_cast<Index>(c)) = f[0];
    for (int t = 0; t + 1 < system_.contacts()[c].columns; ++t) {
      z(direction + t) = std::max(f[1 + t], 0.0);
      z(direction + edges / 2 + t) = std::max(-f[1 + t], 0.0);
    }
    direction += edges;
  }
}

/// The first guess, in two ways by the same factors: the least impulses, and those nearest to the last answer's. The
/// way that found the last answer comes first.
bool StickingContacts::starts(const Vector& start) {
  for (int way = 0; way < 2; ++way) {
    if (way > 0) take_start(start);
    if (way > 0 && from_loads_) measure_scale();  // as let_go() asks
    if (!from_loads_) respond();
    if (is_confirmed(approach(from_loads_ ? let_go() : miss()))) return true;
    from_loads_ = !from_loads_;
  }
  return false;
}

/// Whether G is positive definite in double. With separate bodies AnswerTest finds that out.
bool StickingContacts::is_definite() {
  if (std::holds_alternative<BlockInertia>(contact_->inertia)) return true;
  std::fill(weights_.begin(), weights_.end(), 0.0);
  return system_.factor(weights_);
}

bool StickingContacts::balance(Vector& z, int power, double touching) {
  take_start(z);
  const double largest = largest_load();
  if (!(largest > 0)) return false;
  double heaviest = 0;
  for (Index i = 0; i < v_.size(); ++i) heaviest = std::max(heaviest, system_.mass(i));
  // So large that G matters little beside A W A': the contacts alone then decide where the changes go.
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    const double share = std::max(impulses_[system_.contacts()[c].first] / largest, kLeastShare);
    weights_[c] = offset(c) <= touching ? kStiffBalance[at(power - 1)] * heaviest * std::pow(share, power) : 0;
  }
  if (!system_.factor(weights_)) return false;
  for (int round = 0; round < kMostRounds; ++round) {
    add_missing_momentum();
    if (stay_in_cones()) {
      write(z);
      return true;
    }
  }
  return false;
}

/// Steps towards A f = -G v, until what is missing gets no smaller.
void StickingContacts::add_missing_momentum() {
  double last = std::numeric_limits<double>::infinity();
  for (int step = 0; step < kMostBalances; ++step) {
    residual_.setZero();
    system_.add_columns(impulses_.data(), residual_);
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
        impulses_[t] += weights_[c] * scaled_[t];
      }
    }
  }
}

/// Whether all impulses are in their cones. Those that are not are brought inside, a little further than to the
/// boundary.
bool StickingContacts::stay_in_cones() {
  constexpr double kInside = 1 - 1e-3;
  bool stay = true;
  for (std::size_t c = 0; c < system_.contacts().size(); ++c) {
    double* const f = impulses_.data() + system_.contacts()[c].first;
    double friction = 0;
    for (int t = 1; t < system_.contacts()[c].columns; ++t) friction += std::abs(f[t]);
    const double most = contact_->mu(static_cast<Index>(c)) * f[0];
    if (f[0] >= 0 && friction <= most) continue;
    stay = false;
    f[0] = std::max(f[0], 0.0);
    const double share = friction > 0 ? kInside * std::max(most, 0.0) / friction : 0;
    for (int t = 1; t < system_.contacts()[c].columns; ++t) f[t] *= share;
  }
  return stay;
}

void StickingContacts::load_test() {
  // All is one island, except contacts that nothing moves: their offset alone counts.
  const bool known = !contact_->has_offset();
  if (known) islands_.take_as_one(*contact_);
  test_.load(*problem_, known ? &islands_ : nullptr);
  test_.set_velocity(v_);
  has_test_ = true;
}

bool StickingContacts::solve(const Vector& start, int tries, double deadline_s, Answer& answer, Counters& work) {
  measure_scale();
  if (!(scale_ > 0 && scale_ <= std::numeric_limits<double>::max())) return false;
  take_start(start);  // the impulses that weigh() needs
  for (int guess = 0; guess < tries; ++guess) {
    weigh();
    ++work.factorizations;
    if (!system_.factor(weights_)) return false;
    if (!(guess == 0 ? starts(start) : is_confirmed(approach(miss())))) {
      if (guess + 1 == tries) return false;
      find_misses(u_);
      if (!change_guess()) return false;
      continue;
    }
    if (!is_definite()) return false;
    answer.clear();
    answer.claim = Claim::kSolved;
    answer.z.resize(problem_->size());
    write(answer.z);
    if (!has_test_) load_test();
    return test_.settle(answer, deadline_s);
  }
  return false;
}

}  // namespace lcpbench
