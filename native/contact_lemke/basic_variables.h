#pragma once

#include "native/contact_lemke/basis.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// Values of the basic variables, and their rates as a variable enters: x and dx of the kernel's columns, u and du of
/// the coordinates.
///
/// The rows of the kernel should have velocity zero. Where they miss it by more than rounding, the inverse has lost
/// accuracy: x is refined, or the kernel inverted afresh.
template <class Scalar>
class BasicVariables {
 public:
  explicit BasicVariables(Basis<Scalar>& basis) : basis_(basis), kernel_(basis.kernel), contacts_(basis.contacts) {}

  /// Takes all memory; touches none of it. @pre the basis is reserved
  void reserve() {
    Buffer<Scalar>* const by_coordinate[] = {&u, &du, &entering_response};
    for (Buffer<Scalar>* buffer : by_coordinate) buffer->resize(contacts_.extent());
    Buffer<Scalar>* const by_row[] = {&x, &dx, &residual_, &coefficients_};
    for (Buffer<Scalar>* buffer : by_row) buffer->resize(kernel_.stride());
  }
  void load() { fill_with_zeros(contacts_.extent(), u, du, entering_response); }

  /// z = 0
  void begin() {
    speed_scale_ = contacts_.reach() * contacts_.speed();
    if (contacts_.is_soft()) speed_scale_ += contacts_.creep();
    copy(u.data(), contacts_.velocity(), contacts_.extent());
    x[0] = 0;
  }

  /// x and u of a basis at the velocity v + drift, refined once, and their rates as that becomes v.
  void begin_at_drift(const Scalar* drift) {
    const Count ngc = contacts_.padded_ngc(), extent = contacts_.extent();
    const Scalar* const v = contacts_.velocity();
    for (Count i = 0; i < extent; ++i) entering_response[i] = v[i] + drift[i];
    const Scalar before = square_root(dot(entering_response.data(), entering_response.data(), ngc));
    speed_scale_ = contacts_.reach() * (before > contacts_.speed() ? before : contacts_.speed());
    if (contacts_.is_soft()) speed_scale_ += contacts_.creep();
    for (Count j = 0; j < kernel_.order(); ++j) x[j] = 0;
    for (Count pass = 0; pass < 2; ++pass) {
      respond_to_values(entering_response.data());
      kernel_.measure(u.data(), residual_.data());
      kernel_.solve(residual_.data(), coefficients_.data());
      for (Count j = 0; j < kernel_.order(); ++j) x[j] -= coefficients_[j];
    }
    respond_to_values(entering_response.data());
    copy(entering_response.data(), drift, extent);
    scale(entering_response.data(), Scalar(-1), extent);
    entering_norm = basis_.norm_of(drift);
    rate_noise_ = 0;
    solve_for_rates();
  }

  /// The rates are those as the drift grows. @pre begin_at_drift()
  void reverse_drift() {
    scale(entering_response.data(), Scalar(-1), contacts_.extent());
    scale(dx.data(), Scalar(-1), kernel_.order());
    for (Count k = 0; k < basis_.friction.count(); ++k) basis_.simplex[basis_.friction.contact(k)].rate *= -1;
  }

  /// x, u and the scale of rounding in them. @param is_fresh  the kernel has just been inverted
  /// @returns false where the kernel is singular
  bool compute_values(bool is_fresh) {
    compute_values_once();
    Scalar missed = largest_residual();
    refines_rates_ = missed > residual_tolerance();
    if (missed > static_cast<Scalar>(kWorthRefining) * value_scale_ && !invert_and_recompute(missed)) return false;
    if (missed > residual_tolerance()) missed = refine();
    const auto is_lost = [&] {
      return missed > static_cast<Scalar>(kLostRoundings * kUnitRoundoff<Scalar>) * value_scale_;
    };
    if (is_fresh || !is_lost()) return true;
    missed = refine();
    if (!is_lost()) return true;
    if (!invert_and_recompute(missed)) return false;
    if (missed > residual_tolerance()) missed = refine();
    return true;
  }

