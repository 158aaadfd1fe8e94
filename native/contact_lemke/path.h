#pragma once

#include "native/contact_lemke/exchange.h"
#include "native/contact_lemke/rounded_shares.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// Lemke's path through the bases of a contact problem (see Basis).
template <class Scalar>
class Path {
 public:
  /// Takes all memory that load() needs; touches hardly any of it.
  void reserve(const contact_lemke::Input& input) {
    basis_.reserve(input);
    variables_.reserve();
    ratio_test_.reserve();
    exchange_.reserve();
    basis_velocity_.resize(contacts_.extent());
    if constexpr (kRoundsShares) {
      shares_.reserve(basis_.coordinates());
      rounded_.resize(kernel_.stride());
    }
  }

  void load(const contact_lemke::Input& input) {
    reserve(input);
    basis_.load(input);
    variables_.load();
    has_basis_ = false;
    if constexpr (kRoundsShares) shares_.load(basis_.coordinates());
  }

  void set_velocity(const double* v) { contacts_.set_velocity(v); }

  contact_lemke::Outcome solve(const contact_lemke::Rules& rules, double* z) {
    rules_ = rules;
    outcome_ = {};
    basis_.work = kWorkOfShortestPath;
    basis_.factorizations = 0;
    outcome_.ending = follow(z);
    outcome_.work = basis_.work;
    outcome_.factorizations = basis_.factorizations;
    has_basis_ = outcome_.ending == Ending::kSolved && !rules_.classic && kernel_.artificial() < 0;
    if (has_basis_) copy(basis_velocity_.data(), contacts_.velocity(), contacts_.extent());
    return outcome_;
  }

  Contacts<Scalar>& contacts() { return contacts_; }
  Response<Scalar>& response() { return basis_.response; }

 private:
  using Ending = contact_lemke::Ending;
  using Kind = LeavingVariable::Kind;
  static constexpr Count kWorkOfShortestPath = 8000;
  static constexpr bool kRoundsShares = sizeof(Scalar) > sizeof(double);

  /// Lemke's method [Lemke 1965; Cottle, Pang, Stone 1992, algorithm 4.4.5]. z0 multiplies the covering vector.
  ///
  /// Impulses and velocities are complementary, those of friction by lambda and the cone row. Every basis on the way
  /// has one of each pair, but for one pair that z0 stands in for. Nothing breaks ties in a fixed order: a path that
  /// cycles ends at the limit on pivots.
  Ending follow(double* z) {
    if (expired()) return Ending::kTimeLimit;

    // Step 0. At z = 0 all velocities are basic. The covering vector enters, as much of it as makes the most negative
    // velocity zero, which leaves; its complement, an impulse, enters next. If no velocity is negative, z = 0 is the
    // answer.
    Entering& entering = entering_;
    if (rules_.resume) {
      const Start start = resume();
      if (start != Start::kOnPath) return start == Start::kAtAnswer ? finish(z) : Ending::kBreakdown;
    } else {
      begin();
      const Label first = most_negative_velocity();
      if (first.contact == kArtificial) return Ending::kSolved;
      exchange_.start(first);
      entering = {false, first};
    }

    for (;;) {
      if (basis_.work >= rules_.max_work) {
        outcome_.is_out_of_work = true;
        return Ending::kPivotLimit;
      }
      // Values of the basic variables. The answer is found if z0 is zero, by rounding.
      if (rules_.reinvert && !basis_.invert()) return Ending::kBreakdown;
      if (!variables_.compute_values(rules_.reinvert)) return Ending::kBreakdown;
      const Count z0 = kernel_.artificial();
      if (!(variables_.x[z0] * kernel_.norm(z0) > variables_.tie_tolerance())) return finish(z);
      if (outcome_.pivots >= rules_.max_pivots) return Ending::kPivotLimit;
      if (outcome_.pivots % 16 == 15 && expired()) return Ending::kTimeLimit;

      // Step 1. The ratio test: as the entering variable grows, the basic variable that comes to zero first leaves. A
      // contact that begins to press brings its friction. No variable falls: the path ends on a secondary ray.
      const bool presses = !entering.is_velocity && entering.label.is_normal();
      if (presses && !rules_.classic) exchange_.activate_friction(entering.label.contact);
      variables_.compute_rates(entering);
      const LeavingVariable leaving = ratio_test_.find_leaving(entering);
      if (leaving.kind == Kind::kBroken) return Ending::kBreakdown;
      if (leaving.kind == Kind::kNone) {
        if (friction_.count() == 0) write_ray(entering, z);
        return Ending::kRay;
      }

      // Step 2. The exchange, after which the complement of the variable that left enters. If z0 left, the basis is
      // complementary, and the answer is found.
      ++outcome_.pivots;
      count_pivot(entering);
      const bool is_last = leaving.kind == Kind::kColumn && leaving.column == z0;
      if (!exchange_.run(entering, leaving, !rules_.classic)) return Ending::kBreakdown;
      if (is_last) return finish(z);
    }
  }

