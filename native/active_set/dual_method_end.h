#pragma once

// What DualMethod makes of an active set that is given: impulses, velocity, Farkas vector.

#include "native/active_set/dual_method.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

template <class Scalar>
inline bool DualMethod<Scalar>::append_independent(Count contact) {
  if (basis_.size() >= most_active()) return false;
  const Count k = basis_.size();
  const Scalar squared_norm = whitening_.squared_norm(contact);
  const Scalar noise = whitening_.noise();
  const Scalar left = basis_.split(whitening_.normal(contact), squared_norm, coefficients_.data(), rest_.data());
  if (!(left > noise * noise * squared_norm)) return false;
  basis_.append(coefficients_.data(), rest_.data(), left);
  active_[k] = contact;
  weight_[contact] = 0;
  return true;
}

template <class Scalar>
inline void DualMethod<Scalar>::warm_start(const Rules& rules, Outcome& outcome) {
  for (Count j = 0; j < whitening_.nc(); ++j) {
    if (rules.start[j] > 0) append_independent(j);
  }
  ++outcome.factorizations;
  for (;;) {
    find_active_impulses();
    Count most_pulled = -1;
    Scalar least = 0;
    for (Count k = 0; k < basis_.size(); ++k) {
      if (!(active_impulse_[k] < least)) continue;
      least = active_impulse_[k];
      most_pulled = k;
    }
    if (most_pulled < 0) break;
    drop(most_pulled);
    ++outcome.steps;
  }
  add_change_to_slack();
}

template <class Scalar>
inline void DualMethod<Scalar>::find_active_impulses() {
  Scalar* c = coefficients_.data();
  if (whitening_.triangular() && b_ == nullptr) {
    for (Count k = 0; k < basis_.size(); ++k) c[k] = -dot(basis_.q(k), y0_.data(), lanes());
  } else {
    for (Count k = 0; k < basis_.size(); ++k) c[k] = -given_[active_[k]];
    basis_.solve_transposed(c);
  }
  set_zero(change_.data(), lanes());
  combine_rows(change_.data(), change_.data(), basis_.q(0), lanes(), c, basis_.size(), lanes());
  pressing_ = basis_.size();
  for (Count k = 0; k < basis_.size(); ++k) active_impulse_[k] = c[k];
  basis_.solve_in_doubles(active_impulse_.data());
}

template <class Scalar>
inline void DualMethod<Scalar>::polish(Outcome& outcome) {
  ++outcome.factorizations;
  Count count = basis_.size();
  clear_basis();
  for (Count k = 0; k < count; ++k) {
    remaining_[k] = whitening_.squared_norm(active_[k]) * (active_impulse_[k] * active_impulse_[k]);
  }
  while (basis_.size() < count) {
    const Count k = basis_.size();
    Count next = k;
    for (Count i = k + 1; i < count; ++i) {
      if (remaining_[i] < remaining_[next]) next = i;
    }
    exchange(k, next);
    if (!append_independent(active_[k])) {  // its impulse is zero: the others do
      exchange(k, --count);
      continue;
    }
    for (Count i = k + 1; i < count; ++i) {
      const Scalar along = dot(basis_.q(k), whitening_.normal(active_[i]), lanes());
      remaining_[i] -= along * along * (active_impulse_[i] * active_impulse_[i]);
    }
  }
  find_active_impulses();
}

template <class Scalar>
inline Count DualMethod<Scalar>::take_impulses(const double* z) {
  Count pressed = 0;
  for (Count j = 0; j < whitening_.nc(); ++j) {
    impulse_[j] = static_cast<Scalar>(z[j]);
    if (z[j] != 0) active_[pressed++] = j;
  }
  for (Count j = whitening_.nc(); j < contact_lanes(); ++j) impulse_[j] = 0;
  return pressed;
}

