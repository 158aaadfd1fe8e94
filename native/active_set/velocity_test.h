#pragma once

#include "core/answer/contact_scale.h"
#include "native/active_set/twofold_sum.h"
#include "native/active_set/whitening.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

/// Whether impulses z solve the problem, judged by w = N'(v + G* N z) + b + r_n z with a bound on what rounding does to
/// it, each island by its own scale.
///
/// Sharper bounds take longer, and are computed only where coarser ones do not decide. Let x = u - v, and C'C = G + E
/// with E within backward_error(). Then x is off by G^-1 E x, of which contact j sees at most |W_j| |A^-1|^(1/2) |E x|,
/// A and E scaled to unit diagonal of G. The bounds, in this order:
///   1. |A^-1| is bounded by what loading G leaves (Whitening::condition()).
///   2. Of one island: the residual r = N z - G x is formed in more bits. x is off by G^-1 r, of which a
///      contact sees at most |W_j| |r|_G*, here with the longest normal.
///   3. |A^-1| is bounded by the trace of the inverse (Whitening::sharpen_condition()).
///   4. r again, of all islands, with the normal of each contact.
class VelocityTest {
  using Scalar = double;
  using L = Lanes<Scalar>;

 public:
  /// The first and the last two by coordinate, the others by contact; one scale.
  struct Answer {
    const Scalar* v;
    const Scalar* given;  ///< N'v + b
    Scalar scale;         ///< at most that of any island: max(-given), or the least that any has
    const Scalar* impulse;
    Scalar* slack;                            ///< memory for w
    const Scalar* velocity = nullptr;         ///< about v + G* N z
    const Scalar* whitened_change = nullptr;  ///< what velocity was made of: about C (u - v)
  };

  explicit VelocityTest(Whitening& whitening) : whitening_(whitening) {}

  void reserve(Count ngc, Count nc) {
    const Count vectors = L::padded(ngc);
    resize_all(vectors + 1, change_, residual_, moved_);
    terms_.resize(L::padded(nc) + 1);
    measures_.resize(nc + 1);  // islands have contacts: there are no more of them
  }

  /// @pre the whitening is loaded, and usable
  void load(const Input& input) {
    islands_ = input.island_of_contact == nullptr ? 1 : input.islands;
    island_of_contact_ = input.island_of_contact;
    island_of_coordinate_ = input.island_of_coordinate;
    is_whole_ = islands_ == 1;
    for (Count j = 0; j < input.nc && input.b != nullptr && is_whole_; ++j) is_whole_ = island_of_contact(j) >= 0;
  }

  /// Whether each island's residual with its rounding is within `limit` of its scale. Only the first `pressed` contacts
  /// of `active` may have an impulse.
  bool passes(const Answer& answer, const Count* active, Count pressed, Scalar limit) {
    active_ = active;
    pressed_ = pressed;
    is_off_known_ = is_far_from_underflow_ = false;
    const bool has_residual = this->has_residual(answer);
    const bool needs_residual = has_residual && exceeds_bound(answer, limit);
    if (needs_residual && passes_by_residual(answer, limit)) return true;
    respond(answer);
    if (is_whole_ && !needs_residual && passes_as_a_whole(answer, limit)) return true;
    if (has_residual && !needs_residual && passes_by_residual(answer, limit)) return true;
    if (whitening_.triangular()) whitening_.solve(change_.data());  // u - v
    return passes_by_islands(answer, limit);
  }

  /// The largest residual of an island relative to its scale, without its rounding. Infinite where it is no number.
  double residual(const Answer& answer, const Count* active, Count pressed) {
    active_ = active;
    pressed_ = pressed;
    by_residual_ = false;
    respond(answer);
    for (Count k = 0; k < islands_; ++k) measures_[k] = {};
    for (Count j = 0; j < whitening_.nc(); ++j) {
      const Count k = island_of_contact(j);
      if (k >= 0 && !(add_given(answer, j, measures_[k]) && add_worst(answer, j, measures_[k]))) {
        return kInfinity<double>;
      }
    }
    add_floors(answer);
    double largest = 0;
    for (Count k = 0; k < islands_; ++k) {
      const Scalar worst = measures_[k].worst;
      if (!(worst > 0)) continue;
      const double relative = static_cast<double>(worst / measures_[k].scale.value());
      largest = relative > largest ? relative : largest;
    }
    return largest;
  }

  /// Whether the impulses that passes() saw, all of one island, are so large that no underflow counts beside them.
  bool is_far_from_underflow() const { return is_far_from_underflow_; }

