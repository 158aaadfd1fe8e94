#pragma once

#include "native/contact_lemke/contacts.h"
#include "native/contact_lemke/kernel.h"
#include "native/contact_lemke/polish.h"
#include "native/contact_lemke/response.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// Lemke's path through the bases of a contact problem.
///
/// A contact that presses has friction impulses on a simplex of size mu f_N, spanned by its directions and the zero
/// vector (see Contacts). One of the basic ones, the contact's base t, is eliminated by f_t = mu f_N - (the others),
/// and with it lambda = -d_t'u and the cone row. What is left are unknowns with the columns
///
///     normal:     a = N_i + mu d_t   b = N_i            direction s:   a = b = d_s - d_t
///
/// so that the kernel B'G*A never exceeds rank(G) + 1 rows, the last for the artificial variable z0. The velocities of
/// the rows of the kernel are zero; all other velocities follow from u = v + G* A x.
template <class Scalar>
class Path {
 public:
  /// Takes all memory that load() needs; touches hardly any of it.
  void reserve(const contact_lemke::Input& input) {
    contacts_.reserve(input);
    response_.reserve(input);
    kernel_.reserve(contacts_.ngc(), most_rows());
    polish_.reserve(contacts_.ngc());
    slot_at_.resize(contacts_.nc());
    place_slots();
    Buffer<Scalar>* const by_slot[] = {&value_, &rate_, &allowed_};
    for (Buffer<Scalar>* buffer : by_slot) buffer->resize(slots_);
    Buffer<Scalar>* const by_coordinate[] = {&u_,    &du_, &entering_response_, &column_, &row_, &basis_velocity_,
                                             &drift_};
    for (Buffer<Scalar>* buffer : by_coordinate) buffer->resize(contacts_.padded_ngc());
    Buffer<Scalar>* const by_row[] = {&x_, &dx_, &residual_, &coefficients_};
    for (Buffer<Scalar>* buffer : by_row) buffer->resize(kernel_.stride());
    Buffer<Scalar>* const by_contact[] = {&base_value_, &base_rate_, &impulse_norm_, &cone_cover_};
    for (Buffer<Scalar>* buffer : by_contact) buffer->resize(contacts_.nc());
    covers_.resize(contacts_.padded_nc());
    slip_.resize(2 * contacts_.most_padded_half());
    alive_.resize(contacts_.nc());
    Buffer<Count>* const counts[] = {&base_, &living_, &support_};
    for (Buffer<Count>* buffer : counts) buffer->resize(contacts_.nc());
  }

  void load(const contact_lemke::Input& input) {
    reserve(input);
    contacts_.load(input);
    response_.load(input);
    kernel_.load(contacts_.ngc(), most_rows());
    fill_with_zeros(slots_, value_, rate_, allowed_);
    fill_with_zeros(contacts_.padded_ngc(), u_, du_, entering_response_, column_, row_);
    fill_with_zeros(kernel_.stride(), x_, dx_, residual_, coefficients_);
    alive_.fill(contacts_.nc(), false);
    has_basis_ = false;
    polish_.load(contacts_.ngc());
    slip_.fill(2 * contacts_.most_padded_half(), Scalar(0));
  }

  void set_velocity(const double* v) { contacts_.set_velocity(v); }

  contact_lemke::Outcome solve(const contact_lemke::Rules& rules, double* z) {
    rules_ = rules;
    outcome_ = {};
    outcome_.ending = rules.resume ? resume(z) : follow(z);
    if (outcome_.ending == contact_lemke::Ending::kBreakdown) kernel_.wipe();
    has_basis_ = outcome_.ending == contact_lemke::Ending::kSolved && !rules_.classic;
    if (has_basis_) copy(basis_velocity_.data(), contacts_.velocity(), contacts_.padded_ngc());
    return outcome_;
  }

  /// The velocity of the last basis by Polish, and its impulses anew. False, and z as it was, where G is singular or
  /// the basis' columns are dependent.
  /// @pre solve() ended in kSolved
  bool polish(double* velocity, double* z);

  /// Whether the data prove that the problem has a solution, see path_proof.h. @pre solve() ended in kSolved
  bool proves_solvable();

  Contacts<Scalar>& contacts() { return contacts_; }
  Response<Scalar>& response() { return response_; }