template <class Scalar>
inline bool DualMethod<Scalar>::write_answer(double* z, double* velocity) {
  set_zero(impulse_.data(), contact_lanes());
  for (Count k = 0; k < pressing_; ++k) {
    if (!finite(active_impulse_[k])) return false;
    // A negative one is rounding, or else the test finds what is missing.
    impulse_[active_[k]] = active_impulse_[k] > 0 ? active_impulse_[k] : Scalar(0);
  }
  compute_velocity();
  if (pressing_ > 0) keep_unmoved_velocity();
  for (Count j = 0; j < whitening_.nc(); ++j) z[j] = static_cast<double>(impulse_[j]);
  for (Count i = 0; i < whitening_.ngc(); ++i) {
    velocity[i] = static_cast<double>(velocity_[i]);
    if (!(velocity[i] - velocity[i] == 0)) return false;
  }
  return true;
}

template <class Scalar>
inline void DualMethod<Scalar>::compute_velocity() {
  if (pressing_ == 0) {
    copy(velocity_.data(), v_.data(), lanes());
  } else if (whitening_.triangular()) {
    // v plus the change, not C^-1 of their sum: a coordinate may move by far less than what the terms of C v lose.
    copy(velocity_.data(), change_.data(), lanes());
    whitening_.solve(velocity_.data());
    add_multiple(velocity_.data(), Scalar(1), v_.data(), lanes());
  } else if (whitening_.is_of_inverse()) {  // without its root, whose rounding moves what G* does not
    set_zero(rest_.data(), lanes());
    for (Count k = 0; k < pressing_; ++k) {
      add_unpadded_multiple(rest_.data(), impulse_[active_[k]], whitening_.given_normal(active_[k]), whitening_.ngc());
    }
    copy(velocity_.data(), v_.data(), lanes());
    for (Count i = 0; i < whitening_.ngc(); ++i) {
      add_unpadded_multiple(velocity_.data(), rest_[i], whitening_.inertia_column(i), whitening_.ngc());
    }
  } else {
    whitening_.add_response(v_.data(), change_.data(), velocity_.data());
  }
}

template <class Scalar>
inline void DualMethod<Scalar>::keep_unmoved_velocity() {
  const bool is_one = island_of_coordinate_ == nullptr;
  if (is_one && static_cast<double>(impulse_[active_[0]]) != 0) return;  // as nearly always: it saves the loops
  for (Count k = 0; k < whitening_.nc(); ++k) is_moved_[k] = false;
  for (Count k = 0; k < pressing_; ++k) {
    const Count island = is_one ? 0 : island_of_contact_[active_[k]];
    if (island >= 0 && static_cast<double>(impulse_[active_[k]]) != 0) is_moved_[island] = true;
  }
  for (Count i = 0; i < whitening_.ngc(); ++i) {
    const Count island = is_one ? 0 : island_of_coordinate_[i];
    if (island < 0 || !is_moved_[island]) velocity_[i] = v_[i];
  }
}

template <class Scalar>
bool DualMethod<Scalar>::keeps_digits() const {
  // What underflows beside it, 2^-1074, is no more than the rounding that the verdict allows, 2^-53 of it.
  constexpr Scalar kLeast = static_cast<Scalar>(1e-140);
  for (Count k = 0; k < pressing_; ++k) {
    if (coefficients_[k] != 0 && magnitude(coefficients_[k]) < kLeast) return false;
  }
  if (!whitening_.triangular() || pressing_ == 0) return true;
  const auto zero = L::broadcast(0);
  auto missing = zero;
  for (Count i = 0; i < lanes(); i += L::kWidth) {
    const auto v = L::load(v_.data() + i);
    const auto distance = L::load(whitening_.root_diagonal() + i) * L::max(v, -v);
    missing = L::max(v == zero ? zero : L::broadcast(kLeast) - distance, missing);
  }
  return !(L::max(missing) > 0);
}

template <class Scalar>
inline void DualMethod<Scalar>::write_farkas(double* u) {
  for (Count j = 0; j < whitening_.nc(); ++j) u[j] = 0;
  u[entering_contact_] = 1;
  if (!(whitening_.squared_norm(entering_contact_) > 0)) return;
  for (Count k = 0; k < basis_.size(); ++k) u[active_[k]] = share_[k] < 0 ? static_cast<double>(-share_[k]) : 0;
}

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
