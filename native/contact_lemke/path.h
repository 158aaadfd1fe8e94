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
    has_basis_ = outcome_.ending == contact_lemke::Ending::kSolved && !rules_.classic && !rules_.frictionless;
    if (has_basis_) copy(basis_velocity_.data(), contacts_.velocity(), contacts_.padded_ngc());
    return outcome_;
  }

  /// The velocity of the last basis by Polish, and its impulses anew. False, and z as it was, where G is singular or
  /// the basis' columns are dependent.
  /// @pre solve() ended in kSolved
  bool polish(double* velocity, double* z) {
    if (!response_.full_rank()) return false;
    if (kernel_.order() == 0) {
      for (Count i = 0; i < contacts_.ngc(); ++i) velocity[i] = static_cast<double>(contacts_.velocity()[i]);
      return true;
    }
    polish_.clear();
    for (Count r = 0; r < kernel_.order(); ++r) {
      if (artificial_ >= 0 && kernel_.row_label(r) == last_.label) continue;  // z0's row, zero by itself
      Scalar* const to = polish_.next_row();
      if (to == nullptr) return false;
      load_row(kernel_.row_label(r));
      response_.whiten(row_.data(), to);
    }
    for (Count j = 0; j < kernel_.order(); ++j) {
      if (j == artificial_) continue;
      Scalar* const to = polish_.next_column();
      if (to == nullptr) return false;
      load_column(kernel_.column_label(j));
      response_.whiten(column_.data(), to);
    }
    if (!polish_.run(contacts_, response_, u_.data())) return false;
    for (Count i = 0; i < contacts_.ngc(); ++i) velocity[i] = static_cast<double>(u_[i]);
    Count column = 0;
    for (Count j = 0; j < kernel_.order(); ++j) x_[j] = j == artificial_ ? Scalar(0) : polish_.impulse(column++);
    write_impulses(z);
    return true;
  }

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
      if (leaving.kind == Kind::kNone) {
        write_ray(entering, z);
        return Ending::kRay;
      }
      ++outcome_.pivots;
      const bool last = leaving.kind == Kind::kColumn && leaving.column == artificial_;
      if (!exchange(entering, leaving)) return Ending::kBreakdown;
      if (last) return finish(z);
    }
  }

  // --- from the last basis ---

  /// The basis of the last solve, for v_b, is followed along v = v_now + z0 (v_b - v_now) from z0 = 1, where it is
  /// complementary and feasible, to z0 = 0: Lemke's path with J'(v_b - v_now) as covering vector. No pivot is needed
  /// where the basis stays feasible; else about as many as contacts change. Nothing is proven of its end.
  Ending resume(double* z) {
    if (expired()) return Ending::kTimeLimit;
    if (!has_basis_ || !release_artificial()) return Ending::kBreakdown;
    turn_to_drift();
    compute_values_before_drift();
    const Entering time{false, Label{}};
    compute_rates_of_drift();
    compute_candidates(time);
    const Leaving leaving = choose_leaving();
    if (leaving.kind == Kind::kBroken) return Ending::kBreakdown;
    if (leaving.kind == Kind::kNone || leaving.column == kPastEnd) return finish(z);
    if (outcome_.pivots >= rules_.max_pivots) return Ending::kPivotLimit;
    ++outcome_.pivots;
    enter_artificial_backwards();
    last_ = time;
    if (!exchange(last_, leaving)) return Ending::kBreakdown;
    artificial_ = kernel_.find_column(Label{});
    return walk(z);
  }

  /// A path that ended because z0 was zero may have left it in the basis: what was to enter takes its place.
  bool release_artificial() {
    if (artificial_ < 0) return true;
    if (!last_.is_velocity && last_.label.is_normal()) press(last_.label.contact);
    compute_rates(last_);
    if (!(magnitude(dx_[artificial_]) > 0)) return false;
    const Count column = artificial_;
    return exchange(last_, {Kind::kColumn, column, Label{}}) && artificial_ < 0;
  }

  /// Nothing is covered: z0 acts through the column v_b - v_now alone.
  void turn_to_drift() {
    resumed_ = true;
    const Scalar* const velocity = contacts_.velocity();
    for (Count i = 0; i < contacts_.padded_ngc(); ++i) drift_[i] = basis_velocity_[i] - velocity[i];
    for (Count c = 0; c < contacts_.padded_nc(); ++c) covers_[c] = 0;
    kernel_.measure(velocity, residual_.data());
    for (Count r = 0; r < kernel_.order(); ++r) {
      kernel_.set_cover(r, Scalar(0));
      kernel_.set_target(r, -residual_[r]);
    }
    const Scalar before = square_root(dot(basis_velocity_.data(), basis_velocity_.data(), contacts_.padded_ngc()));
    speed_scale_ = contacts_.reach() * (before > contacts_.speed() ? before : contacts_.speed());
  }

  /// x and u at z0 = 1, refined once: u = v_b + G* A x.
  void compute_values_before_drift() {
    for (Count j = 0; j < kernel_.order(); ++j) x_[j] = 0;
    for (Count pass = 0; pass < 2; ++pass) {
      respond_to_values();
      add_multiple(u_.data(), Scalar(1), drift_.data(), contacts_.padded_ngc());
      kernel_.measure(u_.data(), residual_.data());
      kernel_.solve(residual_.data(), coefficients_.data());
      for (Count j = 0; j < kernel_.order(); ++j) x_[j] -= coefficients_[j];
    }
    respond_to_values();
    add_multiple(u_.data(), Scalar(1), drift_.data(), contacts_.padded_ngc());
  }

  /// Of 1 - z0, which grows to 1.
  void compute_rates_of_drift() {
    copy(entering_response_.data(), drift_.data(), contacts_.padded_ngc());
    scale(entering_response_.data(), Scalar(-1), contacts_.padded_ngc());
    entering_norm_ = norm_of(drift_.data());
    rate_noise_ = 0;
    solve_for_rates();
  }

  /// The path goes on in terms of z0 itself: all rates change their signs.
  void enter_artificial_backwards() {
    copy(entering_response_.data(), drift_.data(), contacts_.padded_ngc());
    scale(dx_.data(), Scalar(-1), kernel_.order());
    for (Count k = 0; k < living_count_; ++k) base_rate_[living_[k]] = -base_rate_[living_[k]];
  }

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
        if (with_friction(c)) bring_alive(c, contacts_.edges(c));
      }
    }
  }

  bool with_friction(Count contact) const { return !rules_.frictionless && contacts_.has_friction(contact); }

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
    if (!with_friction(contact) || alive_[contact]) return;
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

  // --- values and rates ---

  /// x, u and the scale of rounding in them. The rows of the kernel should have velocity zero: where they miss it by
  /// more than rounding the inverse has lost accuracy, and x is refined, or the kernel inverted afresh.
  bool compute_values() {
    compute_values_once();
    Scalar missed = largest_residual();
    refines_rates_ = missed > residual_tolerance();
    if (missed > static_cast<Scalar>(kWorthRefining) * value_scale_ && !invert_and_recompute(missed)) return false;
    refine_until_small(missed);
    if (rules_.reinvert || !(missed > lost_residual())) return true;
    if (!invert_and_recompute(missed)) return false;
    refine_until_small(missed);
    return true;
  }

  void refine_until_small(Scalar& missed) {
    for (Count k = 0; k < rules_.refinements && missed > residual_tolerance(); ++k) {
      const Scalar before = missed;
      missed = refine();
      if (!(missed <= before / 2)) return;
    }
  }

  void compute_values_once() {
    kernel_.solve_target(x_.data());
    respond_to_values();
  }

  void respond_to_values() {
    kernel_.respond(x_.data(), u_.data());
    add_multiple(u_.data(), Scalar(1), contacts_.velocity(), contacts_.padded_ngc());
    value_scale_ = speed_scale_;
    for (Count j = 0; j < kernel_.order(); ++j) {
      const Scalar value = magnitude(x_[j]) * kernel_.norm(j);
      if (j != artificial_ && value > value_scale_) value_scale_ = value;
    }
  }

  bool invert_and_recompute(Scalar& missed) {
    if (!invert()) return false;
    compute_values_once();
    missed = largest_residual();
    return true;
  }

  Scalar lost_residual() const { return static_cast<Scalar>(kLostRoundings * kUnitRoundoff<Scalar>) * value_scale_; }
  Scalar residual_tolerance() const { return static_cast<Scalar>(rules_.residual_tolerance) * speed_scale_; }

  /// Of the kernel's rows; fills residual_.
  Scalar largest_residual() {
    kernel_.measure(u_.data(), residual_.data());
    const Scalar z0 = artificial_value();
    Scalar largest = 0;
    for (Count r = 0; r < kernel_.order(); ++r) {
      residual_[r] += kernel_.cover(r) * z0;
      largest = magnitude(residual_[r]) > largest ? magnitude(residual_[r]) : largest;
    }
    return largest;
  }

  /// One step of iterative refinement from residual_. @returns the largest residual after it.
  Scalar refine() {
    kernel_.solve(residual_.data(), coefficients_.data());
    for (Count j = 0; j < kernel_.order(); ++j) x_[j] -= coefficients_[j];
    respond_to_values();
    return largest_residual();
  }

  void compute_rates(const Entering& entering) {
    const Count order = kernel_.order();
    rate_noise_ = 0;
    if (entering.is_velocity) {
      const Count row = kernel_.find_row(entering.label);
      copy(dx_.data(), kernel_.inverse_column(row), order);
      kernel_.respond(dx_.data(), du_.data());
      entering_norm_ = 1;
      if (large()) refine_large_rates(row);
    } else {
      load_column(entering.label);
      response_.apply(column_.data(), entering_response_.data());
      entering_norm_ = norm_of(entering_response_.data());
      solve_for_rates();
    }
  }

  /// dx and du of an unknown that enters with entering_response_.
  void solve_for_rates() {
    kernel_.measure(entering_response_.data(), residual_.data());
    kernel_.solve(residual_.data(), dx_.data());
    scale(dx_.data(), Scalar(-1), kernel_.order());
    if (refines_rates_) refine_rates();
    kernel_.respond(dx_.data(), du_.data());
    add_multiple(du_.data(), Scalar(1), entering_response_.data(), contacts_.padded_ngc());
    if (large()) refine_large_rates(-1);
  }

  /// Kernels of more rows may be so ill-conditioned that their inverse alone gives directions too noisy to tell a rate
  /// of zero, as dependent contacts have it, from others.
  bool large() const { return kernel_.order() > kLargeOrder; }

  /// Refines the rates of a large kernel while that helps, and keeps what the velocities of its rows then miss: of
  /// velocities that depend on them no rate is known any better. `row`: that of the entering velocity, or -1.
  void refine_large_rates(Count row) {
    rate_noise_ = measure_rates(row);
    for (Count k = 0; k < kRateRefinements; ++k) {
      kernel_.solve(residual_.data(), coefficients_.data());
      for (Count j = 0; j < kernel_.order(); ++j) dx_[j] -= coefficients_[j];
      kernel_.respond(dx_.data(), du_.data());
      if (row < 0) add_multiple(du_.data(), Scalar(1), entering_response_.data(), contacts_.padded_ngc());
      const Scalar before = rate_noise_;
      rate_noise_ = measure_rates(row);
      if (!(rate_noise_ <= before / 2)) return;
    }
  }

  /// Fills residual_ with what the rates of the kernel's rows miss. @returns the largest
  Scalar measure_rates(Count row) {
    kernel_.measure(du_.data(), residual_.data());
    Scalar largest = 0;
    for (Count r = 0; r < kernel_.order(); ++r) {
      residual_[r] += kernel_.cover(r) * artificial_rate();
      if (r == row) residual_[r] -= Scalar(1);
      largest = magnitude(residual_[r]) > largest ? magnitude(residual_[r]) : largest;
    }
    return largest;
  }

  void refine_rates() {
    kernel_.respond(dx_.data(), du_.data());
    add_multiple(du_.data(), Scalar(1), entering_response_.data(), contacts_.padded_ngc());
    kernel_.measure(du_.data(), residual_.data());
    for (Count r = 0; r < kernel_.order(); ++r) residual_[r] += kernel_.cover(r) * artificial_rate();
    kernel_.solve(residual_.data(), coefficients_.data());
    for (Count j = 0; j < kernel_.order(); ++j) dx_[j] -= coefficients_[j];
  }

  template <Count kSides>
  void compute_normal_velocities() {
    const Count length = contacts_.padded_nc();
    if constexpr (kSides == 1) {
      combine(contacts_.normals(), length, contacts_.ngc(), u_.data(), value_.data(), length);
    } else {
      combine(contacts_.normals(), length, contacts_.ngc(),
              Combination<Scalar, 2>{{u_.data(), du_.data()}, {value_.data(), rate_.data()}}, length);
    }
  }

  Scalar artificial_value() const { return artificial_ >= 0 ? x_[artificial_] : Scalar(0); }
  Scalar artificial_rate() const { return artificial_ >= 0 ? dx_[artificial_] : Scalar(0); }

  void compute_candidates(const Entering& entering) {
    compute_normal_velocities<2>();
    const Scalar z0 = artificial_value();
    const Scalar dz0 = artificial_rate();
    for (Count i = 0; i < contacts_.padded_nc(); i += P::kWidth) {
      const Pack cover = P::load(covers_.data() + i);
      P::store(value_.data() + i, P::load(value_.data() + i) + cover * z0);
      P::store(rate_.data() + i, (P::load(rate_.data() + i) + cover * dz0) * P::load(allowed_.data() + i));
    }
    compute_column_candidates();
    compute_base_values(entering);
    for (Count k = 0; k < living_count_; ++k) compute_contact_candidates(living_[k], z0, dz0, entering);
  }

  void compute_column_candidates() {
    const Count order = kernel_.order();
    for (Count j = order; j < P::padded(order); ++j) x_[j] = dx_[j] = 0;
    const Scalar* const norms = kernel_.norms();
    rate_scale_ = entering_norm_;
    for (Count j = 0; j < P::padded(order); ++j) {
      const Scalar value = x_[j] * norms[j];
      const Scalar rate = dx_[j] * norms[j];
      value_[column_slots_ + j] = value;
      rate_[column_slots_ + j] = rate;
      rate_scale_ = magnitude(rate) > rate_scale_ ? magnitude(rate) : rate_scale_;
    }
  }

  /// f_t = mu f_N + cover z0 - (the contact's other friction impulses)
  void compute_base_values(const Entering& entering) {
    for (Count k = 0; k < living_count_; ++k) {
      const Count c = living_[k];
      const Scalar cover = cover_of_cone(c);
      base_value_[c] = cover * artificial_value();
      base_rate_[c] = cover * artificial_rate();
    }
    for (Count j = 0; j < kernel_.order(); ++j) {
      const Label label = kernel_.column_label(j);
      if (label.contact == kArtificial || !alive_[label.contact]) continue;
      const Scalar weight = simplex_weight(label);
      base_value_[label.contact] += weight * x_[j];
      base_rate_[label.contact] += weight * dx_[j];
      if (label.is_normal()) impulse_norm_[label.contact] = kernel_.norm(j);
    }
    if (!entering.is_velocity && entering.label.contact != kArtificial && alive_[entering.label.contact]) {
      base_rate_[entering.label.contact] += simplex_weight(entering.label);
      if (entering.label.is_normal()) impulse_norm_[entering.label.contact] = entering_norm_;
    }
  }
  Scalar simplex_weight(Label label) const { return label.is_normal() ? contacts_.mu(label.contact) : Scalar(-1); }

  void compute_contact_candidates(Count contact, Scalar z0, Scalar dz0, const Entering& entering) {
    const Count half = contacts_.half(contact);
    const Count width = contacts_.padded_half(contact);
    Scalar* const slip = slip_.data();
    Scalar* const slip_rate = slip + contacts_.most_padded_half();
    combine(contacts_.block(contact), width, contacts_.ngc(),
            Combination<Scalar, 2>{{u_.data(), du_.data()}, {slip, slip_rate}}, width);

    const Count base = base_[contact];
    const bool zero_base = base == 2 * half;
    const Count twin = base < half ? base : base - half;
    const Scalar sign = base < half ? Scalar(1) : Scalar(-1);
    const Scalar cover = cover_of_directions(contact);
    // What is added to +-slip, of the first and second half alike: -d_t'u, or the cover where the base is zero.
    const Scalar shift = zero_base ? cover * z0 : -sign * slip[twin];
    const Scalar shift_rate = zero_base ? cover * dz0 : -sign * slip_rate[twin];

    Scalar* const value = value_.data() + slot_at_[contact];
    Scalar* const rate = rate_.data() + slot_at_[contact];
    const Scalar* const allowed = allowed_.data() + slot_at_[contact];
    for (Count t = 0; t < width; t += P::kWidth) {
      const Pack s = P::load(slip + t);
      const Pack ds = P::load(slip_rate + t);
      P::store(value + t, shift + s);
      P::store(value + width + t, shift - s);
      P::store(rate + t, (shift_rate + ds) * P::load(allowed + t));
      P::store(rate + width + t, (shift_rate - ds) * P::load(allowed + width + t));
    }
    const Scalar preferred = static_cast<Scalar>(kStickingFirst);
    value[2 * width] = preferred * (shift - (zero_base ? Scalar(0) : cover * z0));
    rate[2 * width] = preferred * allowed[2 * width] * (shift_rate - (zero_base ? Scalar(0) : cover * dz0));
    const bool watched = support_[contact] > 0 || enters_friction_of(entering, contact);
    value[2 * width + 1] = base_value_[contact] * impulse_norm_[contact];
    rate[2 * width + 1] = watched ? base_rate_[contact] * impulse_norm_[contact] : Scalar(0);
  }

  /// Where slip ends, lambda and the slip in the opposite direction reach zero together. As a candidate in larger units
  /// lambda leaves first, so that friction unused stays unused instead of being spent on opposite directions.
  static constexpr double kStickingFirst = 4;

  static bool enters_friction_of(const Entering& entering, Count contact) {
    return !entering.is_velocity && entering.label.contact == contact && !entering.label.is_normal();
  }

  // --- ratio test ---

  template <class Visit>
  void for_each_segment(Visit visit) const {
    visit(Count(0), contacts_.padded_nc());
    visit(column_slots_, column_slots_ + P::padded(kernel_.order()));
    for (Count k = 0; k < living_count_; ++k) {
      const Count first = slot_at_[living_[k]];
      visit(first, first + slots_of(living_[k]));
    }
  }

  /// Column of z0 where it is no basic variable and has come to its end.
  static constexpr Count kPastEnd = -2;

  /// Harris's test: the least ratio with values moved up by the tie tolerance; of all that are then not above it the
  /// one with the fastest rate leaves, z0 before all.
  Leaving choose_leaving() const {
    Scalar least_rate = static_cast<Scalar>(rules_.pivot_tolerance) * rate_scale_;
    if (static_cast<Scalar>(kSafeNoises) * rate_noise_ > least_rate) {
      least_rate = static_cast<Scalar>(kSafeNoises) * rate_noise_;
    }
    const Scalar slack = static_cast<Scalar>(rules_.tie_tolerance) * value_scale_;
    Scalar theta = least_ratio(least_rate, slack);
    if (!(theta >= 0)) return {Kind::kBroken, -1, {}};
    if (!(theta < kInfinity<Scalar>)) return {};
    theta *= static_cast<Scalar>(1 + 8 * kUnitRoundoff<Scalar>);  // the least ratio's own row is to stay among the tied
    if (artificial_ < 0) {
      if (theta >= 1) return {Kind::kColumn, kPastEnd, Label{}};
    } else if (dx_[artificial_] < 0 && x_[artificial_] <= theta * -dx_[artificial_]) {
      return {Kind::kColumn, artificial_, Label{}};
    }
    return decode(fastest_of_tied(least_rate, theta));
  }

  Scalar least_ratio(Scalar least_rate, Scalar slack) const {
    const Pack infinity = P::broadcast(kInfinity<Scalar>);
    const Pack zero = Pack{};
    const Pack one = P::broadcast(Scalar(1));
    Pack least = infinity;
    Pack poison = zero;
    for_each_segment([&](Count first, Count last) {
      for (Count i = first; i < last; i += P::kWidth) {
        const Pack fall = -P::load(rate_.data() + i);
        const Pack value = P::load(value_.data() + i);
        const auto candidate = fall > least_rate;
        const Pack ratio = (P::max(value, zero) + slack) / (candidate ? fall : one);
        least = P::min(candidate ? ratio : infinity, least);
        poison += Scalar(0) * fall + Scalar(0) * value;
      }
    });
    if (!(P::sum(poison) == 0)) return -1;
    return lane_min(least);
  }

  static Scalar lane_min(Pack pack) {
    Scalar lanes[static_cast<std::size_t>(P::kWidth)];
    P::store(lanes, pack);
    for (Count i = 1; i < P::kWidth; ++i) lanes[0] = lanes[i] < lanes[0] ? lanes[i] : lanes[0];
    return lanes[0];
  }

  Count fastest_of_tied(Scalar least_rate, Scalar theta) const {
    const Pack zero = Pack{};
    Pack fastest = P::broadcast(least_rate);
    Pack where = P::broadcast(Scalar(-1));
    for_each_segment([&](Count first, Count last) {
      for (Count i = first; i < last; i += P::kWidth) {
        const Pack fall = -P::load(rate_.data() + i);
        const Pack value = P::max(P::load(value_.data() + i), zero);
        const auto better = (value <= theta * fall) & (fall > fastest);
        fastest = better ? fall : fastest;
        where = better ? P::broadcast(static_cast<Scalar>(static_cast<double>(i))) : where;
      }
    });
    Scalar rates[static_cast<std::size_t>(P::kWidth)];
    Scalar places[static_cast<std::size_t>(P::kWidth)];
    P::store(rates, fastest);
    P::store(places, where);
    Count best = -1;
    Scalar best_rate = least_rate;
    for (Count lane = 0; lane < P::kWidth; ++lane) {
      if (places[lane] >= 0 && rates[lane] > best_rate) {
        best_rate = rates[lane];
        best = static_cast<Count>(static_cast<double>(places[lane])) + lane;
      }
    }
    return best;
  }

  Leaving decode(Count slot) const {
    if (slot < 0) return {Kind::kBroken, -1, {}};
    if (slot < contacts_.padded_nc()) return {Kind::kVelocity, -1, Label{slot, kNormal}};
    if (slot < column_slots_ + kernel_.stride()) {
      const Count column = slot - column_slots_;
      return {Kind::kColumn, column, kernel_.column_label(column)};
    }
    Count contact = 0;
    for (Count k = 0; k < living_count_; ++k) {
      const Count first = slot_at_[living_[k]];
      if (slot >= first && slot < first + slots_of(living_[k])) contact = living_[k];
    }
    const Count width = contacts_.padded_half(contact);
    const Count half = contacts_.half(contact);
    const Count place = slot - slot_at_[contact];
    if (place == 2 * width + 1) return {Kind::kBase, -1, Label{contact, base_[contact]}};
    if (place == 2 * width) return {Kind::kVelocity, -1, Label{contact, 2 * half}};
    return {Kind::kVelocity, -1, Label{contact, place < width ? place : place - width + half}};
  }

  // --- exchanges ---

  /// The basis changes; `entering` becomes the complement of what left.
  bool exchange(Entering& entering, Leaving leaving) {
    if (leaving.kind == Kind::kBase) {
      const Count contact = leaving.label.contact;
      if (support_[contact] == 0) return replace_base_by_entering(entering);
      leaving.column = change_base(contact, entering);
      leaving.kind = Kind::kColumn;
    }
    if (leaving.kind == Kind::kVelocity) return bring_row(entering, leaving.label);
    const bool contact_opens = leaving.label.is_normal() && !rules_.classic && alive_[leaving.label.contact];
    if (contact_opens && has_friction_labels(leaving.label.contact, entering)) {
      return open_sticking(entering, leaving.label.contact);
    }
    drop_column(entering, leaving.column);
    if (contact_opens) let_die(leaving.label.contact);
    entering = {true, leaving.label};
    return true;
  }

  void count_support(Label label, Count change) {
    if (label.contact != kArtificial && !label.is_normal()) support_[label.contact] += change;
  }

  void drop_column(const Entering& entering, Count column) {
    count_support(kernel_.column_label(column), -1);
    if (entering.is_velocity) {
      allowed_[slot(entering.label)] = 1;
      kernel_.remove(kernel_.find_row(entering.label), column);
    } else {
      kernel_.replace_column(column, dx_.data());
      kernel_.put_column(column, entering.label, entering_response_.data(), entering_norm_);
      count_support(entering.label, 1);
    }
    artificial_ = kernel_.find_column(Label{});
  }

  bool bring_row(Entering& entering, Label leaving) {
    load_row(leaving);
    const Scalar cover = cover_of(leaving);
    const Scalar target = -dot(row_.data(), contacts_.velocity(), contacts_.padded_ngc());
    allowed_[slot(leaving)] = 0;
    if (entering.is_velocity) {
      const Count r = kernel_.find_row(entering.label);
      if (!kernel_.replace_row(r, row_.data(), cover, artificial_)) return false;
      kernel_.put_row(r, leaving, row_.data(), cover, target);
      allowed_[slot(entering.label)] = 1;
    } else {
      if (kernel_.full()) return false;
      if (!kernel_.append(row_.data(), cover, artificial_, entering_response_.data(), dx_.data())) return false;
      const Count last = kernel_.order();
      kernel_.put_row(last, leaving, row_.data(), cover, target);
      kernel_.put_column(last, entering.label, entering_response_.data(), entering_norm_);
      kernel_.grow();
      count_support(entering.label, 1);
    }
    entering = {false, leaving};
    return true;
  }

  /// Another basic friction impulse of the contact becomes its base, the old base an unknown of the kernel.
  /// @returns the column of the old base.
  Count change_base(Count contact, const Entering& entering) {
    const Count old_base = base_[contact];
    const Count place = largest_friction_column(contact);
    const Label new_base = kernel_.column_label(place);
    const Count row = kernel_.find_row(new_base);
    move_rows(contact, row);
    move_columns(contact, place, entering);
    base_[contact] = new_base.direction;
    kernel_.relabel_row(row, Label{contact, old_base});
    kernel_.relabel_column(place, Label{contact, old_base});
    x_[place] = base_value_[contact];
    dx_[place] = base_rate_[contact];
    return place;
  }

  Count largest_friction_column(Count contact) const {
    Count largest = -1;
    for (Count j = 0; j < kernel_.order(); ++j) {
      const Label label = kernel_.column_label(j);
      if (label.contact != contact || label.is_normal()) continue;
      if (largest < 0 || x_[j] > x_[largest]) largest = j;
    }
    return largest;
  }

  /// d_s - d_t becomes d_s - d_new; the new base's own row that of the old base.
  void move_rows(Count contact, Count row) {
    for (Count r = 0; r < kernel_.order(); ++r) {
      const Label label = kernel_.row_label(r);
      if (r != row && label.contact == contact && !label.is_normal()) kernel_.subtract_row(r, row);
    }
    kernel_.negate_row(row);
  }

  void move_columns(Count contact, Count place, const Entering& entering) {
    const Count order = kernel_.order();
    for (Count j = 0; j < P::padded(order); ++j) coefficients_[j] = 0;
    copy(column_.data(), kernel_.column(place), contacts_.padded_ngc());
    for (Count j = 0; j < order; ++j) {
      const Label label = kernel_.column_label(j);
      if (j == artificial_) {
        coefficients_[j] = cover_of_cone(contact);
      } else if (label.contact == contact) {
        coefficients_[j] = simplex_weight(label);
      } else {
        continue;
      }
      if (j != place) add_multiple(kernel_.column(j), coefficients_[j], column_.data(), contacts_.padded_ngc());
      if (j != artificial_) kernel_.set_norm(j, norm_of(kernel_.column(j)));
    }
    scale(kernel_.column(place), Scalar(-1), contacts_.padded_ngc());
    kernel_.substitute_unknown(place, coefficients_.data());
    if (!entering.is_velocity && entering.label.contact == contact) {
      add_multiple(entering_response_.data(), simplex_weight(entering.label), column_.data(), contacts_.padded_ngc());
      entering_norm_ = norm_of(entering_response_.data());
    }
  }

  /// The only friction impulse of a contact leaves while another of it enters: that becomes the base.
  bool replace_base_by_entering(Entering& entering) {
    const Count contact = entering.label.contact;
    const Count normal = kernel_.find_column(Label{contact, kNormal});
    const Scalar mu = contacts_.mu(contact);
    const Scalar cone = cover_of_cone(contact);
    const Count z0 = cone != 0 ? artificial_ : -1;
    if (!kernel_.add_outer(normal, mu, z0, cone, dx_.data())) return false;
    if (normal >= 0) {
      add_multiple(kernel_.column(normal), mu, entering_response_.data(), contacts_.padded_ngc());
      kernel_.set_norm(normal, norm_of(kernel_.column(normal)));
    }
    if (z0 >= 0) add_multiple(kernel_.column(z0), cone, entering_response_.data(), contacts_.padded_ngc());
    const Count row = kernel_.find_row(entering.label);
    kernel_.negate_row(row);
    const Label old_base{contact, base_[contact]};
    kernel_.relabel_row(row, old_base);
    base_[contact] = entering.label.direction;
    entering = {true, old_base};
    return true;
  }

  bool has_friction_labels(Count contact, const Entering& entering) const {
    if (support_[contact] > 0) return true;
    return entering.label.contact == contact && !entering.label.is_normal();
  }

  /// A contact opens while several of its friction impulses are basic, all zero then: they go with it.
  bool open_sticking(Entering& entering, Count contact) {
    kernel_.begin_labels();
    for (Count r = kernel_.rows_left() - 1; r >= 0; --r) {
      const Label label = kernel_.row_label(r);
      if (label.contact == contact && !label.is_normal()) kernel_.drop_row_label(r);
    }
    for (Count j = kernel_.columns_left() - 1; j >= 0; --j) {
      if (kernel_.column_label(j).contact == contact) kernel_.drop_column_label(j);
    }
    const bool of_contact = entering.label.contact == contact;
    if (!of_contact && entering.is_velocity) {
      for (Count r = 0; r < kernel_.rows_left(); ++r) {
        if (kernel_.row_label(r) == entering.label) kernel_.drop_row_label(r);
      }
      allowed_[slot(entering.label)] = 1;
    }
    if (!of_contact && !entering.is_velocity) {
      kernel_.add_column_label(entering.label);
      count_support(entering.label, 1);
    }
    let_die(contact);
    entering = {true, Label{contact, kNormal}};
    return kernel_.end_labels() && rebuild();
  }

  /// Rows, columns and inverse from the labels.
  bool rebuild() {
    artificial_ = kernel_.find_column(Label{});
    for (Count r = 0; r < kernel_.order(); ++r) {
      const Label label = kernel_.row_label(r);
      load_row(label);
      kernel_.put_row(r, label, row_.data(), cover_of(label),
                      -dot(row_.data(), contacts_.velocity(), contacts_.padded_ngc()));
    }
    for (Count j = 0; j < kernel_.order(); ++j) {
      const Label label = kernel_.column_label(j);
      if (resumed_ && label.contact == kArtificial) {
        kernel_.put_column(j, label, drift_.data(), norm_of(drift_.data()));
        continue;
      }
      load_any_column(label);
      response_.apply(column_.data(), entering_response_.data());
      const Scalar norm = label.contact == kArtificial ? Scalar(1) : norm_of(entering_response_.data());
      kernel_.put_column(j, label, entering_response_.data(), norm);
    }
    return invert();
  }

  void load_any_column(Label label) {
    if (label.contact != kArtificial) return load_column(label);
    for (Count i = 0; i < contacts_.padded_ngc(); ++i) column_[i] = 0;
    if (!rules_.classic) return;
    for (Count k = 0; k < living_count_; ++k) {
      contacts_.add_direction(living_[k], base_[living_[k]], cover_of_cone(living_[k]), column_.data());
    }
  }

  bool invert() {
    ++outcome_.factorizations;
    return kernel_.invert(artificial_);
  }

  // --- ends ---

  static constexpr Count kLastRefinements = 1;

  Ending finish(double* z) {
    if (!compute_values()) return Ending::kBreakdown;
    for (Count k = 0; k < kLastRefinements; ++k) refine();
    Scalar poison = 0;
    for (Count j = 0; j < kernel_.order(); ++j) poison += Scalar(0) * x_[j];
    if (!(poison == 0)) return Ending::kBreakdown;
    write_impulses(z);
    return Ending::kSolved;
  }

  void write_impulses(double* z) {
    for (Count j = 0; j < kernel_.order(); ++j) {
      const Label label = kernel_.column_label(j);
      if (label.contact == kArtificial) continue;
      const Scalar value = x_[j] > 0 ? x_[j] : Scalar(0);
      if (label.is_normal()) z[label.contact] = static_cast<double>(value);
      if (!label.is_normal()) write_friction(label, value, z);
    }
    for (Count k = 0; k < living_count_; ++k) {
      const Count c = living_[k];
      Scalar rest = 0;
      for (Count j = 0; j < kernel_.order(); ++j) {
        const Label label = kernel_.column_label(j);
        if (label.contact == c && x_[j] > 0) rest += simplex_weight(label) * x_[j];
      }
      write_friction(Label{c, base_[c]}, rest > 0 ? rest : Scalar(0), z);
    }
  }

  void write_friction(Label label, Scalar value, double* z) const {
    if (label.direction == contacts_.edges(label.contact)) return;
    z[contacts_.nc() + contacts_.first_direction(label.contact) + label.direction] = static_cast<double>(value);
  }

  void write_ray(const Entering& entering, double* z) const {
    for (Count j = 0; j < kernel_.order(); ++j) {
      const Label label = kernel_.column_label(j);
      if (label.is_normal() && dx_[j] > 0) z[label.contact] = static_cast<double>(dx_[j]);
    }
    if (!entering.is_velocity && entering.label.is_normal()) z[entering.label.contact] = 1;
  }

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
