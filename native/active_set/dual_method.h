#pragma once

#include "native/active_set/velocity_test.h"
#include "native/active_set/whitening.h"
#include "native/active_set/yielding_contacts.h"
#include "native/active_set/yielding_friction.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

/// The projection of v onto {u : N'u + b >= 0} in the metric of the inertia, by the dual active-set method of Goldfarb
/// and Idnani (1983) in whitened coordinates: min 1/2 |y - y0|^2 subject to W'y + b >= 0.
///
/// The iterate is optimal for the contacts of the active set alone, and their impulses are not negative. A step takes
/// in the contact whose half-space is furthest away, and lets go of contacts whose impulse comes to zero on the way.
/// The objective increases with each full step, so that no active set recurs. A contact whose normal depends on the
/// active ones takes the place of one of them, or shows that nothing is feasible.
///
/// slack_, the normal velocities N'u + b, is carried along instead of y. Per step O(ngc (nc + active)).
///
/// Contacts with compliance are solved by YieldingContacts in its place, and tested alike; those with friction too by
/// YieldingFriction, and not tested.
template <class Scalar>
class DualMethod final : public Engine {
  using L = Lanes<Scalar>;

 public:
  void reserve(const Input& input) override {
    if (input.mu != nullptr) friction_.reserve(input.ngc, input.nc);
    const Count factors = Whitening<Scalar>::root_factors(input);
    if (input.ngc <= reserved_.ngc && input.nc <= reserved_.nc && factors <= reserved_.factors &&
        input.soft <= reserved_.soft) {
      return;
    }
    reserved_.soft = input.soft > reserved_.soft ? input.soft : reserved_.soft;
    reserved_.ngc = input.ngc > reserved_.ngc ? input.ngc : reserved_.ngc;
    reserved_.nc = input.nc > reserved_.nc ? input.nc : reserved_.nc;
    reserved_.factors = factors > reserved_.factors ? factors : reserved_.factors;
    whitening_.reserve(reserved_.ngc, reserved_.nc, reserved_.factors);
    const Count contacts = L::padded(reserved_.nc);
    const Count most = reserved_.ngc < reserved_.nc ? reserved_.ngc : reserved_.nc;
    const Count pressing = reserved_.soft > most ? reserved_.soft : most;
    const Count vectors = L::padded(reserved_.ngc);
    resize_all(vectors + 1, v_, y0_, change_, velocity_, rest_);
    resize_all(contacts + 1, given_, slack_, weight_, merit_, impulse_);
    resize_all(pressing + 2, active_impulse_, share_, coefficients_, remaining_);
    resize_all(reserved_.nc + 1, active_, is_moved_);  // islands have contacts: there are no more of them
    basis_.reserve(vectors, most);
    if (reserved_.soft > 0) yielding_.reserve(reserved_.ngc, reserved_.soft);
    test_.reserve(reserved_.ngc, reserved_.nc);
  }

  void load(const Input& input) override {
    reserve(input);
    b_ = input.b;
    mu_ = input.mu;
    usable_ = whitening_.load(input);
    if (usable_) test_.load(input);
    island_of_contact_ = input.island_of_contact;
    island_of_coordinate_ = input.island_of_coordinate;
    update(input.v);
  }

  void update(const double* v) override {
    const Count ngc = whitening_.ngc();
    widen(v, ngc, v_.data());
    if (!usable_) return;
    set_zero(given_.data(), whitening_.contact_lanes());
    combine_rows(given_.data(), given_.data(), whitening_.normals(0), whitening_.contact_lanes(), v_.data(), ngc,
                 whitening_.contact_lanes());
    for (Count j = 0; b_ != nullptr && j < whitening_.nc(); ++j) given_[j] += static_cast<Scalar>(b_[j]);
    auto approach = L::broadcast(static_cast<Scalar>(ContactScale<Scalar>::kLeast)), speed = approach;
    for (Count j = 0; j < whitening_.contact_lanes(); j += L::kWidth) {
      const auto given = L::load(given_.data() + j);
      approach = L::max(-given, approach);
      speed = L::max(L::max(given, -given), speed);
    }
    scale_ = finite(L::max(speed)) ? L::max(approach) : kInfinity<Scalar>;
    if (whitening_.triangular()) whitening_.whiten_velocity(v_.data(), y0_.data());
  }

