#pragma once

#include "native/contact_lemke/path.h"

// Whether the last basis proves that the problem has a solution.

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// Bounds on what the computed values of the last basis are off, in Euclid's norms.
///
/// Let K x = -B'v be the system of the basis for the exact data, R the computed inverse and x~ the computed impulses.
/// If |I - R K| < 1, K is regular, and x is off x~ by at most |R| |B'(v + G* A x~)| / (1 - |I - R K|). Impulses are
/// measured by the speeds n_j = |c_j| that they cause. Where each basic impulse and each velocity that must not be
/// negative exceeds its bound, x is a solution of the exact problem. It need not be near the answer.
template <class Scalar>
struct Path<Scalar>::Doubt {
  Scalar response = 0;  ///< of a column c_j of the kernel, relative to the terms of a_j
  Scalar reach = 0;     ///< at least the norm of a row
  Scalar speed = 0;     ///< |v| and what all impulses cause
  Scalar terms = 0;     ///< sum of |x_j| times the terms of a_j
  Scalar gain = 0;      ///< sum of the terms of a_j over n_j
  Scalar inverse = 0;   ///< |I - R K|
  Scalar spread = 0;    ///< |R|
  Scalar missed = 0;    ///< of a row of the kernel: its velocity at x~
  Scalar impulse = 0;   ///< of x_j n_j
  Scalar rounding = 0;  ///< of a row's velocity, at x~
  Scalar velocity = 0;  ///< and at x
};

namespace proof {

/// For the rounding of the bounds themselves, and products of roundings.
constexpr double kSlack = 1.1;
/// Fractions by which contacts depend on others: their denominators and numerators.
constexpr Count kMostTimes = 64;
constexpr double kLargestShare = 1024;
constexpr double kNearInteger = 1e-6;

/// sum += x. @returns whether that was exact
inline bool add_exactly(double& sum, double x) {
  const double next = sum + x;
  const double added = next - sum;
  if (!((sum - (next - added)) + (x - added) == 0)) return false;
  sum = next;
  return true;
}

/// sum += times x, in two products of few bits. @returns whether that was exact
inline bool add_exactly(double& sum, double x, Count times) {
  unsigned long long bits = 0;
  static_assert(sizeof(bits) == sizeof(x));
  __builtin_memcpy(&bits, &x, sizeof(x));
  bits &= ~((1ULL << 27) - 1);
  double high = 0;
  __builtin_memcpy(&high, &bits, sizeof(x));
  const double factor = static_cast<double>(times);
  return add_exactly(sum, factor * high) && add_exactly(sum, factor * (x - high));
}

inline Count nearest_integer(double x) { return static_cast<Count>(x + (x < 0 ? -0.5 : 0.5)); }

}  // namespace proof

template <class Scalar>
inline bool Path<Scalar>::proves_solvable() {
  if (!contacts_.has_offset() && response_.is_regular()) return true;
  if (artificial_ >= 0 || !is_complementary()) return false;
  renew_kernel();
  Doubt doubt;
  return bound_values(doubt) && is_positive(doubt) && separates(doubt);
}

/// Whether the velocities of the kernel's rows are those of its columns, friction of pressing contacts alone.
template <class Scalar>
inline bool Path<Scalar>::is_complementary() const {
  for (Count j = 0; j < kernel_.order(); ++j) {
    const Label label = kernel_.column_label(j);
    if (kernel_.find_row(label) < 0) return false;
    if (friction_.is_active(label.contact) != contacts_.has_friction(label.contact)) return false;
  }
  for (Count k = 0; k < friction_.count(); ++k) {
    if (kernel_.find_column(Label{friction_.contact(k), kNormal}) < 0) return false;
  }
  return true;
}

/// Rows and columns from the data: exchanges have added roundings of their own. The inverse stays.
template <class Scalar>
inline void Path<Scalar>::renew_kernel() {
  for (Count k = 0; k < kernel_.order(); ++k) {
    load_row(kernel_.row_label(k));
    kernel_.put_row(k, kernel_.row_label(k), row_.data(), kernel_.cover(k), kernel_.target(k));
    load_column(kernel_.column_label(k));
    response_.apply(column_.data(), entering_response_.data());
    kernel_.put_column(k, kernel_.column_label(k), entering_response_.data(), norm_of(entering_response_.data()));
  }
}