  /// Whether rounding in the factors of the inertia takes at most kMostLost of a velocity.
  bool trusts_factors() const {
    return (whitening_.triangular() ? whitening_.lost() : whitening_.noise()) <= static_cast<Scalar>(kMostLost);
  }

  /// Whether the velocity is that of the impulses to half of what the verdict allows each coordinate. Where rounding
  /// may take more than kMostLost, the residual has to show it; nothing does where a contact that yields has an impulse
  /// whose response was taken for rounding.
  /// @pre passes() of the same answer
  bool holds_velocity(const Answer& answer) {
    for (Count k = 0; k < pressed_; ++k) {
      if (!whitening_.moves(active_[k]) && answer.impulse[active_[k]] != 0) return false;
    }
    if (pressed_ == 0) return true;
    if (trusts_factors()) return true;
    if (!whitening_.triangular()) return false;
    return has_residual(answer) && residual_shows_velocity(answer);
  }

 private:
  static constexpr double kMostLost = 1e-3;  ///< of a velocity that is returned without more tests
  static constexpr double kRoundings = 8;           ///< of a sum of products, beside one for each of them
  static constexpr double kTrusted = 0.1;           ///< share of G's least eigenvalue that rounding may take
  static constexpr double kRoom = 1.25;             ///< for G instead of C'C within kTrusted, and for rounding it
  static constexpr double kSafeSquare = 1e-280;     ///< no terms that matter beside it have underflowed
  static constexpr double kUnderflow = 1e-170;      ///< more than sums lose to it, over the root of any G_ii

  /// What an answer is worth, over an island or all.
  struct Measure {
    Scalar worst = 0;             ///< max |min(|W_j|^2 z_j, w_j)|
    Scalar largest = 0;           ///< max |W_j|^2, without C of squared_length()
    Scalar terms = 0;             ///< sum of |W_j| z_j, alike
    Scalar squared_change = 0;    ///< sum of (u - v)_i^2 G_ii
    Scalar squared_residual = 0;  ///< |C^-T r|^2
    ContactScale<Scalar> scale{};  ///< without speeds and rounding until add_floors()
  };

  Count lanes() const { return whitening_.velocity_lanes(); }
  Count contact_lanes() const { return whitening_.contact_lanes(); }
  Scalar size() const { return static_cast<Scalar>(static_cast<double>(whitening_.ngc())); }
  static Scalar roundings(double count) {
    return static_cast<Scalar>(kRoundings + count) * static_cast<Scalar>(kUnitRoundoff<Scalar>);
  }

  /// Of all contacts, as one island.
  struct OfAll {
    Scalar worst;    ///< residual of a row
    Scalar squares;  ///< of the pressures, in the metric of the inverse inertia, summed; no number where a residual is
                     ///< none
  };

  OfAll measure_all(const Answer& answer) const {
    auto worst = L::broadcast(0), squares = L::broadcast(0);
    for (Count j = 0; j < contact_lanes(); j += L::kWidth) {
      const auto impulse = L::load(answer.impulse + j);
      const auto pressure = L::load(whitening_.squared_norms() + j) * impulse;
      const auto least = L::min(pressure, L::load(answer.slack + j));
      squares += pressure * impulse + (least - least);  // no number where one of these is none
      worst = L::max(L::max(least, -least), worst);
    }
    return {L::max(worst), L::sum(squares)};
  }

  /// All contacts in one island, and coarse bounds for all rounding.
  bool passes_as_a_whole(const Answer& answer, Scalar limit) {
    const OfAll all = measure_all(answer);
    const Scalar sum = all.squares;
    const Scalar most = limit * answer.scale - all.worst;
    if (!finite(sum) || !finite(most) || !is_double(all.worst)) return false;
    if (pressed_ == 0) return most >= 0;
    if (!(most > 0) || !(sum > static_cast<Scalar>(kSafeSquare))) return false;
    is_far_from_underflow_ = true;
    // No impulse moves the velocities by more than the root of `moved`, by Cauchy and Schwarz.
    const Scalar moved = whitening_.largest_squared_norm() * sum * static_cast<Scalar>(static_cast<double>(pressed_));
    if (!whitening_.triangular()) {
      if (whitening_.cancels()) return false;  // its bounds are by islands
      const Scalar sums = roundings(2 * static_cast<double>(whitening_.ngc()));
      return (2 * whitening_.noise() + sums) * square_root(moved) <= most;
    }
    if (covers_rounding(answer, most, moved)) return true;
    if (has_residual(answer)) return false;  // it is sharper, and takes less time
    whitening_.sharpen_condition();
    return covers_rounding(answer, most, moved);
  }

