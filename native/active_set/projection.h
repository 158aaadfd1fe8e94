#pragma once

#include "native/active_set/dual_method.h"
#include "native/active_set/velocity_test.h"
#include "native/active_set/yielding_contacts.h"
#include "native/active_set/yielding_friction.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

/// The engine: hard contacts are solved by DualMethod, contacts with compliance by YieldingContacts, and both are
/// tested alike. Those with friction too are solved by YieldingFriction, and not tested.
class Projection final : public Engine {
  using L = Lanes<double>;

 public:
  void reserve(const Input& input) override {
    if (input.mu != nullptr) friction_.reserve(input.ngc, input.nc);
    const Count factors = Whitening::root_factors(input);
    if (input.ngc <= reserved_.ngc && input.nc <= reserved_.nc && factors <= reserved_.factors &&
        input.soft <= reserved_.soft) {
      return;
    }
    reserved_.soft = input.soft > reserved_.soft ? input.soft : reserved_.soft;
    reserved_.ngc = input.ngc > reserved_.ngc ? input.ngc : reserved_.ngc;
    reserved_.nc = input.nc > reserved_.nc ? input.nc : reserved_.nc;
    reserved_.factors = factors > reserved_.factors ? factors : reserved_.factors;
    whitening_.reserve(reserved_.ngc, reserved_.nc, reserved_.factors);
    method_.reserve(reserved_.ngc, reserved_.nc);
    if (reserved_.soft > 0) yielding_.reserve(reserved_.ngc, reserved_.soft);
    test_.reserve(reserved_.ngc, reserved_.nc);
    resize_all(L::padded(reserved_.ngc) + 1, v_, y0_, change_, velocity_, impulse_sum_);
    resize_all(L::padded(reserved_.nc) + 1, given_, slack_, impulse_);
    // Islands have contacts: there are no more of them.
    resize_all(reserved_.nc + 2, pressing_, pressing_impulse_, coordinates_, is_moved_);
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
    for (Count j = 0; b_ != nullptr && j < whitening_.nc(); ++j) given_[j] += b_[j];
    auto approach = L::broadcast(ContactScale<double>::kLeast), speed = approach;
    for (Count j = 0; j < whitening_.contact_lanes(); j += L::kWidth) {
      const auto given = L::load(given_.data() + j);
      approach = L::max(-given, approach);
      speed = L::max(L::max(given, -given), speed);
    }
    scale_ = finite(L::max(speed)) ? L::max(approach) : kInfinity<double>;
    if (whitening_.triangular()) whitening_.whiten_velocity(v_.data(), y0_.data());
  }

  Outcome solve(const Rules& rules, double* z, double* velocity, double* u) override {
    Outcome outcome;
    if (!usable_) return outcome;
    outcome.work = kWorkOfShortestSolve;
    Steps steps(rules, outcome);
    method_.begin(v_.data(), y0_.data(), given_.data(), b_);
    if (mu_ != nullptr) {
      outcome.ending = yield_with_friction(rules.accept_residual, steps, z);
      return outcome;
    }
    if (whitening_.is_soft()) {
      outcome.ending = yield(rules.start, steps);
    } else {
      if (rules.start != nullptr) {
        steps.count_factorization();
        outcome.steps += method_.warm_start(rules.start);
      }
      outcome.ending = method_.solve(steps);
      if (outcome.ending == Ending::kInfeasible) method_.write_farkas(u);
      if (outcome.ending == Ending::kSolved) take_active_set();
    }
    if (outcome.ending != Ending::kSolved) return outcome;
    if (!write_answer(z, velocity)) {
      outcome.ending = Ending::kBreakdown;
      return outcome;
    }
    const auto found = answer(velocity_.data(), change_.data());
    if (!test_.passes(found, pressing_.data(), count_, rules.accept_residual)) outcome.ending = Ending::kRejected;
    outcome.has_velocity = (test_.is_far_from_underflow() || keeps_digits()) && test_.holds_velocity(found);
    return outcome;
  }

  double residual(const double* z) override {
    if (!usable_) return __builtin_inf();
    const Count pressed = take_impulses(z);
    return test_.residual(answer(nullptr, nullptr), pressing_.data(), pressed);
  }