 private:
  using P = Packed<Scalar>;
  using Pack = typename P::Pack;
  using Ending = contact_lemke::Ending;

  struct Entering {
    bool is_velocity = false;  ///< a velocity of the kernel's rows, else an impulse
    Label label;
  };

  enum class Kind { kNone, kColumn, kBase, kVelocity, kBroken };
  struct Leaving {
    Kind kind = Kind::kNone;
    Count column = -1;  ///< kColumn
    Label label;        ///< kBase: the contact; kVelocity: whose
  };

  // --- candidates of the ratio test, all in m/s: velocities as they are, impulses times |c| |N| ---

  /// Of the kernel, with room for one more.
  Count most_rows() const {
    Count rows = 0;
    for (Count c = 0; c < contacts_.nc(); ++c) rows += 1 + (contacts_.has_friction(c) ? contacts_.edges(c) : 0);
    return (rows < contacts_.ngc() ? rows : contacts_.ngc()) + 2;
  }

  /// normals | kernel columns | per contact: first half of the directions, second half, {zero direction, base}
  void place_slots() {
    column_slots_ = contacts_.padded_nc();
    slots_ = column_slots_ + kernel_.stride();
    for (Count c = 0; c < contacts_.nc(); ++c) {
      slot_at_[c] = slots_;
      if (contacts_.has_friction(c)) slots_ += slots_of(c);
    }
  }
  Count slots_of(Count contact) const { return 2 * contacts_.padded_half(contact) + P::padded(2); }

  Count slot(Label label) const {
    if (label.is_normal()) return label.contact;
    const Count half = contacts_.half(label.contact);
    const Count width = contacts_.padded_half(label.contact);
    const Count at = slot_at_[label.contact];
    if (label.direction == 2 * half) return at + 2 * width;
    return label.direction < half ? at + label.direction : at + width + label.direction - half;
  }
  Count base_slot(Count contact) const { return slot_at_[contact] + 2 * contacts_.padded_half(contact) + 1; }

  // --- the path ---

  Ending follow(double* z) {
    if (expired()) return Ending::kTimeLimit;
    begin();
    if (!choose_first(last_)) return Ending::kSolved;
    return walk(z);
  }

  /// From an almost complementary basis, with last_ to enter, to the end of the path.
  Ending walk(double* z) {
    Entering& entering = last_;
    for (;;) {
      if (rules_.reinvert && !invert()) return Ending::kBreakdown;
      if (!compute_values()) return Ending::kBreakdown;
      const Scalar z0 = x_[artificial_] * kernel_.norm(artificial_);
      if (!(z0 > static_cast<Scalar>(rules_.tie_tolerance) * value_scale_)) return finish(z);
      if (outcome_.pivots >= rules_.max_pivots) return Ending::kPivotLimit;
      if (outcome_.pivots % 16 == 15 && expired()) return Ending::kTimeLimit;
      if (!entering.is_velocity && entering.label.is_normal() && !rules_.classic) press(entering.label.contact);
      compute_rates(entering);
      compute_candidates(entering);
      const Leaving leaving = choose_leaving();
      if (leaving.kind == Kind::kBroken) return Ending::kBreakdown;
      if (leaving.kind == Kind::kNone) return Ending::kRay;
      ++outcome_.pivots;
      const bool last = leaving.kind == Kind::kColumn && leaving.column == artificial_;
      if (!exchange(entering, leaving)) return Ending::kBreakdown;
      if (last) return finish(z);
    }
  }

  // --- from the last basis: path_continuation.h ---

  Ending resume(double* z);
  bool release_artificial();
  void turn_to_drift();
  void compute_values_before_drift();
  bool turn_friction();
  bool is_friction_of(Count contact, Count column) const;
  bool asks_for_turning(Count contact) const;
  bool leave_unused_share_as_base(Count contact, const Entering& entering);
  void turn(Count j);
  void begin_where_friction_has_turned();
  void compute_rates_of_drift();
  void enter_artificial_backwards();

  // --- the start ---

  bool expired() const { return rules_.clock_s != nullptr && !(rules_.clock_s() < rules_.deadline_s); }