  /// Whether `most` is at least what rounding does to w: |E x| times |A^-1|^(1/2) |W_j|, and all else in terms of the
  /// root of `moved`. Of squares, without roots: (a + b)^2 <= 1.1 a^2 + 11 b^2.
  bool covers_rounding(const Answer& answer, Scalar most, Scalar moved) const;

  /// The square of |E x| |A^-1|^(1/2) by the length of x in the metric of G. 0: not known.
  Scalar of_whitened_change() const {
    const Scalar squared = dot(change_.data(), change_.data(), lanes());
    return squared > static_cast<Scalar>(kSafeSquare) ? whitening_.lost() * whitening_.lost() * squared : Scalar(0);
  }

  /// The same by its length in the metric of the diagonal of G, which most often is far less than |A^-1|^(1/2) times
  /// the other. The velocity at hand gives it, but for what its whitened change differs from change_ by, and for the
  /// rounding of the velocity itself.
  Scalar of_velocity(const Answer& answer) const;

  /// Whether covers_rounding() will be false whatever w is: what it asks of the change alone is too much already.
  bool exceeds_bound(const Answer& answer, Scalar limit) const {
    auto changes = L::broadcast(0);
    for (Count i = 0; i < lanes(); i += L::kWidth) {
      const auto root = L::load(whitening_.root_diagonal() + i);
      const auto change = root * (L::load(answer.velocity + i) - L::load(answer.v + i));
      changes += change * change;
    }
    const Scalar most = limit * answer.scale;
    const Scalar error = size() * whitening_.backward_error();
    return whitening_.largest_squared_norm() * whitening_.condition() * error * error * L::sum(changes) > most * most;
  }

  bool condition_is_trusted() const { return whitening_.lost() < static_cast<Scalar>(kTrusted); }

  /// Whether passes_by_residual() can say anything, and takes less time than other tests; else it may not be asked.
  bool has_residual(const Answer& answer) const {
    return is_whole_ && whitening_.triangular() && answer.velocity != nullptr &&
           whitening_.ngc() >= L::kWidth && condition_is_trusted();
  }

  /// Whether one island passes by the residual of the velocity that is returned, formed with twice the bits of a
  /// double, and by the longest normal for all of them.
  [[gnu::noinline]] bool passes_by_residual(const Answer& answer, Scalar limit) {
    for (Count i = 0; i < lanes(); i += L::kWidth) {
      L::store(moved_.data() + i, L::load(answer.velocity + i) - L::load(answer.v + i));
    }
    move_contacts(answer, moved_.data());
    form_residual(answer, moved_.data());
    const OfAll all = measure_all(answer);
    auto terms = L::broadcast(0);
    for (Count j = 0; j < contact_lanes(); j += L::kWidth) terms = L::max(L::load(terms_.data() + j), terms);
    auto changes = L::broadcast(0);
    for (Count i = 0; i < lanes(); i += L::kWidth) {
      const auto change = L::load(whitening_.root_diagonal() + i) * L::load(moved_.data() + i);
      changes += change * change;
    }
    const Scalar terms_of_impulse = square_root(static_cast<Scalar>(pressed_) * all.squares);  // by Cauchy and Schwarz
    is_far_from_underflow_ = all.squares > static_cast<Scalar>(kSafeSquare);
    off_ = off_by(dot(residual_.data(), residual_.data(), lanes()), L::sum(changes), terms_of_impulse);
    is_off_known_ = true;
    const Scalar rounding = square_root(whitening_.largest_squared_norm()) * off_ +
                            roundings(static_cast<double>(whitening_.ngc())) * L::max(terms);
    const Scalar most = limit * answer.scale;
    return finite(most) && all.worst + rounding <= most;
  }

  [[gnu::noinline]] bool residual_shows_velocity(const Answer& answer) {
    if (!is_off_known_) passes_by_residual(answer, 0);
    const Scalar off = off_ * square_root(whitening_.condition());
    for (Count i = 0; i < whitening_.ngc(); ++i) {
      const Scalar size = magnitude(answer.v[i]) + magnitude(answer.velocity[i] - answer.v[i]);
      if (!(off <= static_cast<Scalar>(0.5e-4) * whitening_.root_diagonal()[i] * size)) return false;
    }
    return true;
  }