  Outcome solve(const Rules& rules, double* z, double* velocity, double* u) override {
    if (!usable_) return {};
    begin_s_ = rules.begin_s;
    Outcome outcome;
    outcome.work = kWorkOfShortestSolve;
    start();
    if (whitening_.is_soft()) {
      yielding_.begin(given_.data(), rules.start);
    } else if (rules.start != nullptr) {
      warm_start(rules, outcome);
    }
    if (mu_ != nullptr) return yield_with_friction(rules, outcome, z);
    outcome.ending = whitening_.is_soft() ? yield(rules, outcome) : iterate(rules, outcome);
    if (outcome.ending == Ending::kInfeasible) write_farkas(u);
    if (outcome.ending != Ending::kSolved) return outcome;
    if (whitening_.is_soft()) {
      take_yielding();
    } else if constexpr (kLastPrecision) {
      polish(outcome);
    } else {
      find_active_impulses();
    }
    if (!write_answer(z, velocity)) {
      outcome.ending = Ending::kBreakdown;
    } else if (!passes(pressing_, rules.accept_residual, velocity_.data(), change_.data())) {
      outcome.ending = Ending::kRejected;
    }
    outcome.is_singular = !whitening_.triangular();
    outcome.has_velocity = outcome.ending != Ending::kBreakdown &&
                           (test_.is_far_from_underflow() || keeps_digits()) &&
                           test_.holds_velocity(answer(velocity_.data(), change_.data()));
    return outcome;
  }

  bool accepts(const double* z, double accept_residual) override {
    return usable_ && passes(take_impulses(z), accept_residual, nullptr, nullptr);
  }

  /// @pre no solve is to go on
  double residual(const double* z) override {
    if (!usable_) return __builtin_inf();
    const Count pressed = take_impulses(z);
    return test_.residual(answer(nullptr, nullptr), active_.data(), pressed);
  }

 private:
  static constexpr Count kStepsPerClockReading = 16;
  static constexpr Count kWorkOfShortestSolve = 9000;
  static constexpr Count kWorkOfStep = 1000;
  static constexpr bool kLastPrecision = sizeof(Scalar) > sizeof(double);

  Count lanes() const { return whitening_.velocity_lanes(); }
  Count contact_lanes() const { return whitening_.contact_lanes(); }

  // --- the iteration ---

  void start() {
    clear_basis();
    copy(slack_.data(), given_.data(), contact_lanes());
    copy(weight_.data(), whitening_.weights(), contact_lanes());
    const Scalar noise = whitening_.noise();
    violation_threshold_ = noise * noise * squared_scale();
  }

  Count most_active() const { return whitening_.ngc() < whitening_.nc() ? whitening_.ngc() : whitening_.nc(); }

  void clear_basis() { basis_.clear(lanes(), most_active()); }

  /// The scale of squared distances to half-spaces: |v|_G^2 if G has a factor C. Without C, or with an offset, at least
  /// the largest squared distance at v to a half-space that is violated.
  Scalar squared_scale() {
    Scalar largest = whitening_.triangular() ? dot(y0_.data(), y0_.data(), lanes()) : Scalar(0);
    if (whitening_.triangular() && b_ == nullptr) return largest;
    measure_merits();
    for (Count j = 0; j < whitening_.nc(); ++j) largest = merit_[j] > largest ? merit_[j] : largest;
    return largest;
  }

  /// merit_ = squared distance to the half-space where that is violated, else 0; 0 for active contacts. @returns
  /// largest
  Scalar measure_merits() {
    const auto zero = L::broadcast(0);
    auto largest = zero;
    for (Count j = 0; j < contact_lanes(); j += L::kWidth) {
      const auto violation = L::min(L::load(slack_.data() + j), zero);
      const auto merit = violation * violation * L::load(weight_.data() + j);
      L::store(merit_.data() + j, merit);
      largest = L::max(largest, merit);
    }
    return L::max(largest);
  }

  /// The contact that is furthest from its half-space; -1: none by more than rounding. NaN counts as none.
  Count most_violated() {
    const Scalar largest = measure_merits();
    if (!(largest > violation_threshold_)) return -1;
    Count contact = 0;  // the lowest of equals; without a branch, which would be mispredicted
    for (Count j = contact_lanes() - L::kWidth; j >= 0; j -= L::kWidth) {
      const std::uint64_t equals = lanes_where<Scalar>(L::load(merit_.data() + j) == L::broadcast(largest));
      contact = equals != 0 ? j + __builtin_ctzll(equals) : contact;
    }
    return contact;
  }