  void begin() {
    kernel_.clear();
    resumed_ = false;
    living_count_ = 0;
    for (Count c = 0; c < contacts_.nc(); ++c) alive_[c] = false;
    for (Count c = 0; c < contacts_.padded_nc(); ++c) {
      allowed_[c] = c < contacts_.nc() ? Scalar(1) : Scalar(0);
      covers_[c] = c < contacts_.nc() ? cover_of_normal(c) : Scalar(0);
    }
    speed_scale_ = contacts_.reach() * contacts_.speed();
    copy(u_.data(), contacts_.velocity(), contacts_.padded_ngc());
    artificial_ = -1;
    if (rules_.classic) {
      for (Count c = 0; c < contacts_.nc(); ++c) {
        if (contacts_.has_friction(c)) bring_alive(c, contacts_.edges(c));
      }
    }
  }

  /// Between 1 and 2 and different for different k: what lies in general position has no ties.
  static Scalar spread(Count k) {
    const double golden = 0.6180339887498949;
    const double turns = golden * static_cast<double>(k + 1);
    return static_cast<Scalar>(1 + (turns - static_cast<double>(static_cast<Count>(turns))));
  }

  Scalar cover_of_normal(Count contact) const {
    if (rules_.classic) return spread(contact);
    return rules_.variant > 0 ? spread(contact + (rules_.variant - 1) * contacts_.nc()) : Scalar(1);
  }
  Scalar cover_of_directions(Count contact) const {
    return rules_.classic ? spread(contact + contacts_.nc()) : Scalar(0);
  }
  /// Of the cone row, an impulse: what brings as much velocity as the others.
  Scalar cover_of_cone(Count contact) const { return rules_.classic ? cone_cover_[contact] : Scalar(0); }

  /// Cover of the velocity (d_s - d_base)'u, where the zero direction stands for lambda, which is not covered.
  Scalar cover_of(Label label) const {
    if (label.is_normal()) return covers_[label.contact];
    const Count zero = contacts_.edges(label.contact);
    const Scalar directions = cover_of_directions(label.contact);
    const Scalar own = label.direction == zero ? Scalar(0) : directions;
    const Scalar base = base_[label.contact] == zero ? Scalar(0) : directions;
    return own - base;
  }

  /// z0 enters for the velocity that needs it most. False when z = 0 solves the problem.
  bool choose_first(Entering& entering) {
    x_[0] = 0;
    compute_normal_velocities<1>();
    Label worst;
    Scalar most = 0;
    for (Count c = 0; c < contacts_.nc(); ++c) offer(Label{c, kNormal}, value_[c], most, worst);
    for (Count k = 0; k < living_count_; ++k) {
      const Count c = living_[k];
      contacts_.slip(c, u_.data(), slip_.data());
      const Count half = contacts_.half(c);
      for (Count t = 0; t < half; ++t) {
        offer(Label{c, t}, slip_[t], most, worst);
        offer(Label{c, t + half}, -slip_[t], most, worst);
      }
    }
    if (!(most > 0)) return false;
    entering = {false, worst};
    start_kernel(worst);
    return true;
  }

  void offer(Label label, Scalar velocity, Scalar& most, Label& worst) const {
    const Scalar need = -velocity / cover_of(label);
    if (need > most) {
      most = need;
      worst = label;
    }
  }

  void start_kernel(Label row) {
    load_row(row);
    for (Count i = 0; i < contacts_.padded_ngc(); ++i) column_[i] = 0;
    kernel_.put_row(0, row, row_.data(), cover_of(row),
                    -dot(row_.data(), contacts_.velocity(), contacts_.padded_ngc()));
    kernel_.put_column(0, Label{}, column_.data(), Scalar(1));
    kernel_.start(Scalar(1) / cover_of(row));
    artificial_ = 0;
    allowed_[slot(row)] = 0;
  }

  // --- vectors of a label ---

  /// b of a velocity
  void load_row(Label label) {
    if (label.is_normal()) {
      contacts_.get_normal(label.contact, row_.data());
      return;
    }
    load_difference(label, row_.data());
  }
  /// a of an impulse
  void load_column(Label label) {
    if (!label.is_normal()) return load_difference(label, column_.data());
    contacts_.get_normal(label.contact, column_.data());
    if (alive_[label.contact]) {
      contacts_.add_direction(label.contact, base_[label.contact], contacts_.mu(label.contact), column_.data());
    }
  }
  void load_difference(Label label, Scalar* to) {
    for (Count i = 0; i < contacts_.padded_ngc(); ++i) to[i] = 0;
    contacts_.add_direction(label.contact, label.direction, Scalar(1), to);
    contacts_.add_direction(label.contact, base_[label.contact], Scalar(-1), to);
  }
  Scalar norm_of(const Scalar* response) const {
    return contacts_.reach() * square_root(dot(response, response, contacts_.padded_ngc()));
  }

