#pragma once

#include "native/contact_lemke/path.h"

// From the last basis: how a path goes on from the solve before.

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// The basis of the last solve, for v_b, is followed along v = v_now + z0 (v_b - v_now) from z0 = 1, where it is
/// complementary and feasible, to z0 = 0: Lemke's path with J'(v_b - v_now) as covering vector. No pivot is needed
/// where the basis stays feasible; else about as many as contacts change. Nothing is proven of its end.
template <class Scalar>
inline auto Path<Scalar>::resume(double* z) -> Ending {
  if (expired()) return Ending::kTimeLimit;
  begin_walk();
  if (!has_basis_ || !release_artificial()) return Ending::kBreakdown;
  turn_to_drift();
  compute_values_before_drift();
  if (turn_friction()) begin_where_friction_has_turned();
  const Entering time{false, Label{}};
  compute_rates_of_drift();
  const LeavingVariable leaving = choose_leaving(compute_candidates(time));
  if (leaving.kind == Kind::kBroken) return Ending::kBreakdown;
  if (leaving.kind == Kind::kNone || leaving.column == kPastEnd) return finish(z);
  if (outcome_.pivots >= rules_.max_pivots) return Ending::kPivotLimit;
  ++outcome_.pivots;
  enter_artificial_backwards();
  entering_ = time;
  if (!exchange(entering_, leaving)) return Ending::kBreakdown;
  artificial_ = kernel_.find_column(Label{});
  return walk(z);
}

/// A path that ended because z0 was zero may have left it in the basis: what was to enter takes its place.
template <class Scalar>
inline bool Path<Scalar>::release_artificial() {
  if (artificial_ < 0) return true;
  if (!entering_.is_velocity && entering_.label.is_normal()) activate_friction(entering_.label.contact);
  compute_rates(entering_);
  if (!(magnitude(dx_[artificial_]) > 0)) return false;
  return exchange(entering_, {Kind::kColumn, artificial_, Label{}}) && artificial_ < 0;
}

/// The covering vector is zero: z0 acts through the column v_b - v_now alone.
template <class Scalar>
inline void Path<Scalar>::turn_to_drift() {
  resumed_ = true;
  const Scalar* const velocity = contacts_.velocity();
  for (Count i = 0; i < contacts_.extent(); ++i) drift_[i] = basis_velocity_[i] - velocity[i];
  covering_.clear();
  kernel_.measure(velocity, residual_.data());
  for (Count r = 0; r < kernel_.order(); ++r) {
    kernel_.set_cover(r, Scalar(0));
    kernel_.set_target(r, -residual_[r]);
  }
  const Scalar before = square_root(dot(basis_velocity_.data(), basis_velocity_.data(), contacts_.padded_ngc()));
  speed_scale_ = contacts_.reach() * (before > contacts_.speed() ? before : contacts_.speed());
  if (contacts_.is_soft()) speed_scale_ += contacts_.creep();
}

/// x and u at z0 = 1, refined once: u = v_b + G* A x.
template <class Scalar>
inline void Path<Scalar>::compute_values_before_drift() {
  for (Count j = 0; j < kernel_.order(); ++j) x_[j] = 0;
  for (Count pass = 0; pass < 2; ++pass) {
    respond_to_values();
    add_multiple(u_.data(), Scalar(1), drift_.data(), contacts_.extent());
    kernel_.measure(u_.data(), residual_.data());
    kernel_.solve(residual_.data(), coefficients_.data());
    for (Count j = 0; j < kernel_.order(); ++j) x_[j] -= coefficients_[j];
  }
  respond_to_values();
  add_multiple(u_.data(), Scalar(1), drift_.data(), contacts_.extent());
}

/// Friction that has turned round needs no path. While a contact sticks and leaves a share of its friction unused, an
/// impulse that v_now asks for with the wrong sign is one in the opposite direction, whose velocity is zero as well:
/// the two take each other's place in the basis. x_ gets its value for v_now, dx_ all values for v_now.
/// @returns whether any did
template <class Scalar>
inline bool Path<Scalar>::turn_friction() {
  const Entering nothing{true, Label{}};
  kernel_.solve_target(dx_.data());
  compute_base_values(nothing);
  const std::ptrdiff_t before = outcome_.pivots;
  for (Count k = 0; k < friction_.count(); ++k) {
    const Count contact = friction_.contact(k);
    if (!asks_for_turning(contact) || !leave_unused_share_as_base(contact, nothing)) continue;
    for (Count j = 0; j < kernel_.order(); ++j) {
      if (is_friction_of(contact, j) && dx_[j] < 0 && outcome_.pivots < rules_.max_pivots) turn(j);
    }
  }
  return outcome_.pivots > before;
}