  /// One step of iterative refinement of x. @returns the largest residual after it
  /// @pre compute_values()
  Scalar refine() {
    count_refinement();
    kernel_.solve(residual_.data(), coefficients_.data());
    add_multiple(x.data(), Scalar(-1), coefficients_.data(), kernel_.order());
    respond_to_values(contacts_.velocity());
    return largest_residual();
  }

  void compute_rates(const Entering& entering) {
    rate_noise_ = 0;
    if (entering.is_velocity) {
      const Count row = kernel_.find_row(entering.label);
      copy(dx.data(), kernel_.inverse_column(row), kernel_.order());
      kernel_.respond(dx.data(), du.data());
      entering_norm = 1;
      if (is_large()) refine_large_rates(row);
      return;
    }
    basis_.load_column(entering.label, basis_.column.data());
    basis_.respond(basis_.column.data(), entering_response.data());
    entering_norm = basis_.norm_of(entering_response.data());
    solve_for_rates();
  }

  Scalar artificial_value() const { return kernel_.artificial() >= 0 ? x[kernel_.artificial()] : Scalar(0); }
  Scalar artificial_rate() const { return kernel_.artificial() >= 0 ? dx[kernel_.artificial()] : Scalar(0); }

  /// What is no more than rounding of a value in m/s: the slack of the ratio test, and what counts as zero of z0.
  Scalar tie_tolerance() const { return static_cast<Scalar>(kTieTolerance) * value_scale_; }
  /// Rates of fall up to this count as zero. @param rate_scale  the largest rate of an impulse, in m/s
  Scalar least_rate(Scalar rate_scale) const {
    const Scalar rounding = static_cast<Scalar>(kPivotTolerance) * rate_scale;
    const Scalar noise = static_cast<Scalar>(kSafeNoises) * rate_noise_;
    return noise > rounding ? noise : rounding;
  }

  Buffer<Scalar> x, dx;              ///< per column of the kernel
  Buffer<Scalar> u, du;              ///< per coordinate, extent() entries
  Buffer<Scalar> entering_response;  ///< c of the entering impulse
  Scalar entering_norm = 0;          ///< norm_of() it

 private:
  using P = Packed<Scalar>;
  using Pack = typename P::Pack;

  static constexpr double kWorthRefining = 1e-3;  ///< residual relative to the scale beyond which refining is slow
  static constexpr double kLostRoundings = 10;    ///< residual after refinement that asks for inversion
  static constexpr Count kLargeOrder = 32;        ///< no kernel of the paper's experiments 1 to 6 is as large
  static constexpr Count kRateRefinements = 3;
  /// A rate of at most this times the largest one counts as zero.
  static constexpr double kPivotTolerance = 1000 * kUnitRoundoff<Scalar>;
  /// Relative to value_scale_.
  static constexpr double kTieTolerance = 30 * kUnitRoundoff<Scalar>;
  /// Relative to speed_scale_: basic variables that leave more velocity than this in the kernel's rows are refined.
  static constexpr double kRefineTolerance = 1000 * kUnitRoundoff<Scalar>;
  static constexpr double kSafeNoises = 100;  ///< a rate of at most so many times rate_noise_ counts as zero

  Scalar residual_tolerance() const { return static_cast<Scalar>(kRefineTolerance) * speed_scale_; }

  void compute_values_once() {
    kernel_.solve_target(x.data());
    respond_to_values(contacts_.velocity());
  }

  /// u and value_scale_ of x, from the velocity v.
  void respond_to_values(const Scalar* v) {
    kernel_.respond_from(v, x.data(), u.data());
    Pack largest = P::broadcast(speed_scale_);
    for (Count j = 0; j < kernel_.order(); j += P::kWidth) {
      const Pack value =
          without_entry<Scalar>(P::load(x.data() + j), j, kernel_.artificial()) * P::load(kernel_.norms() + j);
      largest = larger_magnitude<Scalar>(entries_of<Scalar>(value, j, kernel_.order()), largest);
    }
    value_scale_ = P::max(largest);
  }