  bool expired() const { return rules_.clock_s != nullptr && !(rules_.clock_s() < rules_.deadline_s); }

  void begin() {
    basis_.clear();
    variables_.begin();
    ratio_test_.allow_normals();
    basis_.covering.choose(rules_.classic, rules_.variant);
    for (Count c = 0; rules_.classic && c < contacts_.nc(); ++c) {
      if (contacts_.has_friction(c)) exchange_.activate_friction_with_base(c, contacts_.edges(c), true);
    }
  }

  /// By the covering vector: the velocity that needs most of it. Label{} where none is negative.
  Label most_negative_velocity() {
    Label worst;
    Scalar most = 0;
    const auto offer = [&](Label label, Scalar velocity) {
      const Scalar need = -velocity / basis_.covering.of(label);
      if (!(need > most)) return;
      most = need;
      worst = label;
    };
    const Scalar* const normal_velocities = ratio_test_.normal_velocities(variables_.u.data());
    for (Count c = 0; c < contacts_.nc(); ++c) offer(Label{c, kNormal}, normal_velocities[c]);
    for (Count k = 0; k < friction_.count(); ++k) {
      const Count c = friction_.contact(k);
      const Scalar* const slip = exchange_.slip(c);
      const Count half = contacts_.half(c);
      for (Count t = 0; t < half; ++t) {
        offer(Label{c, t}, slip[t]);
        offer(Label{c, t + half}, -slip[t]);
      }
    }
    return worst;
  }

  enum class Start { kAtAnswer, kOnPath, kImpossible };

  /// The basis of the last solve, for v_b, is followed along v = v_now + z0 (v_b - v_now) from z0 = 1, where it is
  /// complementary and feasible, to z0 = 0: Lemke's path with J'(v_b - v_now) as covering vector. No pivot is needed
  /// where the basis stays feasible; else about as many as contacts change. Nothing is proven of its end.
  Start resume() {
    if (!has_basis_) return Start::kImpossible;
    for (Count i = 0; i < contacts_.extent(); ++i) basis_.drift[i] = basis_velocity_[i] - contacts_.velocity()[i];
    basis_.has_drift = true;
    basis_.covering.clear();
    kernel_.set_velocity(contacts_.velocity());
    variables_.begin_at_drift(basis_.drift.data());
    entering_ = {false, Label{}};
    const LeavingVariable leaving = ratio_test_.find_leaving(entering_);
    if (leaving.kind == Kind::kNone) return Start::kAtAnswer;
    if (leaving.kind == Kind::kBroken) return Start::kImpossible;
    variables_.reverse_drift();
    ++outcome_.pivots;
    return exchange_.run(entering_, leaving, true) ? Start::kOnPath : Start::kImpossible;
  }

  /// The work of a pivot that was as easy as most: values, rates and candidates, and the exchange. With the time that
  /// no product takes: of a pivot, and of each candidate.
  void count_pivot(const Entering& entering) {
    constexpr Count kOfPivot = 2000, kOfCandidate = 4;
    const Count order = kernel_.order();
    const Count ngc = contacts_.ngc();
    const Count candidates = contacts_.nc() + ratio_test_.slots();
    const Count products = contacts_.length_of_runs() * candidates + 5 * ngc * order + 4 * order * order;
    const Count response = entering.is_velocity ? 0 : basis_.response.work();
    basis_.work += products + response + kOfCandidate * ratio_test_.slots() + kOfPivot;
  }

  /// The impulses of the last basis, in double.
  Ending finish(double* z) {
    if (!variables_.compute_values(rules_.reinvert)) return Ending::kBreakdown;
    variables_.refine();
    const Scalar* impulses = variables_.x.data();
    Scalar poison = 0;  // stays 0 unless an impulse is NaN or infinite
    for (Count j = 0; j < kernel_.order(); ++j) poison += Scalar(0) * impulses[j];
    if (!(poison == 0)) return Ending::kBreakdown;
    if constexpr (kRoundsShares) {
      if (round_impulses()) impulses = rounded_.data();
    }
    write_impulses(impulses, z);
    return Ending::kSolved;
  }