template <class Scalar>
inline bool Path<Scalar>::bound_values(Doubt& doubt) {
  const Count order = kernel_.order();
  const Scalar slack = static_cast<Scalar>(proof::kSlack);
  const Scalar roundoff = static_cast<Scalar>(kUnitRoundoff<Scalar>);
  const Scalar rows = static_cast<Scalar>(static_cast<double>(order));
  const Scalar length = static_cast<Scalar>(static_cast<double>(contacts_.ngc()));
  const Scalar of_direction = friction_.count() > 0 ? contacts_.direction_reach() : Scalar(0);
  const auto is_safe = [](Scalar x) { return static_cast<double>(x) > 1e-100 && static_cast<double>(x) < 1e100; };

  doubt.reach = slack * (contacts_.reach() > 2 * of_direction ? contacts_.reach() : 2 * of_direction);
  doubt.speed = contacts_.speed();
  for (Count j = 0; j < order; ++j) {
    const Label label = kernel_.column_label(j);
    const Scalar speed = speed_of(j);
    Scalar terms = 2 * of_direction;
    if (label.is_normal()) {
      terms = contacts_.reach();
      if (friction_.is_active(label.contact)) terms += contacts_.mu(label.contact) * of_direction;
    }
    if (!is_safe(speed) || !is_safe(terms)) return false;
    doubt.speed += magnitude(x_[j]) * speed;
    doubt.terms += magnitude(x_[j]) * terms;
    doubt.gain += terms / speed;
  }
  if (!is_safe(doubt.reach) || !is_safe(doubt.speed)) return false;
  if (order > 0) {
    const typename Response<Scalar>::Certainty certainty = response_.certainty();
    doubt.response = slack * (certainty.error + 3 * roundoff * certainty.norm);
    if (!(doubt.response < kInfinity<Scalar>) || !bound_inverse(doubt)) return false;
  }
  respond_to_values();
  doubt.rounding = slack * doubt.reach * ((length + rows + 8) * roundoff * doubt.speed + doubt.response * doubt.terms);
  doubt.missed = largest_residual() + doubt.rounding;
  doubt.impulse = slack * doubt.spread * doubt.missed / (1 - doubt.inverse);
  doubt.velocity = doubt.rounding + slack * doubt.reach * 2 * rows * doubt.impulse;
  return true;
}

/// |I - R K| and |R|, in the largest sum of a row. False where K may be singular.
template <class Scalar>
inline bool Path<Scalar>::bound_inverse(Doubt& doubt) {
  const Count order = kernel_.order();
  const Scalar roundoff = static_cast<Scalar>(kUnitRoundoff<Scalar>);
  const Scalar rows = static_cast<Scalar>(static_cast<double>(order));
  const Scalar length = static_cast<Scalar>(static_cast<double>(contacts_.ngc()));
  Scalar* const sizes = ratio_test_.falls() + ratio_test_.first_column();  // of the rows of R
  Scalar* const off = dx_.data();                                          // of the rows of I - R K
  for (Count i = 0; i < order; ++i) sizes[i] = off[i] = 0;
  Scalar slowness = 0;
  for (Count j = 0; j < order; ++j) {
    const Scalar* const of_inverse = kernel_.inverse_column(j);
    const Scalar slow = 1 / speed_of(j);
    slowness += slow;
    kernel_.measure(kernel_.column(j), residual_.data());
    kernel_.solve(residual_.data(), coefficients_.data());
    coefficients_[j] -= 1;
    for (Count i = 0; i < order; ++i) {
      sizes[i] += magnitude(of_inverse[i]);
      off[i] += magnitude(coefficients_[i]) * slow;
    }
  }
  const Scalar of_kernel = static_cast<Scalar>(proof::kSlack) * doubt.reach *
                           (rows * (length + rows + 4) * roundoff + doubt.response * doubt.gain);
  for (Count i = 0; i < order; ++i) {
    const Scalar speed = speed_of(i);
    const Scalar of_row = speed * (off[i] + roundoff * slowness + sizes[i] * of_kernel);
    if (!(of_row <= doubt.inverse)) doubt.inverse = number_or_infinity(of_row);
    if (!(speed * sizes[i] <= doubt.spread)) doubt.spread = number_or_infinity(speed * sizes[i]);
  }
  return doubt.inverse < static_cast<Scalar>(0.5);
}

/// Whether all impulses of the basis are positive, the base of each contact's friction among them.
template <class Scalar>
inline bool Path<Scalar>::is_positive(const Doubt& doubt) {
  const Count order = kernel_.order();
  for (Count j = 0; j < order; ++j) {
    if (!(x_[j] * speed_of(j) > doubt.impulse)) return false;
  }
  const Scalar roundings = static_cast<Scalar>(2 * kUnitRoundoff<Scalar> * static_cast<double>(order + 2));
  for (Count k = 0; k < friction_.count(); ++k) {
    Scalar base = 0, terms = 0, off = 0;
    for (Count j = 0; j < order; ++j) {
      const Label label = kernel_.column_label(j);
      if (label.contact != friction_.contact(k)) continue;
      const Scalar weight = simplex_weight(label);
      base += weight * x_[j];
      terms += magnitude(weight * x_[j]);
      off += magnitude(weight) * doubt.impulse / speed_of(j);
    }
    if (!(base > static_cast<Scalar>(proof::kSlack) * off + roundings * terms)) return false;
  }
  return true;
}

/// Whether no velocity outside the kernel is negative.
template <class Scalar>
inline bool Path<Scalar>::separates(const Doubt& doubt) {
  compute_normal_velocities();
  for (Count c = 0; c < contacts_.nc(); ++c) {
    if (!is_clear(Label{c, kNormal}, ratio_test_.values()[c], doubt) && !depends_on_rows(c)) return false;
  }
  for (Count k = 0; k < friction_.count(); ++k) {
    if (!slips_away(friction_.contact(k), doubt)) return false;
  }
  return true;
}

