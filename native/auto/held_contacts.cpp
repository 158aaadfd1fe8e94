#include "native/auto/held_contacts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

namespace lcpbench {
namespace {

/// W times the inertia that a contact feels: S = A'G*A is met but for the inverse of this in each step.
constexpr double kStiffness = 1e9;
/// Of contacts with hardly any load, against that with the largest.
constexpr double kLeastLoad = 1e-2;
constexpr int kMostSteps = 8;

/// Velocities A'u + b, relative to max|q|: at the first no further step is taken, at the second the guess may stand.
constexpr double kHeldStill = 1e-10;
constexpr double kLargestMiss = 1e-9;
/// A step that does not bring them to this part of the last has met rounding.
constexpr double kProgress = 0.5;

/// Of the largest impulse: a contact that pulls less is open, and friction beyond its pyramid by less is on it.
constexpr double kNoImpulse = 1e-9;
/// One that is further out than this after the first step makes the guess a wrong one.
constexpr double kFarOut = 1e-3;
/// In the last answer a lambda above this part of max|v| is slip.
constexpr double kSlip = 1e-6;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }
std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

bool HeldContacts::takes(const ContactProblem& contact) {
  return std::holds_alternative<BlockInertia>(contact.inertia) || std::holds_alternative<DenseInertia>(contact.inertia);
}

void HeldContacts::load(const Problem& problem, const Vector& v) {
  problem_ = &problem;
  contact_ = problem.contact();
  has_test_ = false;
  if (graph_.load(*contact_)) {
    matrix_.analyze(graph_, contact_->ngc());
    graph_.set_places(matrix_.places());
  }
  take_room();
  set_velocity(v);
}

void HeldContacts::take_room() {
  matrix_.take_room(graph_);
  scaled_.resize(at(graph_.most_columns()));
  impulses_.resize(graph_.column_count());
  misses_.resize(graph_.column_count());
  held_.resize(graph_.contacts().size());
  load_.resize(graph_.contacts().size());
  for (Vector* room : {&v_, &u_, &step_, &impulse_}) room->resize(contact_->ngc());
}

void HeldContacts::set_velocity(const Vector& v) {
  given_v_ = v;
  graph_.order(v, v_);
  if (has_test_) test_.set_velocity(v);
}

void HeldContacts::measure_scale() {
  scale_ = 0;
  for (std::size_t c = 0; c < graph_.contacts().size(); ++c) {
    double* const q = misses_.data() + graph_.contacts()[c].first;
    graph_.multiply(graph_.contacts()[c], v_, q);
    q[0] += offset(c);
    for (int t = 0; t < graph_.contacts()[c].columns; ++t) scale_ = std::max(scale_, std::abs(q[t]));
  }
}

bool HeldContacts::held(const ContactProblem& contact, const Vector& v, const Vector& start) {
  if (start.size() != lcp_size(contact) || !start.allFinite()) return false;
  const double most = kSlip * v.lpNorm<Eigen::Infinity>();
  Index lambda = contact.nc() + cols(contact.D);
  bool presses = false;
  for (Index c = 0; c < contact.nc(); ++c) {
    presses = presses || start(c) > 0;
    if (contact.edges[at(c)] == 0) continue;
    if (start(c) > 0 && contact.mu(c) > 0 && !(start(lambda) <= most)) return false;
    ++lambda;
  }
  return presses;
}

/// The impulses of the last answer, and what it held.
void HeldContacts::take_start(const Vector& start) {
  const Index nc = contact_->nc();
  Index direction = nc;
  for (Index c = 0; c < nc; ++c) {
    const HeldColumns& contact = graph_.contacts()[at(c)];
    double* const f = impulses_.data() + contact.first;
    const int edges = contact_->edges[at(c)];
    f[0] = start(c);
    for (int t = 0; t + 1 < contact.columns; ++t) f[1 + t] = start(direction + t) - start(direction + edges / 2 + t);
    held_[at(c)] = f[0] > 0 ? 1 : 0;
    direction += edges;
  }
}

double HeldContacts::largest_load() const {
  double largest = 0;
  for (const HeldColumns& contact : graph_.contacts()) largest = std::max(largest, impulses_[contact.first]);
  return largest;
}

/// Loaded contacts take more of a change than those that hardly press.
void HeldContacts::weigh() {
  const double largest = largest_load();
  for (std::size_t c = 0; c < graph_.contacts().size(); ++c) {
    const double share = largest > 0 ? impulses_[graph_.contacts()[c].first] / largest : 1;
    load_[c] = held_[c] != 0 ? kStiffness * graph_.strength(c) * std::max(share, kLeastLoad) : 0;
  }
}

/// u of the impulses.
void HeldContacts::respond() {
  impulse_.setZero(v_.size());
  for (std::size_t c = 0; c < graph_.contacts().size(); ++c) {
    const HeldColumns& contact = graph_.contacts()[c];
    const double* const f = impulses_.data() + contact.first;
    if (std::any_of(f, f + contact.columns, [](double x) { return x != 0; })) graph_.add_columns(contact, f, impulse_);
  }
  u_ = v_;
  graph_.add_response(impulse_, u_);
}

/// A'u + b of what is held. @returns the largest, relative to max|q|
double HeldContacts::miss() {
  respond();
  double largest = 0;
  for (std::size_t c = 0; c < graph_.contacts().size(); ++c) {
    if (held_[c] == 0) continue;
    const HeldColumns& contact = graph_.contacts()[c];
    double* const w = misses_.data() + contact.first;
    graph_.multiply(contact, u_, w);
    w[0] += offset(c);
    for (int t = 0; t < contact.columns; ++t) largest = std::max(largest, std::abs(w[t]));
  }
  return largest / scale_;
}

/// f -= W (w - A'y) for (G + A W A') y = A W w, which changes u by - y. @returns the largest of the new w, relative to
/// max|q|, but for the rounding of the factors
double HeldContacts::improve() {
  step_.setZero(v_.size());
  for (std::size_t c = 0; c < graph_.contacts().size(); ++c) {
    if (held_[c] == 0) continue;
    const double* const w = misses_.data() + graph_.contacts()[c].first;
    for (int t = 0; t < graph_.contacts()[c].columns; ++t) scaled_[at(t)] = load_[c] * w[t];
    graph_.add_columns(graph_.contacts()[c], scaled_.data(), step_);
  }
  matrix_.solve(step_);
  double largest = 0;
  for (std::size_t c = 0; c < graph_.contacts().size(); ++c) {
    if (held_[c] == 0) continue;
    double* const w = misses_.data() + graph_.contacts()[c].first;
    double* const f = impulses_.data() + graph_.contacts()[c].first;
    graph_.multiply(graph_.contacts()[c], step_, scaled_.data());
    for (int t = 0; t < graph_.contacts()[c].columns; ++t) {
      w[t] -= scaled_[at(t)];
      f[t] -= load_[c] * w[t];
      largest = std::max(largest, std::abs(w[t]));
    }
  }
  return largest / scale_;
}

/// Takes all impulses away. @pre measure_scale() was the last to fill the misses @returns what miss() would, cheaper
double HeldContacts::let_go() {
  std::fill(impulses_.begin(), impulses_.end(), 0.0);
  double largest = 0;
  for (std::size_t c = 0; c < graph_.contacts().size(); ++c) {
    if (held_[c] == 0) continue;
    const double* const q = misses_.data() + graph_.contacts()[c].first;
    for (int t = 0; t < graph_.contacts()[c].columns; ++t) largest = std::max(largest, std::abs(q[t]));
  }
  return largest / scale_;
}

/// Whether no impulse is so far out of its cone that further steps, which are corrections, hardly bring it back.
bool HeldContacts::may_be_confirmed() const {
  const double far = kFarOut * largest_load();
  for (std::size_t c = 0; c < graph_.contacts().size(); ++c) {
    const double* const f = impulses_.data() + graph_.contacts()[c].first;
    double friction = 0;
    for (int t = 1; t < graph_.contacts()[c].columns; ++t) friction += std::abs(f[t]);
    if (f[0] < -far || friction > contact_->mu(static_cast<Index>(c)) * std::max(f[0], 0.0) + far) return false;
  }
  return true;
}

/// Steps until nothing held moves, rounding is met, or the guess is seen to be wrong. After the first the velocity is
/// taken from the impulses again: it was the largest, and the factors are not exact.
void HeldContacts::approach(double now) {
  for (int step = 0; step < kMostSteps && now > kHeldStill; ++step) {
    const double before = now;
    now = improve();
    if (step == 0 && !may_be_confirmed()) return;
    if (step == 0) now = miss();
    if (!(now <= kProgress * before)) return;
  }
}

/// Whether the impulses are in their cones and leave no contact held that moves, and no other within its clearance.
/// What is outside by rounding is brought back.
bool HeldContacts::is_confirmed() {
  const double largest = largest_load();
  const double none = kNoImpulse * largest;
  for (std::size_t c = 0; c < graph_.contacts().size(); ++c) {
    double* const f = impulses_.data() + graph_.contacts()[c].first;
    if (f[0] < -none) return false;
    f[0] = std::max(f[0], 0.0);
    const double most = contact_->mu(static_cast<Index>(c)) * f[0];
    double friction = 0;
    for (int t = 1; t < graph_.contacts()[c].columns; ++t) friction += std::abs(f[t]);
    if (friction <= most) continue;
    if (!(friction <= most + none)) return false;
    for (int t = 1; t < graph_.contacts()[c].columns; ++t) f[t] *= most / friction;
  }
  if (!(miss() <= kLargestMiss)) return false;
  for (std::size_t c = 0; c < graph_.contacts().size(); ++c) {
    if (held_[c] == 0 && !(clearance(c) >= -kLargestMiss * scale_)) return false;
  }
  return true;
}

/// The least of (N + mu d)'u + b over the contact's directions d: where it is not negative, neither is w, and the
/// impulses that hold the others are those of least energy.
double HeldContacts::clearance(std::size_t contact) {
  graph_.multiply(graph_.contacts()[contact], u_, scaled_.data());
  double slip = 0;
  for (int t = 1; t < graph_.contacts()[contact].columns; ++t) slip = std::max(slip, std::abs(scaled_[at(t)]));
  return scaled_[0] + offset(contact) - contact_->mu(static_cast<Index>(contact)) * slip;
}

/// Lets go what pulls, and holds what approaches or slips without a load. @returns whether there was any
bool HeldContacts::change_guess() {
  const double largest = largest_load();
  bool changes = false;
  for (std::size_t c = 0; c < graph_.contacts().size(); ++c) {
    double* const f = impulses_.data() + graph_.contacts()[c].first;
    const bool pulls = held_[c] != 0 && f[0] < -kNoImpulse * largest;
    const bool approaches = held_[c] == 0 && clearance(c) < -kLargestMiss * scale_;
    if (pulls) std::fill_n(f, graph_.contacts()[c].columns, 0.0);
    if (pulls || approaches) held_[c] = approaches ? 1 : 0;
    changes = changes || pulls || approaches;
  }
  return changes;
}

void HeldContacts::write(Answer& answer) const {
  answer.clear();
  answer.claim = Claim::kSolved;
  answer.z.resize(problem_->size());
  answer.z.setZero();
  Index direction = contact_->nc();
  for (std::size_t c = 0; c < graph_.contacts().size(); ++c) {
    const double* const f = impulses_.data() + graph_.contacts()[c].first;
    const int edges = contact_->edges[c];
    answer.z(static_cast<Index>(c)) = f[0];
    for (int t = 0; t + 1 < graph_.contacts()[c].columns; ++t) {
      answer.z(direction + t) = std::max(f[1 + t], 0.0);
      answer.z(direction + edges / 2 + t) = std::max(-f[1 + t], 0.0);
    }
    direction += edges;
  }
  answer.velocity.resize(contact_->ngc());
  graph_.restore(u_, answer.velocity);
}

/// The first guess, in two ways by the same factors: impulses in proportion to the loads of the last answer, and its
/// impulses with the least change that holds. What found the last one comes first.
bool HeldContacts::starts(const Vector& start) {
  for (int way = 0; way < 2; ++way) {
    if (way > 0) take_start(start);
    if (way > 0 && from_loads_) measure_scale();  // for the misses
    approach(from_loads_ ? let_go() : miss());
    if (is_confirmed()) return true;
    from_loads_ = !from_loads_;
  }
  return false;
}

bool HeldContacts::continues() {
  approach(miss());
  return is_confirmed();
}

bool HeldContacts::solve(const Vector& start, int tries, double deadline_s, Answer& answer, Counters& work) {
  measure_scale();
  if (!graph_.is_definite() || !(scale_ > 0 && scale_ <= std::numeric_limits<double>::max())) return false;
  take_start(start);  // the loads, for the weights
  for (int guess = 0; guess < tries; ++guess) {
    weigh();
    ++work.factorizations;
    if (!matrix_.factor(graph_, load_)) return false;
    if (!(guess == 0 ? starts(start) : continues())) {
      if (guess + 1 == tries) return false;
      respond();
      if (!change_guess()) return false;
      continue;
    }
    write(answer);
    if (!has_test_) test_.load(*problem_, AnswerTest::Bodies::kOneByOne);
    if (!has_test_) test_.set_velocity(given_v_);
    has_test_ = true;
    return test_.settle(answer, deadline_s);
  }
  return false;
}

}  // namespace lcpbench