  Ending iterate(const Rules& rules, Outcome& outcome) {
    if (immovable_contact_is_violated()) return Ending::kInfeasible;
    for (bool added = true;;) {  // the last contact that enters
      if (added) {
        const Count contact = most_violated();
        if (contact < 0) return Ending::kSolved;
        entering_contact_ = contact;
        entering_impulse_ = 0;
        weight_[contact] = 0;
      }
      added = false;  // also where a limit ends this
      if (const Ending limit = next_step(rules, outcome); limit != Ending::kSolved) return limit;
      count_step(outcome);
      const Ending ending = step(added);
      if (ending != Ending::kSolved) return ending;
    }
  }

  /// Counts a step, unless a limit forbids it.
  Ending next_step(const Rules& rules, Outcome& outcome) {
    if (outcome.steps >= rules.max_steps) return Ending::kStepLimit;
    if (outcome.work >= rules.max_work) return Ending::kWorkLimit;
    if (outcome.steps % kStepsPerClockReading == kStepsPerClockReading - 1 && expired(rules)) {
      return Ending::kTimeLimit;
    }
    ++outcome.steps;
    return Ending::kSolved;
  }

  /// The iteration of contacts that yield.
  Ending yield(const Rules& rules, Outcome& outcome) {
    using Step = typename YieldingContacts<Scalar>::Step;
    for (Step step = Step::kTaken; step != Step::kLast;) {
      if (const Ending limit = next_step(rules, outcome); limit != Ending::kSolved) return limit;
      ++outcome.factorizations;
      outcome.work += yielding_.work() + kWorkOfStep;
      step = yielding_.step(violation_threshold_);
      if (step == Step::kFailed) return Ending::kBreakdown;
    }
    return Ending::kSolved;
  }

  /// That of contacts that yield and have friction.
  Outcome yield_with_friction(const Rules& rules, Outcome outcome, double* z) {
    if (!friction_.resolves(static_cast<Scalar>(rules.accept_residual))) return outcome;
    friction_.begin(given_.data(), mu_);
    if (!finite(friction_.left())) return outcome;
    const Scalar most = static_cast<Scalar>(rules.accept_residual) * static_cast<Scalar>(rules.accept_residual);
    for (outcome.ending = Ending::kSolved; friction_.left() > most * squared_scale();) {
      outcome.ending = next_step(rules, outcome);
      if (outcome.ending != Ending::kSolved) return outcome;
      ++outcome.factorizations;
      if (!friction_.step()) outcome.ending = Ending::kBreakdown;
      if (outcome.ending != Ending::kSolved) return outcome;
    }
    for (Count j = 0; j < whitening_.nc(); ++j) z[j] = static_cast<double>(friction_.impulse(j));
    return outcome;
  }

  void take_yielding() {
    pressing_ = yielding_.count();
    copy(change_.data(), yielding_.change(), lanes());
    for (Count k = 0; k < pressing_; ++k) {
      active_[k] = yielding_.contact(k);
      active_impulse_[k] = static_cast<Scalar>(static_cast<double>(yielding_.impulse(k)));  // as they are returned
      if (active_impulse_[k] < 0) {  // rounding, and returned as zero: the velocity is that of the others
        add_multiple(change_.data(), -active_impulse_[k], whitening_.normal(active_[k]), lanes());
        active_impulse_[k] = 0;
      }
      coefficients_[k] = active_impulse_[k] * square_root(whitening_.squared_norm(active_[k]));
    }
  }

  /// With the time that no product takes.
  void count_step(Outcome& outcome) const {
    const Count active = basis_.size();
    outcome.work += active * (4 * lanes() + active) + (whitening_.rank() + 4) * contact_lanes() + kWorkOfStep;
  }

  bool expired(const Rules& rules) {
    if (!(rules.time_limit_s < kInfinity<double>)) return false;
    const double now_s = rules.clock_s();
    if (!(begin_s_ <= now_s)) begin_s_ = now_s;
    return !(now_s - begin_s_ < rules.time_limit_s);
  }

  /// Contacts that no impulse moves: violated ones stay so.
  bool immovable_contact_is_violated() {
    if (whitening_.triangular() && b_ == nullptr) return false;  // their normals are zero, and so is their velocity
    for (Count j = 0; j < whitening_.nc(); ++j) {
      if (whitening_.squared_norm(j) > 0) continue;
      if (given_[j] >= -whitening_.noise() * velocity_terms(j)) continue;
      entering_contact_ = j;
      return true;
    }
    return false;
  }