 private:
  static constexpr Count kWorkOfShortestSolve = 9000;

  // --- the methods ---

  /// Contacts that yield.
  Ending yield(const double* start, Steps& steps) {
    yielding_.begin(given_.data(), start);
    for (auto step = YieldingContacts::Step::kTaken; step != YieldingContacts::Step::kLast;) {
      if (const Ending limit = steps.next(); limit != Ending::kSolved) return limit;
      steps.count_factorization();
      steps.add_work(yielding_.work());
      step = yielding_.step(method_.threshold());
      if (step == YieldingContacts::Step::kFailed) return Ending::kBreakdown;
    }
    count_ = yielding_.count();
    copy(change_.data(), yielding_.change(), whitening_.velocity_lanes());
    for (Count k = 0; k < count_; ++k) {
      pressing_[k] = yielding_.contact(k);
      pressing_impulse_[k] = yielding_.impulse(k);
      if (pressing_impulse_[k] < 0) {  // rounding, and returned as zero: the velocity is that of the others
        add_multiple(change_.data(), -pressing_impulse_[k], whitening_.normal(pressing_[k]),
                     whitening_.velocity_lanes());
        pressing_impulse_[k] = 0;
      }
      coordinates_[k] = pressing_impulse_[k] * square_root(whitening_.squared_norm(pressing_[k]));
    }
    return Ending::kSolved;
  }

  /// Contacts that yield and have friction.
  Ending yield_with_friction(double accept_residual, Steps& steps, double* z) {
    if (!friction_.resolves(accept_residual)) return Ending::kBreakdown;
    friction_.begin(given_.data(), mu_);
    if (!finite(friction_.left())) return Ending::kBreakdown;
    while (friction_.left() > accept_residual * accept_residual * method_.squared_scale()) {
      if (const Ending limit = steps.next(); limit != Ending::kSolved) return limit;
      steps.count_factorization();
      if (!friction_.step()) return Ending::kBreakdown;
    }
    for (Count j = 0; j < whitening_.nc(); ++j) z[j] = friction_.impulse(j);
    return Ending::kSolved;
  }

  void take_active_set() {
    method_.find_impulses();
    count_ = method_.count();
    copy(change_.data(), method_.change(), whitening_.velocity_lanes());
    for (Count k = 0; k < count_; ++k) {
      pressing_[k] = method_.contact(k);
      pressing_impulse_[k] = method_.impulse(k);
      coordinates_[k] = method_.coordinate(k);
    }
  }

  // --- the answer ---

  /// False when it is not finite.
  bool write_answer(double* z, double* velocity) {
    set_zero(impulse_.data(), whitening_.contact_lanes());
    for (Count k = 0; k < count_; ++k) {
      if (!finite(pressing_impulse_[k])) return false;
      // A negative one is rounding, or else the test finds what is missing.
      impulse_[pressing_[k]] = pressing_impulse_[k] > 0 ? pressing_impulse_[k] : 0.0;
    }
    compute_velocity();
    if (count_ > 0) keep_unmoved_velocity();
    for (Count j = 0; j < whitening_.nc(); ++j) z[j] = impulse_[j];
    for (Count i = 0; i < whitening_.ngc(); ++i) {
      velocity[i] = velocity_[i];
      if (!finite(velocity[i])) return false;
    }
    return true;
  }

  void compute_velocity() {
    const Count lanes = whitening_.velocity_lanes();
    if (count_ == 0) {
      copy(velocity_.data(), v_.data(), lanes);
    } else if (whitening_.triangular()) {
      // v plus the change, not C^-1 of their sum: a coordinate may move by far less than what the terms of C v lose.
      copy(velocity_.data(), change_.data(), lanes);
      whitening_.solve(velocity_.data());
      add_multiple(velocity_.data(), 1.0, v_.data(), lanes);
    } else if (whitening_.is_of_inverse()) {  // without its root, whose rounding moves what G* does not
      set_zero(impulse_sum_.data(), lanes);
      for (Count k = 0; k < count_; ++k) {
        add_unpadded_multiple(impulse_sum_.data(), impulse_[pressing_[k]], whitening_.given_normal(pressing_[k]),
                              whitening_.ngc());
      }
      copy(velocity_.data(), v_.data(), lanes);
      for (Count i = 0; i < whitening_.ngc(); ++i) {
        add_unpadded_multiple(velocity_.data(), impulse_sum_[i], whitening_.inertia_column(i), whitening_.ngc());
      }
    } else {
      whitening_.add_response(v_.data(), change_.data(), velocity_.data());
    }
  }