  // --- friction comes and goes ---

  /// A contact begins to press: its friction starts in the direction against its slip.
  void press(Count contact) {
    if (!contacts_.has_friction(contact) || alive_[contact]) return;
    contacts_.slip(contact, u_.data(), slip_.data());
    const Count half = contacts_.half(contact);
    Count base = 2 * half;
    Scalar largest = 0;
    for (Count t = 0; t < half; ++t) {
      if (magnitude(slip_[t]) > largest) {
        largest = magnitude(slip_[t]);
        base = slip_[t] < 0 ? t : t + half;
      }
    }
    bring_alive(contact, base);
  }

  void bring_alive(Count contact, Count base) {
    alive_[contact] = true;
    living_[living_count_++] = contact;
    base_[contact] = base;
    support_[contact] = 0;
    const Count width = contacts_.padded_half(contact);
    const Count half = contacts_.half(contact);
    Scalar* const allowed = allowed_.data() + slot_at_[contact];
    for (Count t = 0; t < slots_of(contact); ++t) allowed[t] = 0;
    for (Count t = 0; t < half; ++t) allowed[t] = allowed[width + t] = 1;
    allowed[2 * width] = 1;
    allowed_[slot(Label{contact, base})] = 0;
    if (rules_.classic) {
      contacts_.get_normal(contact, column_.data());
      response_.apply(column_.data(), row_.data());
      impulse_norm_[contact] = norm_of(row_.data());
      cone_cover_[contact] = impulse_norm_[contact] > 0 ? Scalar(1) / impulse_norm_[contact] : Scalar(1);
    }
  }

  void let_die(Count contact) {
    alive_[contact] = false;
    Count k = 0;
    while (living_[k] != contact) ++k;
    living_[k] = living_[--living_count_];
  }

  // --- values and rates: path_values.h ---

  bool compute_values();
  void refine_until_small(Scalar& missed);
  void compute_values_once();
  void respond_to_values();
  void measure_value_scale();
  bool invert_and_recompute(Scalar& missed);
  Scalar lost_residual() const { return static_cast<Scalar>(kLostRoundings * kUnitRoundoff<Scalar>) * value_scale_; }
  Scalar residual_tolerance() const { return static_cast<Scalar>(rules_.residual_tolerance) * speed_scale_; }
  Scalar largest_residual();
  Scalar refine();
  void compute_rates(const Entering& entering);
  void solve_for_rates();
  /// Kernels of more rows may be so ill-conditioned that their inverse alone gives directions too noisy to tell a rate
  /// of zero, as dependent contacts have it, from others.
  bool large() const { return kernel_.order() > kLargeOrder; }
  void refine_large_rates(Count row);
  Scalar measure_rates(Count row);
  void refine_rates();
  template <Count kSides>
  void compute_normal_velocities();
  Scalar artificial_value() const { return artificial_ >= 0 ? x_[artificial_] : Scalar(0); }
  Scalar artificial_rate() const { return artificial_ >= 0 ? dx_[artificial_] : Scalar(0); }
  void compute_candidates(const Entering& entering);
  void compute_column_candidates();
  void compute_base_values(const Entering& entering);
  Scalar simplex_weight(Label label) const { return label.is_normal() ? contacts_.mu(label.contact) : Scalar(-1); }
  void compute_contact_candidates(Count contact, Scalar z0, Scalar dz0, const Entering& entering);
  /// Where slip ends, lambda and the slip in the opposite direction reach zero together. As a candidate in larger units
  /// lambda leaves first, so that friction unused stays unused instead of being spent on opposite directions.
  static constexpr double kStickingFirst = 4;
  static bool enters_friction_of(const Entering& entering, Count contact);

  // --- ratio test: path_ratio_test.h ---

  template <class Visit>
  void for_each_segment(Visit visit) const;
  /// Column of z0 where it is no basic variable and has come to its end.
  static constexpr Count kPastEnd = -2;
  Leaving choose_leaving() const;
  Scalar least_ratio(Scalar least_rate, Scalar slack) const;
  static Scalar lane_min(Pack pack);
  Count fastest_of_tied(Scalar least_rate, Scalar theta) const;
  Leaving decode(Count slot) const;