  /// Sum of the magnitudes of what N_j'v + b_j adds up.
  Scalar velocity_terms(Count j) const {
    Scalar terms = b_ != nullptr ? magnitude(static_cast<Scalar>(b_[j])) : Scalar(0);
    for (Count i = 0; i < whitening_.ngc(); ++i) terms += magnitude(whitening_.normals(i)[j] * v_[i]);
    return terms;
  }

  /// Whether the entering contact and the active ones that its normal depends on, u >= 0 with N u in null(G), have
  /// (N'v + b)'u < 0 by more than rounding. Where it is rounding, most often at v+ = 0, where all contacts rest, the
  /// violation is rounding too.
  bool proves_infeasible() {
    constexpr double kRoundings = kLastPrecision ? 0x1p20 : 1;  // the last precision has digits to spare
    Scalar value = given_[entering_contact_];
    Scalar terms = velocity_terms(entering_contact_);
    for (Count k = 0; k < basis_.size(); ++k) {
      value -= share_[k] * given_[active_[k]];
      terms -= share_[k] * velocity_terms(active_[k]);
    }
    return value < -static_cast<Scalar>(kRoundings) * whitening_.noise() * terms;
  }

  /// Moves towards the entering contact's boundary until there (added), or until an active contact lets go.
  Ending step(bool& added) {
    const Scalar squared_norm = whitening_.squared_norm(entering_contact_);
    const Scalar left =
        basis_.split(whitening_.normal(entering_contact_), squared_norm, coefficients_.data(), rest_.data());
    for (Count k = 0; k < basis_.size(); ++k) share_[k] = coefficients_[k];
    basis_.solve(share_.data());
    const Scalar noise = whitening_.noise();
    const bool independent = basis_.size() < most_active() && left > noise * noise * squared_norm;

    Count leaving = -1;
    Scalar partial = kInfinity<Scalar>;
    for (Count k = 0; k < basis_.size(); ++k) {
      if (share_[k] > 0 && (leaving < 0 || active_impulse_[k] < partial * share_[k])) {
        partial = active_impulse_[k] / share_[k];
        leaving = k;
      }
    }
    if (!independent && leaving < 0) {
      // A positive definite inertia leaves nothing infeasible without an offset. If the violation is no rounding, the
      // test at the end finds it.
      if ((!whitening_.triangular() || b_ != nullptr) && proves_infeasible()) return Ending::kInfeasible;
      added = true;
      return Ending::kSolved;
    }
    const Scalar full = independent ? -slack_[entering_contact_] / left : kInfinity<Scalar>;
    added = !(partial < full);
    const Scalar length = added ? full : partial;
    if (!finite(length)) return Ending::kBreakdown;
    for (Count k = 0; k < basis_.size(); ++k) active_impulse_[k] -= length * share_[k];
    entering_impulse_ += length;
    if (independent) move(length);
    if (added) {
      add_entering(left);
    } else {
      drop(leaving);
    }
    return Ending::kSolved;
  }

  /// y += length * rest_, of which slack_ alone is kept.
  void move(Scalar length) {
    const auto factor = L::broadcast(length);
    for (Count i = 0; i < lanes(); i += L::kWidth) {
      L::store(change_.data() + i, factor * L::load(rest_.data() + i));
    }
    combine_rows(slack_.data(), slack_.data(), whitening_.row(0), whitening_.row_stride(), change_.data(),
                 whitening_.rank(), contact_lanes());
  }

  void add_entering(Scalar left) {
    const Count k = basis_.size();
    active_[k] = entering_contact_;
    active_impulse_[k] = entering_impulse_;
    basis_.append(coefficients_.data(), rest_.data(), left);
  }

  void drop(Count k) {
    weight_[active_[k]] = whitening_.weights()[active_[k]];
    basis_.remove(k);
    for (Count i = k; i < basis_.size(); ++i) {
      active_[i] = active_[i + 1];
      active_impulse_[i] = active_impulse_[i + 1];
    }
  }

  // --- a given active set ---

  /// Appends `contact` to the active set unless its normal depends on those in it.
  bool append_independent(Count contact);

  /// The active set from the last time step, less the contacts that it would pull.
  void warm_start(const Rules& rules, Outcome& outcome);

  /// change_ = y - y0 with y the projection on the active contacts' boundaries, active_impulse_ = the impulses that do
  /// it.
  void find_active_impulses();