  /// What no impulse moves has the velocity that was given, without any rounding.
  void keep_unmoved_velocity() {
    const bool is_one = island_of_coordinate_ == nullptr;
    if (is_one && impulse_[pressing_[0]] != 0) return;  // as nearly always: it saves the loops
    for (Count k = 0; k < whitening_.nc(); ++k) is_moved_[k] = false;
    for (Count k = 0; k < count_; ++k) {
      const Count island = is_one ? 0 : island_of_contact_[pressing_[k]];
      if (island >= 0 && impulse_[pressing_[k]] != 0) is_moved_[island] = true;
    }
    for (Count i = 0; i < whitening_.ngc(); ++i) {
      const Count island = is_one ? 0 : island_of_coordinate_[i];
      if (island < 0 || !is_moved_[island]) velocity_[i] = v_[i];
    }
  }

  /// Whether no velocity, in the metric of the inertia, is so small that underflow takes digits that count: a body of
  /// 1e-55 kg at 1e-320 m/s would stand still, though no impulse stops it.
  [[gnu::noinline]] bool keeps_digits() const {
    // What underflows beside it, 2^-1074, is no more than the rounding that the verdict allows, 2^-53 of it.
    constexpr double kLeast = 1e-140;
    for (Count k = 0; k < count_; ++k) {
      if (coordinates_[k] != 0 && magnitude(coordinates_[k]) < kLeast) return false;
    }
    if (!whitening_.triangular() || count_ == 0) return true;
    const auto zero = L::broadcast(0);
    auto missing = zero;
    for (Count i = 0; i < whitening_.velocity_lanes(); i += L::kWidth) {
      const auto v = L::load(v_.data() + i);
      const auto distance = L::load(whitening_.root_diagonal() + i) * L::max(v, -v);
      missing = L::max(v == zero ? zero : L::broadcast(kLeast) - distance, missing);
    }
    return !(L::max(missing) > 0);
  }

  // --- the test of an answer ---

  /// Puts the contacts with an impulse into pressing_. @returns how many
  Count take_impulses(const double* z) {
    Count pressed = 0;
    for (Count j = 0; j < whitening_.nc(); ++j) {
      impulse_[j] = z[j];
      if (z[j] != 0) pressing_[pressed++] = j;
    }
    for (Count j = whitening_.nc(); j < whitening_.contact_lanes(); ++j) impulse_[j] = 0;
    return pressed;
  }

  VelocityTest::Answer answer(const double* velocity, const double* whitened_change) {
    return {.v = v_.data(),
            .given = given_.data(),
            .scale = scale_,
            .impulse = impulse_.data(),
            .slack = slack_.data(),
            .velocity = velocity,
            .whitened_change = whitened_change};
  }

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
  Whitening whitening_;
  DualMethod method_{whitening_};
  YieldingContacts yielding_{whitening_};
  YieldingFriction friction_{whitening_};
  VelocityTest test_{whitening_};
  bool usable_ = false;
  const double* b_ = nullptr;   // nullptr: zero
  const double* mu_ = nullptr;  // nullptr: no friction

  Buffer<double> v_;      // ngc
  Buffer<double> given_;  // N'v + b
  double scale_ = 0;      // the largest approach in it; infinite where an entry is
  Buffer<double> y0_;     // C v

  Count count_ = 0;  // of the contacts that the method found to press
  Buffer<Count> pressing_;
  Buffer<double> pressing_impulse_;
  Buffer<double> coordinates_;  // what each adds to change_, along one of orthonormal directions
  Buffer<double> change_;       // of the whitened velocity
  Buffer<double> velocity_;
  Buffer<double> impulse_;      // by contact
  Buffer<double> slack_;        // the test's memory, by contact
  Buffer<double> impulse_sum_;  // N z
  Buffer<bool> is_moved_;       // by island
};

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