  // --- exchanges: path_exchanges.h ---

  bool exchange(Entering& entering, Leaving leaving);
  void count_support(Label label, Count change);
  void drop_column(const Entering& entering, Count column);
  bool bring_row(Entering& entering, Label leaving);
  Count change_base(Count contact, const Entering& entering);
  void make_base(Count contact, Count place, const Entering& entering);
  Count largest_friction_column(Count contact) const;
  void move_rows(Count contact, Count row);
  void move_columns(Count contact, Count place, const Entering& entering);
  bool replace_base_by_entering(Entering& entering);
  bool has_friction_labels(Count contact, const Entering& entering) const;
  bool open_sticking(Entering& entering, Count contact);
  bool rebuild();
  void load_any_column(Label label);
  bool invert();

  // --- ends: path_ends.h ---

  static constexpr Count kLastRefinements = 1;
  static constexpr double kRoundingsAtEnd = 64;

  Ending finish(double* z);
  double missed_at_end();
  bool round_impulses(Scalar* rounded);
  void write_impulses(const Scalar* impulses, double* z) const;
  void write_friction(Label label, Scalar value, double* z) const;

  // --- the proof: path_proof.h ---

  struct Doubt;
  bool is_complementary() const;
  void renew_kernel();
  /// What a unit of impulse j causes.
  Scalar speed_of(Count j) const { return kernel_.norm(j) / contacts_.reach(); }
  bool bound_values(Doubt& doubt);
  bool bound_inverse(Doubt& doubt);
  bool is_positive(const Doubt& doubt);
  bool separates(const Doubt& doubt);
  bool slips_away(Count contact, const Doubt& doubt);
  bool is_clear(Label label, Scalar velocity, const Doubt& doubt);
  Scalar bound_velocity(Label label, const Doubt& doubt);
  void express_by_rows(Label label);
  bool depends_on_rows(Count contact);
  bool is_sum_of_rows(Count contact, Count times) const;

  contact_lemke::Rules rules_;
  contact_lemke::Outcome outcome_;
  Contacts<Scalar> contacts_;
  Response<Scalar> response_;
  Kernel<Scalar> kernel_;
  Polish<Scalar> polish_;
  Entering last_;           ///< what enters next
  Count artificial_ = -1;   ///< column of z0
  bool has_basis_ = false;  ///< that of a solve, at basis_velocity_
  bool resumed_ = false;    ///< z0 acts through drift_, not through a covering vector

  Buffer<Scalar> x_, dx_, residual_, coefficients_;           ///< per column or row of the kernel
  Buffer<Scalar> u_, du_, entering_response_, column_, row_;  ///< per generalized coordinate
  Buffer<Scalar> basis_velocity_, drift_;
  static constexpr double kWorthRefining = 1e-3;  ///< residual relative to the scale beyond which refining is slow
  static constexpr double kLostRoundings = 10;    ///< residual after refinement that asks for inversion
  static constexpr Count kLargeOrder = 32;        ///< no kernel of the paper's experiments 1 to 6 is as large
  static constexpr Count kRateRefinements = 3;
  static constexpr double kSafeNoises = 100;  ///< a rate of less than so many times the measured noise is none
  bool refines_rates_ = false;
  Scalar entering_norm_ = 0, rate_noise_ = 0;
  Scalar speed_scale_ = 0, value_scale_ = 0, rate_scale_ = 0;

  Buffer<bool> alive_;
  Buffer<Count> living_, base_, support_;  ///< support: basic friction impulses besides the base
  Count living_count_ = 0;
  Buffer<Scalar> base_value_, base_rate_, impulse_norm_, cone_cover_, covers_, slip_;

  Count column_slots_ = 0, slots_ = 0;
  Buffer<Count> slot_at_;
  Buffer<Scalar> value_, rate_, allowed_;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL

#include "native/contact_lemke/path_continuation.h"
#include "native/contact_lemke/path_ends.h"
#include "native/contact_lemke/path_exchanges.h"
#include "native/contact_lemke/path_proof.h"
#include "native/contact_lemke/path_ratio_test.h"
#include "native/contact_lemke/path_values.h"