  /// How far a velocity may be off in the metric of G, by the residual of its change.
  /// @param squared_residual  |C^-T r|^2 @param squared_change  sum of x_i^2 G_ii @param terms  sum of |W_j| z_j
  Scalar off_by(Scalar squared_residual, Scalar squared_change, Scalar terms) const {
    const Scalar bits = roundings(static_cast<double>(whitening_.ngc() + pressed_));
    const Scalar own = bits * bits * (size() * square_root(squared_change) + square_root(size()) * terms) +
                       static_cast<Scalar>(kUnderflow);
    return static_cast<Scalar>(kRoom) * (square_root(squared_residual) + square_root(whitening_.condition()) * own);
  }

  /// residual_ := C^-T r of the change x, r = N z - G x.
  void form_residual(const Answer& answer, const Scalar* x) {
    const Count ngc = whitening_.ngc();
    set_zero(residual_.data(), lanes());
    if (ngc == 0) return;
    if (ngc < L::kWidth) {
      form_residual_from(answer, x, 0, [ngc](const double* from) { return load_first<Scalar>(from, ngc); });
    } else {
      for (Count i = 0; i + L::kWidth <= ngc; i += L::kWidth) form_residual_from(answer, x, i, L::load);
      if (ngc % L::kWidth != 0) form_residual_from(answer, x, ngc - L::kWidth, L::load);  // some of it again
    }
    whitening_.solve_transposed(residual_.data());
  }

  template <class Load>
  [[gnu::always_inline]] inline void form_residual_from(const Answer& answer, const Scalar* x, Count i,
                                                        const Load& load) {
    TwofoldSum sum;
    for (Count k = 0; k < pressed_; ++k) {
      const Count contact = active_[k];
      sum.add(load(whitening_.given_normal(contact) + i), L::broadcast(answer.impulse[contact]));
    }
    for (Count j = 0; j < whitening_.ngc(); ++j) {
      sum.add(load(whitening_.inertia_column(j) + i), L::broadcast(-x[j]));
    }
    L::store(residual_.data() + i, sum.value());
  }

  [[gnu::noinline]] bool passes_by_islands(const Answer& answer, Scalar limit) {
    by_residual_ = false;
    for (Count k = 0; k < islands_; ++k) measures_[k] = {};
    for (Count i = 0; i < whitening_.ngc() && whitening_.triangular(); ++i) {
      const Count k = island_of_coordinate_ == nullptr ? 0 : island_of_coordinate_[i];
      const Scalar change = whitening_.root_diagonal()[i] * change_[i];
      if (k >= 0) measures_[k].squared_change += change * change;
    }
    for (Count j = 0; j < whitening_.nc(); ++j) {
      const Count k = island_of_contact(j);
      if (k >= 0 && !add_given(answer, j, measures_[k])) return false;
    }
    bool measured = false;
    // Of one island and its velocity, passes_as_a_whole() has found what these bounds find.
    const bool repeats = whitening_.triangular() && is_whole_ && answer.velocity != nullptr;
    if (!repeats) {
      measured = measure_worst(answer);
      if (measured && islands_pass(limit)) return true;
    }
    if (whitening_.triangular()) {
      whitening_.sharpen_condition();
      if (measured && islands_pass(limit)) return true;
      by_residual_ = true;
      move_contacts(answer, change_.data());
      measure_residual(answer);
      measured = measure_worst(answer);
      if (measured && islands_pass(limit)) return true;
    }
    if (!measured) return false;
    add_floors(answer);
    return islands_pass(limit);
  }

  /// What speeds and their rounding add to the scales of the islands.
  void add_floors(const Answer& answer) {
    for (Count j = 0; j < whitening_.nc(); ++j) {
      const Count k = island_of_contact(j);
      if (k < 0) continue;
      ContactScale<Scalar> with = measures_[k].scale;
      add_row(answer, j, with);
      // A sum beyond the range of the type tells nothing: with an infinite scale any answer would pass.
      if (finite(with.value())) measures_[k].scale = with;
    }
  }

