#pragma once

#include "native/active_set/whitening.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

/// Whether impulses solve the problem, judged by w = N'(v + G* N z) with a bound on what rounding does to it, each
/// island by its own scale. Float is not bounded: the engine that tests its answers in double does that.
///
/// Three bounds, each sharper and dearer than the one before. For G = C'C - E, E within backward_error(), a change of u
/// is off by G^-1 E times it, which no contact sees by more than |W_j| |A^-1|^(1/2) |E x|, A and E scaled to unit
/// diagonal of G: first with |A^-1| bounded by the determinant, then by the trace of the inverse. Last, in double, the
/// residual r = N z - G x of the very change x at hand is formed in more bits: x is off by G^-1 r, of which a contact
/// sees no more than |W_j| |r|_G*.
template <class Scalar>
class VelocityTest {
  using L = Lanes<Scalar>;

 public:
  /// By contact but for v. `slack` is memory for w.
  struct Answer {
    const Scalar* v;
    const Scalar* given;  ///< N'v
    const Scalar* impulse;
    Scalar* slack;
  };

  explicit VelocityTest(Whitening<Scalar>& whitening) : whitening_(whitening) {}

  void reserve(const Input& input) {
    const Count vectors = L::padded(input.ngc);
    change_.resize(vectors + 1);
    residual_.resize(vectors + 1);
    terms_.resize(L::padded(input.nc) + 1);
    measures_.resize(input.nc + 1);  // islands have contacts: there are no more of them
  }

  /// @pre the whitening is loaded, and usable
  void load(const Input& input) {
    bound_coarsely();
    islands_ = input.island_of_contact == nullptr ? 1 : input.islands;
    island_of_contact_ = input.island_of_contact;
    island_of_coordinate_ = input.island_of_coordinate;
  }

  /// Whether each island's residual with its rounding is within `limit` of its scale. Only the first `pressed` contacts
  /// of `active` may have an impulse.
  bool passes(const Answer& answer, const Count* active, Count pressed, Scalar limit) {
    active_ = active;
    pressed_ = pressed;
    set_zero(change_.data(), lanes());
    for (Count k = 0; k < pressed; ++k) {
      add_unpadded_multiple(change_.data(), answer.impulse[active[k]], whitening_.given_normal(active[k]),
                            whitening_.ngc());
    }
    if (whitening_.triangular()) {
      whitening_.solve_transposed(change_.data());
    } else {
      whitening_.project(change_.data(), residual_.data());
      copy(change_.data(), residual_.data(), lanes());
    }
    combine_rows(answer.slack, answer.given, whitening_.row(0), whitening_.row_stride(), change_.data(),
                 whitening_.rank(), contact_lanes());
    if (islands_ == 1 && passes_as_a_whole(answer, limit)) return true;
    if (whitening_.triangular()) whitening_.solve(change_.data());  // u - v
    return passes_by_islands(answer, limit);
  }

 private:
  static constexpr double kRoundings = 8;           ///< of a sum of products, beside one for each of them
  static constexpr double kTrusted = 0.1;           ///< share of G's least eigenvalue that rounding may take
  static constexpr double kRoom = 1.25;             ///< for G instead of C'C within kTrusted, and for rounding it
  static constexpr double kFloor = 0x1p-53 / 1e-4;  ///< of the verdict: the rounding of q in double counts as solved
  static constexpr bool kTestedInDouble =
      sizeof(Scalar) < sizeof(double);  ///< by the engine that knows what float rounds
  static constexpr bool kHasMoreBits = sizeof(Scalar) == sizeof(double);
  static constexpr double kLongUnitRoundoff = static_cast<double>(__LDBL_EPSILON__) / 2;