/// Whether friction along a direction would be negative.
template <class Scalar>
inline bool Path<Scalar>::asks_for_turning(Count contact) const {
  const Count zero = contacts_.edges(contact);
  if (friction_.base(contact) != zero && simplex_[contact].rate < 0) return true;
  for (Count j = 0; j < kernel_.order(); ++j) {
    if (is_friction_of(contact, j) && kernel_.column_label(j).direction != zero && dx_[j] < 0) return true;
  }
  return false;
}

/// Makes the share that friction leaves unused the contact's base. False where there is none.
template <class Scalar>
inline bool Path<Scalar>::leave_unused_share_as_base(Count contact, const Entering& entering) {
  const Label unused{contact, contacts_.edges(contact)};
  if (friction_.base(contact) == unused.direction) return true;
  const Count place = kernel_.find_column(unused);
  if (place < 0 || !(dx_[place] > 0) || kernel_.find_row(unused) < 0) return false;
  make_base(contact, place, entering);
  return true;
}

/// Unknown j, a friction impulse, and the velocity that is zero for it become those of the opposite direction.
template <class Scalar>
inline void Path<Scalar>::turn(Count j) {
  const Label label = kernel_.column_label(j);
  const Count half = contacts_.half(label.contact);
  const Label opposite{label.contact, label.direction < half ? label.direction + half : label.direction - half};
  const Count row = kernel_.find_row(label);
  if (row < 0) return;
  kernel_.negate_row(row);
  kernel_.negate_unknown(j);
  kernel_.relabel_row(row, opposite);
  kernel_.relabel_column(j, opposite);
  ratio_test_.allow(label);
  ratio_test_.forbid(opposite);
  x_[j] = dx_[j] = -dx_[j];
  ++outcome_.pivots;
}

/// The path begins with the velocity u of the last basis and impulses that are feasible now: those of the last basis,
/// of friction that has turned those for v_now, of its normals as much as that needs. v_b is what goes with them.
template <class Scalar>
inline void Path<Scalar>::begin_where_friction_has_turned() {
  compute_base_values({true, Label{}});
  for (Count k = 0; k < friction_.count(); ++k) {
    const Count contact = friction_.contact(k);
    const Count normal = kernel_.find_column(Label{contact, kNormal});
    if (!(simplex_[contact].value < 0) || normal < 0) continue;
    x_[normal] += (magnitude(simplex_[contact].rate) - simplex_[contact].value) / contacts_.mu(contact);
  }
  kernel_.respond(x_.data(), du_.data());
  const Scalar* const velocity = contacts_.velocity();
  for (Count i = 0; i < contacts_.extent(); ++i) drift_[i] = u_[i] - du_[i] - velocity[i];
  for (Count i = 0; i < contacts_.extent(); ++i) du_[i] = drift_[i] + velocity[i];
  const Scalar speed = norm_of(du_.data());
  if (speed > speed_scale_) speed_scale_ = speed;
  measure_value_scale();
}

/// Of 1 - z0, which grows to 1.
template <class Scalar>
inline void Path<Scalar>::compute_rates_of_drift() {
  copy(entering_response_.data(), drift_.data(), contacts_.extent());
  scale(entering_response_.data(), Scalar(-1), contacts_.extent());
  entering_norm_ = norm_of(drift_.data());
  rate_noise_ = 0;
  solve_for_rates();
}

/// The path goes on in terms of z0 itself: all rates change their signs.
template <class Scalar>
inline void Path<Scalar>::enter_artificial_backwards() {
  copy(entering_response_.data(), drift_.data(), contacts_.extent());
  scale(dx_.data(), Scalar(-1), kernel_.order());
  for (Count k = 0; k < friction_.count(); ++k) simplex_[friction_.contact(k)].rate *= -1;
}

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