  /// change_ := the whitened change of the velocity, c = C^-T N z; without C, c = S'N z, and residual_ is overwritten.
  /// answer.slack := w = N'v + b + W'c + r_n z. @pre active_ and pressed_ are set
  void respond(const Answer& answer) {
    set_zero(change_.data(), lanes());
    for (Count k = 0; k < pressed_; ++k) {
      if (!whitening_.moves(active_[k])) continue;
      add_unpadded_multiple(change_.data(), answer.impulse[active_[k]], whitening_.given_normal(active_[k]),
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
    for_each_yielding(answer, [&](Count contact, Scalar yields) { answer.slack[contact] += yields; });
  }

  /// visit(contact, r_n z) where an impulse presses on compliance.
  template <class Visit>
  void for_each_yielding(const Answer& answer, const Visit& visit) const {
    for (Count k = 0; k < pressed_ && whitening_.is_soft(); ++k) {
      visit(active_[k], whitening_.compliance(active_[k]) * answer.impulse[active_[k]]);
    }
  }

  bool measure_worst(const Answer& answer) {
    for (Count k = 0; k < islands_; ++k) measures_[k].worst = 0;
    for (Count j = 0; j < whitening_.nc(); ++j) {
      const Count k = island_of_contact(j);
      if (k >= 0 && !add_worst(answer, j, measures_[k])) return false;
    }
    return true;
  }

  bool islands_pass(Scalar limit) const {
    for (Count k = 0; k < islands_; ++k) {
      const Scalar rest = by_residual_ ? Scalar(0) : rounding(measures_[k]);
      if (!(measures_[k].worst + rest <= limit * measures_[k].scale.value())) return false;
    }
    return true;
  }

  Count island_of_contact(Count j) const { return island_of_contact_ == nullptr ? 0 : island_of_contact_[j]; }

  /// Beyond the range of double what is off is no error in m/s, however small it is beside the scale. False for NaN.
  static bool is_double(Scalar off) { return off <= static_cast<Scalar>(__DBL_MAX__); }

  /// What does not depend on w. False for an impulse that is no number, or too large.
  bool add_given(const Answer& answer, Count j, Measure& island) const {
    Scalar squared = whitening_.squared_norm(j);
    if (!finite(squared * answer.impulse[j])) return false;
    if (!whitening_.triangular()) squared = whitening_.squared_length(j);
    island.largest = squared > island.largest ? squared : island.largest;
    island.terms += square_root(squared) * magnitude(answer.impulse[j]);
    island.scale.add_approach(answer.given[j]);
    return finite(answer.given[j]);
  }

  bool add_worst(const Answer& answer, Count j, Measure& island) const {
    if (!finite(answer.slack[j])) return false;
    const Scalar pressure = whitening_.squared_norm(j) * answer.impulse[j];
    const Scalar off = magnitude(answer.slack[j] < pressure ? answer.slack[j] : pressure);
    const Scalar with_rounding = by_residual_ ? off + rounding(island, j) : off;
    if (!is_double(with_rounding)) return false;
    island.worst = with_rounding > island.worst ? with_rounding : island.worst;
    return true;
  }

  /// Adds N_j'v.
  void add_row(const Answer& answer, Count j, ContactScale<Scalar>& scale) const;

  /// How far the velocity of any contact of the island may be off, by the backward error of C.
  Scalar rounding(const Measure& island) const;

  /// How far the velocity of contact j may be off, by the residual of the change. @pre measure_residual()
  Scalar rounding(const Measure& island, Count j) const;

  /// r by islands, of x = change_, u - v.
  [[gnu::noinline]] void measure_residual(const Answer& answer);

  /// slack = w from x as it is, terms_ = the magnitudes of what x adds to it.
  void move_contacts(const Answer& answer, const Scalar* x) {
    for (Count j = 0; j < contact_lanes(); j += L::kWidth) {
      auto sum = L::load(answer.given + j), terms = L::broadcast(0);
      for (Count i = 0; i < whitening_.ngc(); ++i) {
        const auto part = L::load(whitening_.normals(i) + j) * L::broadcast(x[i]);
        sum += part;
        terms += L::max(part, -part);
      }
      L::store(answer.slack + j, sum);
      L::store(terms_.data() + j, terms);
    }
    for_each_yielding(answer, [&](Count contact, Scalar yields) {
      answer.slack[contact] += yields;
      terms_[contact] += magnitude(yields);
    });
  }

  Whitening& whitening_;
  const Count* active_ = nullptr;
  Count pressed_ = 0;
  bool by_residual_ = false;  // the rounding is told by contact, from the residual
  Buffer<Scalar> change_;     // C^-T N z, then u - v; without C S'N z
  Buffer<Scalar> residual_;   // C^-T r, r the residual of u - v
  Buffer<Scalar> moved_;      // u - v of the velocity that is returned
  Buffer<Scalar> terms_;      // by contact
  Count islands_ = 1;
  bool is_whole_ = true;                      // one island has all contacts that may have a w
  const Count* island_of_contact_ = nullptr;  // nullptr: all are in one
  const Count* island_of_coordinate_ = nullptr;
  Buffer<Measure> measures_;  // by island
  bool is_far_from_underflow_ = false;
  bool is_off_known_ = false;
  Scalar off_ = 0;  // of passes_by_residual(): how far the velocity may be off, in the metric of G
};

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL

#include "native/active_set/velocity_test_rounding.h"
