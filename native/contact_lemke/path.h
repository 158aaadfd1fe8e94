#pragma once

#include "native/contact_lemke/contacts.h"
#include "native/contact_lemke/covering_vector.h"
#include "native/contact_lemke/friction_state.h"
#include "native/contact_lemke/kernel.h"
#include "native/contact_lemke/ratio_test.h"
#include "native/contact_lemke/rounded_shares.h"
#include "native/contact_lemke/visited_bases.h"
#include "native/kernels/response.h"

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
    kernel_.reserve(contacts_, most_rows());
    if constexpr (kRoundsShares) shares_.reserve(coordinates());
    friction_.reserve(contacts_.nc() + 1);
    ratio_test_.reserve();
    Buffer<Scalar>* const by_coordinate[] = {&u_,    &du_, &entering_response_, &column_, &row_, &basis_velocity_,
                                             &drift_};
    for (Buffer<Scalar>* buffer : by_coordinate) buffer->resize(contacts_.extent());
    Buffer<Scalar>* const by_row[] = {&x_, &dx_, &residual_, &coefficients_};
    for (Buffer<Scalar>* buffer : by_row) buffer->resize(kernel_.stride());
    simplex_.resize(contacts_.nc() + 1);
    covering_.reserve();
    slip_.resize(contacts_.most_padded_half());
  }

  void load(const contact_lemke::Input& input) {
    reserve(input);
    contacts_.load(input);
    response_.load(input);
    fill_with_zeros(contacts_.extent(), u_, du_, entering_response_, column_, row_);
    simplex_[contacts_.nc()] = {};
    has_basis_ = false;
    if constexpr (kRoundsShares) shares_.load(coordinates());
  }

  void set_velocity(const double* v) { contacts_.set_velocity(v); }

  contact_lemke::Outcome solve(const contact_lemke::Rules& rules, double* z) {
    rules_ = rules;
    outcome_ = {};
    outcome_.work = kWorkOfShortestPath;
    outcome_.ending = rules.resume ? resume(z) : follow(z);
    has_basis_ = outcome_.ending == contact_lemke::Ending::kSolved && !rules_.classic;
    if (has_basis_) copy(basis_velocity_.data(), contacts_.velocity(), contacts_.extent());
    return outcome_;
  }

  Contacts<Scalar>& contacts() { return contacts_; }
  Response<Scalar>& response() { return response_; }

 private:
  using P = Packed<Scalar>;
  using Pack = typename P::Pack;
  using Ending = contact_lemke::Ending;
  using Kind = LeavingVariable::Kind;
  using Tangents = typename Contacts<Scalar>::Tangents;

  struct Entering {
    bool is_velocity = false;  ///< a velocity of the kernel's rows, else an impulse
    Label label;
  };

  /// Of the kernel, with room for one more.
  Count most_rows() const {
    Count rows = 0;
    for (Count c = 0; c < contacts_.nc(); ++c) rows += 1 + (contacts_.has_friction(c) ? contacts_.edges(c) : 0);
    return (rows < coordinates() ? rows : coordinates()) + 2;
  }
  /// With those of what contacts yield.
  Count coordinates() const { return contacts_.is_soft() ? contacts_.extent() : contacts_.ngc(); }

  // --- the path ---

  /// From z = 0.
  Ending follow(double* z) {
    if (expired()) return Ending::kTimeLimit;
    begin();
    if (!choose_first(entering_)) return Ending::kSolved;
    return walk(z);
  }

  /// From an almost complementary basis, with entering_ to enter, to the end of the path.
  Ending walk(double* z) {
    Entering& entering = entering_;
    for (;;) {
      if (outcome_.work >= rules_.max_work) {
        outcome_.is_out_of_work = true;
        return Ending::kPivotLimit;
      }
      if (rules_.reinvert && !invert()) return Ending::kBreakdown;
      if (!compute_values()) return Ending::kBreakdown;
      const Scalar z0 = x_[artificial_] * kernel_.norm(artificial_);
      if (!(z0 > static_cast<Scalar>(kTieTolerance) * value_scale_)) return finish(z);
      outcome_.cycles = comes_back(entering);
      if (outcome_.cycles || outcome_.pivots >= rules_.max_pivots) return Ending::kPivotLimit;
      if (outcome_.pivots % 16 == 15 && expired()) return Ending::kTimeLimit;
      if (!entering.is_velocity && entering.label.is_normal() && !rules_.classic)
        activate_friction(entering.label.contact);
      compute_rates(entering);
      const LeavingVariable leaving = choose_leaving(compute_candidates(entering));
      if (leaving.kind == Kind::kBroken) return Ending::kBreakdown;
      if (leaving.kind == Kind::kNone) return Ending::kRay;
      ++outcome_.pivots;
      count_pivot(entering);
      const bool last = leaving.kind == Kind::kColumn && leaving.column == artificial_;
      if (!exchange(entering, leaving)) return Ending::kBreakdown;
      if (last) return finish(z);
    }
  }

  /// The work of a pivot that was as easy as most: values, rates and candidates, and the exchange. With the time that
  /// no product takes: of a pivot, and of each candidate.
  void count_pivot(const Entering& entering) {
    constexpr Count kOfPivot = 2000, kOfCandidate = 4;
    const Count order = kernel_.order();
    const Count ngc = contacts_.ngc();
    const Count candidates = contacts_.nc() + ratio_test_.end();
    const Count products = contacts_.length_of_runs() * candidates + 5 * ngc * order + 4 * order * order;
    const Count response = entering.is_velocity ? 0 : response_.work();
    outcome_.work += products + response + kOfCandidate * ratio_test_.end() + kOfPivot;
  }
  static constexpr Count kWorkOfShortestPath = 8000;
  void count_refinement() { outcome_.work += kernel_.order() * (kernel_.order() + 2 * contacts_.ngc()); }

  /// True if the path has met this basis before. Returns false if values were refined on this path, because rounding
  /// may have caused the repetition. Before pivot 64 it looks only when a contact begins to press.
  bool comes_back(const Entering& entering) {
    const bool presses = !entering.is_velocity && entering.label.is_normal();
    is_strained_ = is_strained_ || refines_rates_;
    if (is_strained_ || (!presses && outcome_.pivots < VisitedBases::kMost)) return false;
    return visited_.note(VisitedBases::fingerprint(kernel_, friction_, entering.label, entering.is_velocity));
  }

  // --- from the last basis: path_continuation.h ---

  Ending resume(double* z);
  bool release_artificial();
  void turn_to_drift();
  void compute_values_before_drift();
  bool turn_friction();
  bool is_friction_of(Count contact, Count column) const {
    const Label label = kernel_.column_label(column);
    return label.contact == contact && !label.is_normal();
  }
  bool asks_for_turning(Count contact) const;
  bool leave_unused_share_as_base(Count contact, const Entering& entering);
  void turn(Count j);
  void begin_where_friction_has_turned();
  void compute_rates_of_drift();
  void enter_artificial_backwards();

  // --- the start ---

  bool expired() const { return rules_.clock_s != nullptr && !(rules_.clock_s() < rules_.deadline_s); }

  void begin() {
    begin_walk();
    kernel_.clear();
    resumed_ = false;
    friction_.clear(contacts_.nc() + 1);
    ratio_test_.allow_normals();
    covering_.choose(rules_.classic, rules_.variant);
    speed_scale_ = contacts_.reach() * contacts_.speed();
    if (contacts_.is_soft()) speed_scale_ += contacts_.creep();
    copy(u_.data(), contacts_.velocity(), contacts_.extent());
    artificial_ = -1;
    if (rules_.classic) {
      for (Count c = 0; c < contacts_.nc(); ++c) {
        if (contacts_.has_friction(c)) activate_friction(c, contacts_.edges(c));
      }
    }
  }

  void begin_walk() {
    visited_.clear();
    is_strained_ = false;
  }

  /// z0 enters for the velocity that needs it most. False when z = 0 solves the problem.
  bool choose_first(Entering& entering) {
    x_[0] = 0;
    compute_normal_velocities();
    Label worst;
    Scalar most = 0;
    for (Count c = 0; c < contacts_.nc(); ++c) offer(Label{c, kNormal}, ratio_test_.values()[c], most, worst);
    for (Count k = 0; k < friction_.count(); ++k) {
      const Count c = friction_.contact(k);
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
    const Scalar need = -velocity / covering_.of(label);
    if (need > most) {
      most = need;
      worst = label;
    }
  }

  void start_kernel(Label row) {
    load_row(row);
    for (Count i = 0; i < contacts_.extent(); ++i) column_[i] = 0;
    kernel_.put_row(0, row, row_.data(), covering_.of(row),
                    -dot(row_.data(), contacts_.velocity(), contacts_.extent()));
    kernel_.put_column(0, Label{}, column_.data(), Scalar(1));
    kernel_.start(Scalar(1) / covering_.of(row));
    artificial_ = 0;
    ratio_test_.forbid(row);
  }

  // --- vectors of a label ---

  /// b of a velocity
  void load_row(Label label) {
    if (label.is_normal()) return load_normal(label.contact, row_.data());
    load_difference(label, row_.data());
  }
  /// a of an impulse
  void load_column(Label label) {
    const Count c = label.contact;
    if (!label.is_normal()) return load_difference(label, column_.data());
    if (!friction_.is_active(c)) return load_normal(c, column_.data());
    const double* const base = contacts_.direction(c, friction_.base(c));
    contacts_.get_sum(contacts_.impulse_column(c), contacts_.mu(c), base, column_.data());
    if (!contacts_.is_soft()) return;
    const Tangents along = contacts_.tangents(c, friction_.base(c));
    load_yields(c, Scalar(1), {contacts_.mu(c) * along.first, contacts_.mu(c) * along.second}, column_.data());
  }
  void load_normal(Count contact, Scalar* to) {
    contacts_.get_normal(contact, to);
    if (contacts_.is_soft()) load_yields(contact, Scalar(1), {}, to);
  }
  void load_difference(Label label, Scalar* to) {
    const Count c = label.contact;
    contacts_.get_sum(contacts_.direction(c, label.direction), Scalar(-1), contacts_.direction(c, friction_.base(c)),
                      to);
    if (!contacts_.is_soft()) return;
    const Tangents own = contacts_.tangents(c, label.direction), base = contacts_.tangents(c, friction_.base(c));
    load_yields(c, Scalar(0), {own.first - base.first, own.second - base.second}, to);
  }
  /// The entries of a row or a column behind those of the coordinates.
  void load_yields(Count contact, Scalar normal, Tangents along, Scalar* to) {
    for (Count i = contacts_.padded_ngc(); i < contacts_.extent(); i += P::kWidth) P::store(to + i, Pack{});
    to[contacts_.normal_at(contact)] = normal;
    to[contacts_.tangents_at(contact)] = along.first;
    to[contacts_.tangents_at(contact) + 1] = along.second;
  }
  /// response := the velocities that the impulses a cause, with what contacts yield. Both have extent() entries.
  void respond(const Scalar* a, Scalar* response) {
    response_.apply(a, response);
    contacts_.yield(a, response);
  }
  /// At least the normal velocity that a response brings to any contact.
  Scalar norm_of(const Scalar* response) const { return norm_of(response, contacts_.extent()); }
  Scalar norm_of_column(Count j) const { return norm_of(kernel_.column(j), kernel_.column_length()); }
  Scalar norm_of(const Scalar* response, Count length) const {
    const Count ngc = contacts_.padded_ngc();
    const Scalar moved = contacts_.reach() * square_root(dot(response, response, ngc));
    return length > ngc ? moved + square_root(dot(response + ngc, response + ngc, length - ngc)) : moved;
  }

  // --- friction comes and goes ---

  /// A contact begins to press: its friction starts in the direction against its slip.
  void activate_friction(Count contact) {
    if (!contacts_.has_friction(contact) || friction_.is_active(contact)) return;
    contacts_.slip(contact, u_.data(), slip_.data());
    const Count half = contacts_.half(contact);
    Count base = 2 * half;
    Scalar largest = 0;
    for (Count t = 0; t < half; ++t) {  // without branches that nothing could foretell
      const Scalar size = magnitude(slip_[t]);
      base = size > largest ? t : base;
      largest = size > largest ? size : largest;
    }
    if (base < half && !(slip_[base] < 0)) base += half;
    activate_friction(contact, base);
  }

  void activate_friction(Count contact, Count base) {
    friction_.activate(contact, base);
    ratio_test_.allow_friction(contact);
    FrictionSimplex<Scalar>& simplex = simplex_[contact];
    simplex.directions = contacts_.block(contact);
    simplex.allowed = ratio_test_.allowed_of(contact);
    simplex.width = contacts_.padded_half(contact);
    simplex.cover = covering_.of_directions(contact);
    simplex.weights[0] = -1;
    simplex.weights[1] = contacts_.mu(contact);
    simplex.norms[1] = 0;
    simplex.set_base(base, contacts_.half(contact));
    if (rules_.classic) {
      load_normal(contact, column_.data());
      respond(column_.data(), row_.data());
      simplex.norms[1] = norm_of(row_.data());
      covering_.cover_cone(contact, simplex.norms[1]);
    }
  }

  void set_base(Count contact, Count direction) {
    friction_.set_base(contact, direction);
    simplex_[contact].set_base(direction, contacts_.half(contact));
  }

  // --- values and rates: path_values.h ---

  bool compute_values();
  void compute_values_once() {
    kernel_.solve_target(x_.data());
    respond_to_values();
  }
  /// u_ and value_scale_ of x_.
  void respond_to_values() {
    kernel_.respond_from(contacts_.velocity(), x_.data(), u_.data());
    measure_value_scale();
  }
  void measure_value_scale();
  bool invert_and_recompute(Scalar& missed) {
    if (!invert()) return false;
    compute_values_once();
    missed = largest_residual();
    return true;
  }
  Scalar lost_residual() const { return static_cast<Scalar>(kLostRoundings * kUnitRoundoff<Scalar>) * value_scale_; }
  Scalar residual_tolerance() const { return static_cast<Scalar>(kRefineTolerance) * speed_scale_; }
  Scalar largest_residual();
  Scalar refine();
  void compute_rates(const Entering& entering);
  void solve_for_rates();
  /// Kernels of more rows may be so ill-conditioned that their inverse alone gives directions too noisy to tell a rate
  /// of zero, as dependent contacts have it, from others.
  bool large() const { return kernel_.order() > kLargeOrder; }
  void refine_large_rates(Count row);
  Scalar measure_rates(Count row);
  void correct_rates(Count row);
  Scalar artificial_value() const { return artificial_ >= 0 ? x_[artificial_] : Scalar(0); }
  Scalar artificial_rate() const { return artificial_ >= 0 ? dx_[artificial_] : Scalar(0); }
  Scalar compute_candidates(const Entering& entering);
  template <bool kSkips>
  Scalar compute_candidates_by(const Entering& entering);
  void compute_column_candidates();
  void compute_base_values(const Entering& entering);
  Scalar simplex_weight(Label label) const { return label.is_normal() ? contacts_.mu(label.contact) : Scalar(-1); }
  void compute_normal_velocities() {
    const Count length = contacts_.padded_nc();
    combine(contacts_.normals(), length, contacts_.ngc(), u_.data(), ratio_test_.values(), length);
  }
  template <bool kSkips>
  void offer_normals(LeastRatio<Scalar>& least);
  template <bool kSkips>
  void compute_slips(Count slot);
  void add_yields_to_slips(Count slot);
  void offer_contact(Count contact, bool enters, Count first, LeastRatio<Scalar>& least);
  /// Where slip ends, lambda and the slip in the opposite direction reach zero together. In the ratio test lambda is
  /// multiplied by this, so that it leaves first: the unused share of friction becomes basic, instead of the opposite
  /// direction.
  static constexpr double kStickingFirst = 4;

  /// Column of z0 where it is no basic variable and has come to its end.
  static constexpr Count kPastEnd = -2;
  /// Rates of fall up to this count as zero.
  Scalar least_rate() const {
    const Scalar rounding = static_cast<Scalar>(kPivotTolerance) * rate_scale_;
    const Scalar noise = static_cast<Scalar>(kSafeNoises) * rate_noise_;
    return noise > rounding ? noise : rounding;
  }
  LeavingVariable choose_leaving(Scalar theta) const;

  // --- exchanges: path_exchanges.h ---

  bool exchange(Entering& entering, LeavingVariable leaving);
  void drop_column(const Entering& entering, Count column);
  bool bring_row(Entering& entering, Label leaving);
  /// Another basic friction impulse of the contact becomes its base, the old base an unknown of the kernel.
  /// @returns the column of the old base
  Count change_base(Count contact, const Entering& entering) {
    const Count place = largest_friction_column(contact);
    make_base(contact, place, entering);
    return place;
  }
  void make_base(Count contact, Count place, const Entering& entering);
  Count largest_friction_column(Count contact) const;
  void move_rows(Count contact, Count row);
  void move_columns(Count contact, Count place, const Entering& entering);
  bool replace_base_by_entering(Entering& entering);
  bool has_friction_labels(Count contact, const Entering& entering) const {
    return friction_.support(contact) > 0 || (entering.label.contact == contact && !entering.label.is_normal());
  }
  bool open_sticking(Entering& entering, Count contact);
  bool rebuild();
  void load_any_column(Label label);
  bool invert() {
    ++outcome_.factorizations;
    outcome_.work += kernel_.order() * kernel_.order() * (kernel_.order() + contacts_.ngc());
    return kernel_.invert(artificial_);
  }

  // --- ends: path_ends.h ---

  static constexpr bool kRoundsShares = sizeof(Scalar) > sizeof(double);

  Ending finish(double* z);
  bool round_impulses(Scalar* rounded);
  void write_impulses(const Scalar* impulses, double* z) const;
  void write_friction(Label label, Scalar value, double* z) const {
    if (label.direction == contacts_.edges(label.contact)) return;
    z[contacts_.nc() + contacts_.first_direction(label.contact) + label.direction] = static_cast<double>(value);
  }

  contact_lemke::Rules rules_;
  contact_lemke::Outcome outcome_;
  Contacts<Scalar> contacts_;
  Response<Scalar> response_;
  Kernel<Scalar> kernel_;
  RoundedShares<Scalar> shares_;
  Entering entering_;       ///< the variable that enters next
  Count artificial_ = -1;   ///< column of z0
  bool has_basis_ = false;  ///< that of a solve, at basis_velocity_
  VisitedBases visited_;
  bool resumed_ = false;  ///< z0 acts through drift_, not through a covering vector

  Buffer<Scalar> x_, dx_, residual_, coefficients_;           ///< per column or row of the kernel
  Buffer<Scalar> u_, du_, entering_response_, column_, row_;  ///< per generalized coordinate
  Buffer<Scalar> basis_velocity_, drift_;
  static constexpr double kWorthRefining = 1e-3;  ///< residual relative to the scale beyond which refining is slow
  static constexpr double kLostRoundings = 10;    ///< residual after refinement that asks for inversion
  static constexpr Count kLargeOrder = 32;        ///< no kernel of the paper's experiments 1 to 6 is as large
  static constexpr Count kRateRefinements = 3;
  /// A rate of at most this times the largest one counts as zero.
  static constexpr double kPivotTolerance = 1000 * kUnitRoundoff<Scalar>;
  /// Relative to value_scale_: the slack of the ratio test, and what counts as zero of the artificial variable.
  static constexpr double kTieTolerance = 30 * kUnitRoundoff<Scalar>;
  /// Relative to speed_scale_: basic variables that leave more velocity than this in the kernel's rows are refined.
  static constexpr double kRefineTolerance = 1000 * kUnitRoundoff<Scalar>;
  static constexpr double kSafeNoises = 100;  ///< a rate of at most so many times rate_noise_ counts as zero
  bool refines_rates_ = false;
  bool is_strained_ = false;  ///< values had to be refined on the path
  Scalar entering_norm_ = 0;  ///< norm_of() the response to the entering impulse
  Scalar rate_noise_ = 0;     ///< error of the rates of a large kernel's rows
  // The largest terms that add up to velocities, to values and to rates.
  Scalar speed_scale_ = 0, value_scale_ = 0, rate_scale_ = 0;

  FrictionState friction_;
  CoveringVector<Scalar> covering_{contacts_, friction_};
  Buffer<FrictionSimplex<Scalar>> simplex_;  ///< by contact, and one more place for what is of none
  Buffer<Scalar> slip_;
  RatioTest<Scalar> ratio_test_{contacts_, kernel_, friction_};
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL

#include "native/contact_lemke/path_continuation.h"
#include "native/contact_lemke/path_ends.h"
#include "native/contact_lemke/path_exchanges.h"
#include "native/contact_lemke/path_values.h"