  /// Of the velocities of the kernel's rows, which should be zero. Writes all of them to residual_.
  Scalar largest_residual() {
    kernel_.measure(u.data(), residual_.data());
    const Scalar z0 = artificial_value();
    Pack largest = Pack{};
    for (Count r = 0; r < kernel_.order(); r += P::kWidth) {
      const Pack missed = P::load(residual_.data() + r) + P::load(kernel_.covers() + r) * z0;
      P::store(residual_.data() + r, missed);
      largest = larger_magnitude<Scalar>(entries_of<Scalar>(missed, r, kernel_.order()), largest);
    }
    return P::max(largest);
  }

  bool invert_and_recompute(Scalar& missed) {
    if (!basis_.invert()) return false;
    compute_values_once();
    missed = largest_residual();
    return true;
  }

  void count_refinement() { basis_.work += kernel_.order() * (kernel_.order() + 2 * contacts_.ngc()); }

  /// dx and du of what enters with entering_response.
  void solve_for_rates() {
    kernel_.measure(entering_response.data(), residual_.data());
    kernel_.solve(residual_.data(), dx.data());
    scale(dx.data(), Scalar(-1), kernel_.order());
    kernel_.respond_from(entering_response.data(), dx.data(), du.data());
    if (refines_rates_) {
      measure_rates(-1);
      correct_rates(-1);
    }
    if (is_large()) refine_large_rates(-1);
  }

  /// Kernels of more rows may be so ill-conditioned that their inverse alone gives directions too noisy to tell a rate
  /// of zero, as dependent contacts have it, from others.
  bool is_large() const { return kernel_.order() > kLargeOrder; }

  /// Refines the rates of a large kernel as long as that at least halves the residual of its rows. rate_noise_ becomes
  /// the residual after it: the rates of velocities that depend on those rows are not known any better.
  /// @param row  of the entering velocity; -1 where an impulse or z0 enters
  void refine_large_rates(Count row) {
    rate_noise_ = measure_rates(row);
    // Contacts that yield do not depend on each other: mostly the noise is far below what counts as a rate at all.
    const Scalar harmless = static_cast<Scalar>(kPivotTolerance / kSafeNoises) * entering_norm;
    for (Count k = 0; k < kRateRefinements && !(contacts_.is_soft() && rate_noise_ <= harmless); ++k) {
      correct_rates(row);
      const Scalar before = rate_noise_;
      rate_noise_ = measure_rates(row);
      if (!(rate_noise_ <= before / 2)) return;
    }
  }

  /// residual_ := the rates of the kernel's rows, which should be zero, and 1 in `row`. @returns the largest error
  Scalar measure_rates(Count row) {
    kernel_.measure(du.data(), residual_.data());
    Scalar largest = 0;
    for (Count r = 0; r < kernel_.order(); ++r) {
      residual_[r] += kernel_.cover(r) * artificial_rate();
      if (r == row) residual_[r] -= Scalar(1);
      largest = magnitude(residual_[r]) > largest ? magnitude(residual_[r]) : largest;
    }
    return largest;
  }

  /// One step of iterative refinement of the rates from residual_. @pre measure_rates(row)
  void correct_rates(Count row) {
    count_refinement();
    kernel_.solve(residual_.data(), coefficients_.data());
    add_multiple(dx.data(), Scalar(-1), coefficients_.data(), kernel_.order());
    if (row < 0) kernel_.respond_from(entering_response.data(), dx.data(), du.data());
    if (row >= 0) kernel_.respond(dx.data(), du.data());
  }

  Basis<Scalar>& basis_;
  Kernel<Scalar>& kernel_;
  Contacts<Scalar>& contacts_;
  Buffer<Scalar> residual_, coefficients_;  ///< per row or column of the kernel
  Scalar speed_scale_ = 0, value_scale_ = 0;  ///< the largest terms that add up to velocities, and to values
  bool refines_rates_ = false;
  Scalar rate_noise_ = 0;  ///< error of the rates of a large kernel's rows
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