  /// rounded_ := the impulses of the kernel's columns as doubles, 0 for those that are not positive. They are rounded
  /// in turn, and each makes up for the rounding of those before (see RoundedShares), so that the velocities hardly
  /// change. Nearly dependent contacts may have impulses of 1e12 N s that cancel: rounding each by itself changes velocities.
  /// @returns false where there are no factors of G*, or the columns are dependent: then rounded_ is of no use
  bool round_impulses() {
    if (!basis_.response.has_factors()) return false;
    const Scalar* const x = variables_.x.data();
    const Scalar* const a = basis_.column.data();
    const auto is_rounded = [&](Count j) { return j != kernel_.artificial() && x[j] > 0; };
    shares_.clear();
    for (Count j = 0; j < kernel_.order(); ++j) {
      rounded_[j] = 0;
      if (!is_rounded(j)) continue;
      Scalar* const to = shares_.next_column();
      if (to == nullptr) return false;  // more columns than coordinates: they are dependent
      basis_.load_column(kernel_.column_label(j), basis_.column.data());
      basis_.response.whiten(a, to);
      for (Count i = contacts_.padded_ngc(); i < contacts_.extent(); ++i) {
        to[i] = square_root(contacts_.compliance()[i - contacts_.padded_ngc()]) * a[i];
      }
      scale(to, x[j], contacts_.extent());
    }
    return shares_.round([&](Count column, Scalar share) {
      Count j = 0;  // the kernel's column that is number `column` among the rounded ones
      for (;; ++j) {
        if (is_rounded(j) && column-- == 0) break;
      }
      const double value = static_cast<double>(share * x[j]);
      rounded_[j] = value > 0 ? Scalar(value) : Scalar(0);
      return rounded_[j] / x[j];
    });
  }

  /// Writes impulses of the kernel's columns to z, negative ones as 0. The impulse of each contact's base, which is no
  /// column, is what the others leave of mu f_N.
  void write_impulses(const Scalar* impulses, double* z) const {
    for (Count j = 0; j < kernel_.order(); ++j) {
      const Label label = kernel_.column_label(j);
      if (label.contact == kArtificial) continue;
      const Scalar value = impulses[j] > 0 ? impulses[j] : Scalar(0);
      if (label.is_normal()) z[label.contact] = static_cast<double>(value);
      if (!label.is_normal()) write_friction(label, value, z);
    }
    for (Count k = 0; k < friction_.count(); ++k) {
      const Count c = friction_.contact(k);
      Scalar rest = 0;
      for (Count j = 0; j < kernel_.order(); ++j) {
        const Label label = kernel_.column_label(j);
        if (label.contact == c && impulses[j] > 0) rest += basis_.simplex_weight(label) * impulses[j];
      }
      write_friction(Label{c, friction_.base(c)}, rest > 0 ? rest : Scalar(0), z);
    }
  }

  void write_friction(Label label, Scalar value, double* z) const {
    if (label.direction == contacts_.edges(label.contact)) return;
    z[contacts_.nc() + contacts_.first_direction(label.contact) + label.direction] = static_cast<double>(value);
  }

  /// The impulses u along a ray without friction. There 0 = u'w = u'M u + z0 u'd with u, M u + z0 d >= 0: N u is in
  /// null(G), and z0 does not grow. @pre no contact has friction
  void write_ray(const Entering& entering, double* z) const {
    if (!entering.is_velocity) z[entering.label.contact] = 1;
    for (Count j = 0; j < kernel_.order(); ++j) {
      const Label label = kernel_.column_label(j);
      if (label.is_normal() && variables_.dx[j] > 0) z[label.contact] = static_cast<double>(variables_.dx[j]);
    }
  }

  contact_lemke::Rules rules_;
  contact_lemke::Outcome outcome_;
  Basis<Scalar> basis_;
  BasicVariables<Scalar> variables_{basis_};
  RatioTest<Scalar> ratio_test_{basis_, variables_};
  Exchange<Scalar> exchange_{basis_, variables_, ratio_test_};
  Contacts<Scalar>& contacts_ = basis_.contacts;
  Kernel<Scalar>& kernel_ = basis_.kernel;
  FrictionState& friction_ = basis_.friction;
  RoundedShares<Scalar> shares_;
  Buffer<Scalar> rounded_;         ///< per column of the kernel
  Entering entering_;              ///< the variable that enters next
  bool has_basis_ = false;         ///< that of a solve, at basis_velocity_
  Buffer<Scalar> basis_velocity_;  ///< extent() entries
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