  void add_change_to_slack() {
    combine_rows(slack_.data(), given_.data(), whitening_.row(0), whitening_.row_stride(), change_.data(),
                 whitening_.rank(), contact_lanes());
  }

  // --- the end ---

  /// find_active_impulses() with the active normals factored afresh: free of what exchanges left in the factors.
  ///
  /// The contact comes next whose impulse moves the least: the impulses are rounded to double one by one so that the
  /// last to be rounded, which nothing makes up for, does the least harm. With normals that nearly depend on each
  /// other, impulses of 1e12 N s can leave a velocity of zero, and rounding each for itself would move it visibly.
  void polish(Outcome& outcome);

  void exchange(Count i, Count j) {
    swap(active_[i], active_[j]);
    swap(remaining_[i], remaining_[j]);
    swap(active_impulse_[i], active_impulse_[j]);
  }

  /// Puts the contacts with an impulse into active_. @returns how many
  Count take_impulses(const double* z);

  /// False when it is not finite.
  bool write_answer(double* z, double* velocity);

  void compute_velocity();

  /// What no impulse moves has the velocity that was given, without any rounding.
  void keep_unmoved_velocity();

  /// Whether no velocity, in the metric of the inertia, is so small that underflow takes digits that count: a body of
  /// 1e-55 kg at 1e-320 m/s would stand still, though no impulse stops it. @pre find_active_impulses()
  [[gnu::noinline]] bool keeps_digits() const;

  /// Of impulse_, not zero for the first `pressed` contacts of active_ at most.
  bool passes(Count pressed, double limit, const Scalar* velocity, const Scalar* whitened_change) {
    return test_.passes(answer(velocity, whitened_change), active_.data(), pressed, static_cast<Scalar>(limit));
  }

  typename VelocityTest<Scalar>::Answer answer(const Scalar* velocity, const Scalar* whitened_change) {
    return {.v = v_.data(),
            .given = given_.data(),
            .scale = scale_,
            .impulse = impulse_.data(),
            .slack = slack_.data(),
            .velocity = velocity,
            .whitened_change = whitened_change};
  }

  /// u of Engine::solve(): 1 for the entering contact and, unless nothing moves that, -share_ for the active ones, none
  /// of whose shares is positive then. @pre Ending::kInfeasible
  void write_farkas(double* u);

  /// The largest dimensions so far: problems that are not larger need no memory.
  struct Dimensions {
    Count ngc = -1;
    Count nc = -1;
    Count factors = -1;  ///< of SemidefiniteRoot
    Count soft = 0;
  };

  Dimensions reserved_;
  const Count* island_of_contact_ = nullptr;  // nullptr: all are in one
  const Count* island_of_coordinate_ = nullptr;
  Whitening<Scalar> whitening_;
  OrthogonalBasis<Scalar> basis_;  // of the active normals
  YieldingContacts<Scalar> yielding_{whitening_};
  YieldingFriction<Scalar> friction_{whitening_};
  bool usable_ = false;
  const double* b_ = nullptr;  // nullptr: zero
  const double* mu_ = nullptr;  // nullptr: no friction
  double begin_s_ = 0;  // of the solve, on its clock; NaN until that is read
  Scalar violation_threshold_ = 0;  // of merit_

  Buffer<Scalar> v_;      // ngc
  Buffer<Scalar> given_;  // N'v + b
  Scalar scale_ = 0;      // the largest approach in it; infinite where an entry is
  Buffer<Scalar> y0_;     // C v
  Buffer<Scalar> slack_;
  Buffer<Scalar> merit_;  // see measure_merits()
  Buffer<Scalar> weight_;  // 1 / |W_j|^2, 0 for active contacts

  Buffer<bool> is_moved_;  // by island
  Count pressing_ = 0;     // of active_, at the end
  Buffer<Count> active_;
  Buffer<Scalar> active_impulse_;  // impulses of the active contacts
  Buffer<Scalar> remaining_;

  Count entering_contact_ = 0;
  Scalar entering_impulse_ = 0;
  Buffer<Scalar> coefficients_;
  Buffer<Scalar> share_;  // of the entering normal in the active ones: R^-1 Q' of it
  Buffer<Scalar> rest_;

  Buffer<Scalar> change_;  // y - y0; during the iteration that of one step
  Buffer<Scalar> velocity_;
  Buffer<Scalar> impulse_;  // by contact

  VelocityTest<Scalar> test_{whitening_};
};

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL

#include "native/active_set/dual_method_end.h"