  /// What an answer is worth, over an island or all.
  struct Measure {
    Scalar worst = 0;             ///< max |min(|W_j|^2 z_j, w_j)|
    Scalar largest = 0;           ///< max |W_j|^2
    Scalar terms = 0;             ///< sum of |W_j| z_j
    Scalar squared_change = 0;    ///< sum of (u - v)_i^2 G_ii
    Scalar squared_residual = 0;  ///< |C^-T r|^2
    Scalar scale = 0;             ///< max|q|, or the floor that the rounding of q sets
  };

  Count lanes() const { return whitening_.velocity_lanes(); }
  Count contact_lanes() const { return whitening_.contact_lanes(); }
  Scalar size() const { return static_cast<Scalar>(static_cast<double>(whitening_.ngc())); }
  static Scalar roundings(double count) {
    return static_cast<Scalar>(kRoundings + count) * static_cast<Scalar>(L::kUnitRoundoff);
  }

  Scalar largest_given(const Answer& answer) const {
    auto largest = L::broadcast(0);
    for (Count j = 0; j < contact_lanes(); j += L::kWidth) {
      const auto given = L::load(answer.given + j);
      largest = L::max(L::max(given, -given), largest);
    }
    return L::max(largest);
  }

  /// All contacts in one island, max|q| for its scale, and a coarse bound for all rounding.
  bool passes_as_a_whole(const Answer& answer, Scalar limit) {
    auto worst = L::broadcast(0), largest = L::broadcast(0), squares = L::broadcast(0), poison = L::broadcast(0);
    for (Count j = 0; j < contact_lanes(); j += L::kWidth) {
      const auto squared = L::load(whitening_.squared_norms() + j);
      const auto impulse = L::load(answer.impulse + j);
      const auto pressure = squared * impulse;
      const auto least = L::min(pressure, L::load(answer.slack + j));
      squares += pressure * impulse;
      worst = L::max(L::max(least, -least), worst);
      largest = L::max(squared, largest);
      poison += least - least;
    }
    if (!(L::sum(poison) == 0)) return false;
    // No impulse moves the velocities by more than this root, by Cauchy and Schwarz.
    const Scalar moved =
        L::square_root(L::max(largest) * L::sum(squares) * static_cast<Scalar>(static_cast<double>(pressed_)));
    const Scalar most = limit * largest_given(answer) - L::max(worst);
    if (coarse_rounding_of_terms_ * moved <= most && !whitening_.triangular()) return true;
    if (kTestedInDouble || !whitening_.triangular()) return kTestedInDouble && most >= 0;
    const Scalar change = L::square_root(L::max(largest) * dot(change_.data(), change_.data(), lanes()));
    if (coarse_rounding_of_change_ * change + coarse_rounding_of_terms_ * moved <= most) return true;
    whitening_.sharpen_condition();
    bound_coarsely();
    return coarse_rounding_of_change_ * change + coarse_rounding_of_terms_ * moved <= most;
  }

  /// What rounding() is at most, whatever the answer: relative to |W_j| |x|_G, and to a bound on all |W_i'W_j| z_j that
  /// count.
  void bound_coarsely() {
    coarse_rounding_of_change_ = coarse_rounding_of_terms_ = 0;
    if (kTestedInDouble) return;
    const Scalar sums = roundings(4 * static_cast<double>(whitening_.ngc()));
    if (!whitening_.triangular()) {
      coarse_rounding_of_terms_ = 2 * whitening_.noise() + sums;
      return;
    }
    coarse_rounding_of_change_ = condition_is_trusted() ? lost() : kInfinity<Scalar>;
    coarse_rounding_of_terms_ = sums * L::square_root(size() * whitening_.condition());
  }

  /// At most the share of G's least eigenvalue, scaled to unit diagonal, that the rounding of C may take.
  Scalar lost() const { return size() * whitening_.backward_error() * whitening_.condition(); }
  bool condition_is_trusted() const { return lost() < static_cast<Scalar>(kTrusted); }