template <class Scalar>
inline bool Path<Scalar>::is_clear(Label label, Scalar velocity, const Doubt& doubt) {
  if (velocity > doubt.velocity || kernel_.find_row(label) >= 0) return true;
  return velocity > doubt.rounding && velocity > bound_velocity(label, doubt);
}

/// Sharper than doubt.velocity, of one row b. With k' = b'C R, C the kernel's columns, b sees of x - x~ no more than
/// |k| times what the rows miss, and what k'K misses of b'C times |x - x~|.
template <class Scalar>
inline Scalar Path<Scalar>::bound_velocity(Label label, const Doubt& doubt) {
  const Count order = kernel_.order();
  express_by_rows(label);
  Scalar weight = 0, off = 0;
  for (Count r = 0; r < order; ++r) weight += magnitude(residual_[r]);
  Scalar* const velocities = dx_.data();
  for (Count j = 0; j < order; ++j) {
    kernel_.measure(kernel_.column(j), velocities);
    off += magnitude(coefficients_[j] - dot(residual_.data(), velocities, order)) / speed_of(j);
  }
  const Scalar rows = static_cast<Scalar>(static_cast<double>(order));
  const Scalar length = static_cast<Scalar>(static_cast<double>(contacts_.ngc()));
  const Scalar roundings = rows * (length + rows + 4) * static_cast<Scalar>(kUnitRoundoff<Scalar>);
  off += doubt.reach * (1 + weight) * (roundings + doubt.response * doubt.gain);
  return static_cast<Scalar>(proof::kSlack) * (doubt.rounding + weight * doubt.missed + off * doubt.impulse);
}

/// coefficients_ := C'b and residual_ := R'C'b for the row b of a velocity: b as a combination of the kernel's rows.
template <class Scalar>
inline void Path<Scalar>::express_by_rows(Label label) {
  const Count order = kernel_.order();
  load_row(label);
  for (Count j = 0; j < P::padded(order); ++j) {
    coefficients_[j] = j < order ? dot(row_.data(), kernel_.column(j), contacts_.padded_ngc()) : Scalar(0);
  }
  for (Count r = 0; r < P::padded(order); ++r) {
    residual_[r] = r < order ? dot(coefficients_.data(), kernel_.inverse_column(r), order) : Scalar(0);
  }
}

template <class Scalar>
inline bool Path<Scalar>::slips_away(Count contact, const Doubt& doubt) {
  contacts_.slip(contact, u_.data(), slip_.data());
  const Count half = contacts_.half(contact);
  const Count base = friction_.base(contact);
  const Count zero = 2 * half;
  Scalar own = 0;
  if (base != zero) own = base < half ? slip_[base] : -slip_[base - half];
  if (base != zero && !is_clear(Label{contact, zero}, -own, doubt)) return false;
  for (Count t = 0; t < half; ++t) {
    if (t != base && !is_clear(Label{contact, t}, slip_[t] - own, doubt)) return false;
    if (t + half != base && !is_clear(Label{contact, t + half}, -slip_[t] - own, doubt)) return false;
  }
  return true;
}

/// Whether the contact's normal is a combination of the kernel's rows by small fractions, without any rounding: its
/// velocity is zero where theirs are.
template <class Scalar>
inline bool Path<Scalar>::depends_on_rows(Count contact) {
  express_by_rows(Label{contact, kNormal});
  for (Count times = 1; times <= proof::kMostTimes; ++times) {
    if (is_sum_of_rows(contact, times)) return true;
  }
  return false;
}

/// Whether `times` the contact's normal is a sum of rows, residual_ of each to the nearest integer.
template <class Scalar>
inline bool Path<Scalar>::is_sum_of_rows(Count contact, Count times) const {
  const auto share_of = [&](Count r) { return static_cast<double>(residual_[r]) * static_cast<double>(times); };
  for (Count r = 0; r < kernel_.order(); ++r) {
    const double share = share_of(r);
    if (!(__builtin_fabs(share) <= proof::kLargestShare)) return false;
    const double off = share - static_cast<double>(proof::nearest_integer(share));
    if (!(__builtin_fabs(off) <= proof::kNearInteger)) return false;
  }
  for (Count i = 0; i < contacts_.ngc(); ++i) {
    double sum = 0;
    if (!proof::add_exactly(sum, contacts_.impulse_column(contact)[i], -times)) return false;
    for (Count r = 0; r < kernel_.order(); ++r) {
      const Label label = kernel_.row_label(r);
      const Count share = proof::nearest_integer(share_of(r));
      if (label.is_normal()) {
        if (!proof::add_exactly(sum, contacts_.impulse_column(label.contact)[i], share)) return false;
        continue;
      }
      const Count first = contacts_.nc() + contacts_.first_direction(label.contact);
      const Count directions[] = {label.direction, friction_.base(label.contact)};
      for (const Count direction : directions) {
        if (direction == contacts_.edges(label.contact)) continue;
        const double entry = contacts_.impulse_column(first + direction)[i];
        if (!proof::add_exactly(sum, entry, direction == label.direction ? share : -share)) return false;
      }
    }
    if (sum != 0) return false;
  }
  return true;
}

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