  bool passes_by_islands(const Answer& answer, Scalar limit) {
    if (!kTestedInDouble && whitening_.triangular()) whitening_.sharpen_condition();
    for (Count k = 0; k < islands_; ++k) measures_[k] = Measure();
    for (Count i = 0; i < whitening_.ngc() && whitening_.triangular(); ++i) {
      const Count k = island_of_coordinate_ == nullptr ? 0 : island_of_coordinate_[i];
      const Scalar diagonal = static_cast<Scalar>(whitening_.inertia(i, i));
      if (k >= 0) measures_[k].squared_change += diagonal * change_[i] * change_[i];
    }
    for (Count j = 0; j < whitening_.nc(); ++j) {
      const Count k = island_of_contact(j);
      if (k >= 0 && !add_given(answer, j, measures_[k])) return false;
    }
    if constexpr (kHasMoreBits) {
      if (measures_residual()) measure_residual(answer);
    }
    for (Count j = 0; j < whitening_.nc(); ++j) {
      const Count k = island_of_contact(j);
      if (k >= 0 && !add_worst(answer, j, measures_[k])) return false;
    }
    if (islands_pass(limit)) return true;
    for (Count j = 0; j < whitening_.nc(); ++j) {
      const Count k = island_of_contact(j);
      if (k < 0) continue;
      const Scalar floor = static_cast<Scalar>(kFloor) * floor_terms(answer, j);
      measures_[k].scale = floor > measures_[k].scale ? floor : measures_[k].scale;
    }
    return islands_pass(limit);
  }

  bool islands_pass(Scalar limit) const {
    for (Count k = 0; k < islands_; ++k) {
      const Scalar rest = measures_residual() ? Scalar(0) : rounding(measures_[k]);
      if (!(measures_[k].worst + rest <= limit * measures_[k].scale)) return false;
    }
    return true;
  }

  Count island_of_contact(Count j) const { return island_of_contact_ == nullptr ? 0 : island_of_contact_[j]; }
  bool measures_residual() const { return kHasMoreBits && whitening_.triangular(); }

  /// What does not depend on w. False for an impulse that is no number, or too large.
  bool add_given(const Answer& answer, Count j, Measure& island) const {
    const Scalar squared = whitening_.squared_norm(j);
    if (!finite(squared * answer.impulse[j])) return false;
    island.largest = squared > island.largest ? squared : island.largest;
    island.terms += L::square_root(squared) * magnitude(answer.impulse[j]);
    const Scalar given = magnitude(answer.given[j]);
    island.scale = given > island.scale ? given : island.scale;
    return finite(given);
  }

  bool add_worst(const Answer& answer, Count j, Measure& island) const {
    if (!finite(answer.slack[j])) return false;
    const Scalar pressure = whitening_.squared_norm(j) * answer.impulse[j];
    const Scalar off = magnitude(answer.slack[j] < pressure ? answer.slack[j] : pressure);
    const Scalar with_rounding = measures_residual() ? off + rounding(island, j) : off;
    if (!finite(with_rounding)) return false;
    island.worst = with_rounding > island.worst ? with_rounding : island.worst;
    return true;
  }

  /// One more than the nonzero entries of the normal, times the sum of the magnitudes of what N_j'v adds up.
  Scalar floor_terms(const Answer& answer, Count j) const {
    Count entries = 1;
    Scalar terms = 0;
    for (Count i = 0; i < whitening_.ngc(); ++i) {
      const double entry = whitening_.given_normal(j)[i];
      entries += entry != 0 ? 1 : 0;
      terms += magnitude(static_cast<Scalar>(entry) * answer.v[i]);
    }
    return static_cast<Scalar>(static_cast<double>(entries)) * terms;
  }

  /// How far the velocity of a contact of the island may be off by the backward error of C.
  Scalar rounding(const Measure& island) const {
    if (kTestedInDouble) return 0;
    if (!(island.terms > 0)) return island.terms == 0 ? Scalar(0) : kInfinity<Scalar>;
    const Scalar reach = L::square_root(island.largest);
    const Scalar sums = roundings(static_cast<double>(whitening_.ngc() + pressed_));
    if (!whitening_.triangular()) return reach * island.terms * (2 * whitening_.noise() + sums);
    if (!condition_is_trusted()) return kInfinity<Scalar>;
    return reach * L::square_root(whitening_.condition()) *
           (size() * whitening_.backward_error() * L::square_root(island.squared_change) +
            sums * L::square_root(size()) * island.terms);
  }

  /// The same of contact j by the residual of the change. @pre measure_residual()
  Scalar rounding(const Measure& island, Count j) const {
    if (!(island.terms > 0)) return island.terms == 0 ? Scalar(0) : kInfinity<Scalar>;
    if (!condition_is_trusted()) return kInfinity<Scalar>;
    // Of r itself, in which N z and G x cancel.
    const double terms = static_cast<double>(whitening_.ngc() + pressed_);
    const Scalar bits = static_cast<Scalar>(kLongUnitRoundoff * (kRoundings + terms));
    const Scalar own = bits * (L::square_root(size()) * island.terms + size() * L::square_root(island.squared_change));
    const Scalar residual = L::square_root(island.squared_residual) + L::square_root(whitening_.condition()) * own;
    return static_cast<Scalar>(kRoom) * L::square_root(whitening_.squared_norm(j)) * residual +
           roundings(static_cast<double>(whitening_.ngc())) * terms_[j];
  }

  /// Of x = change_, u - v: r by islands, and slack = w from x as it is, with terms_ = the magnitudes of what it adds.
  void measure_residual(const Answer& answer) {
    const Count ngc = whitening_.ngc();
    for (Count i = 0; i < ngc; ++i) {
      const double* const column = whitening_.inertia_column(i);
      long double first = 0, second = 0;
      for (Count k = 0; k < pressed_; ++k) {
        first += static_cast<long double>(whitening_.given_normal(active_[k])[i]) *
                 static_cast<long double>(answer.impulse[active_[k]]);
      }
      Count j = 0;
      for (; j + 1 < ngc; j += 2) {
        first -= static_cast<long double>(column[j]) * static_cast<long double>(change_[j]);
        second -= static_cast<long double>(column[j + 1]) * static_cast<long double>(change_[j + 1]);
      }
      if (j < ngc) first -= static_cast<long double>(column[j]) * static_cast<long double>(change_[j]);
      residual_[i] = static_cast<double>(first + second);
    }
    for (Count i = ngc; i < lanes(); ++i) residual_[i] = 0;
    whitening_.solve_transposed(residual_.data());
    for (Count i = 0; i < ngc; ++i) {
      const Count k = island_of_coordinate_ == nullptr ? 0 : island_of_coordinate_[i];
      if (k >= 0) measures_[k].squared_residual += residual_[i] * residual_[i];
    }
    move_contacts(answer);
  }

  void move_contacts(const Answer& answer) {
    for (Count j = 0; j < contact_lanes(); j += L::kWidth) {
      auto sum = L::load(answer.given + j), terms = L::broadcast(0);
      for (Count i = 0; i < whitening_.ngc(); ++i) {
        const auto part = L::load(whitening_.normals(i) + j) * L::broadcast(change_[i]);
        sum += part;
        terms += L::max(part, -part);
      }
      L::store(answer.slack + j, sum);
      L::store(terms_.data() + j, terms);
    }
  }

  Whitening<Scalar>& whitening_;
  const Count* active_ = nullptr;
  Count pressed_ = 0;
  Buffer<Scalar> change_;    // C^-T N z, then u - v
  Buffer<Scalar> residual_;  // of u - v
  Buffer<Scalar> terms_;     // by contact
  Scalar coarse_rounding_of_change_ = 0;
  Scalar coarse_rounding_of_terms_ = 0;
  Count islands_ = 1;
  const Count* island_of_contact_ = nullptr;  // nullptr: all are in one
  const Count* island_of_coordinate_ = nullptr;
  Buffer<Measure> measures_;  // by island
};

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
