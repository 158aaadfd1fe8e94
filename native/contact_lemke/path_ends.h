#pragma once

#include "native/contact_lemke/path.h"

// The end of a path: the impulses of its last basis, in double.

namespace lcpbench::lemke::LCPBENCH_LEVEL {

template <class Scalar>
inline auto Path<Scalar>::finish(double* z) -> Ending {
  if (!compute_values()) return Ending::kBreakdown;
  refine();
  Scalar poison = 0;  // stays 0 unless an impulse is NaN or infinite
  for (Count j = 0; j < kernel_.order(); ++j) poison += Scalar(0) * x_[j];
  if (!(poison == 0)) return Ending::kBreakdown;
  const Scalar* impulses = x_.data();
  if constexpr (kRoundsShares) {
    if (round_impulses(coefficients_.data())) impulses = coefficients_.data();
  }
  write_impulses(impulses, z);
  return Ending::kSolved;
}

/// rounded := the impulses of the kernel's columns as doubles, 0 for those that are not positive. They are rounded in
/// turn, and each makes up for the rounding of those before (see RoundedShares), so that the velocities hardly change.
/// Nearly dependent contacts may have impulses of 1e12 N s that cancel: rounding each by itself changes velocities.
/// @returns false where there are no factors of G*, or the columns are dependent: then `rounded` is of no use
template <class Scalar>
inline bool Path<Scalar>::round_impulses(Scalar* rounded) {
  if (!response_.has_factors()) return false;
  const auto is_rounded = [this](Count j) { return j != artificial_ && x_[j] > 0; };
  shares_.clear();
  for (Count j = 0; j < kernel_.order(); ++j) {
    rounded[j] = 0;
    if (!is_rounded(j)) continue;
    Scalar* const to = shares_.next_column();
    if (to == nullptr) return false;  // more columns than coordinates: they are dependent
    load_column(kernel_.column_label(j));
    response_.whiten(column_.data(), to);
    for (Count i = contacts_.padded_ngc(); i < contacts_.extent(); ++i) {
      to[i] = square_root(contacts_.compliance()[i - contacts_.padded_ngc()]) * column_[i];
    }
    scale(to, x_[j], contacts_.extent());
  }
  return shares_.round([&](Count column, Scalar share) {
    Count j = 0;  // the kernel's column that is number `column` among the rounded ones
    for (;; ++j) {
      if (is_rounded(j) && column-- == 0) break;
    }
    const double value = static_cast<double>(share * x_[j]);
    rounded[j] = value > 0 ? Scalar(value) : Scalar(0);
    return rounded[j] / x_[j];
  });
}

/// Writes impulses of the kernel's columns to z, negative ones as 0. The impulse of each contact's base, which is no
/// column, is what the others leave of mu f_N.
template <class Scalar>
inline void Path<Scalar>::write_impulses(const Scalar* impulses, double* z) const {
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
      if (label.contact == c && impulses[j] > 0) rest += simplex_weight(label) * impulses[j];
    }
    write_friction(Label{c, friction_.base(c)}, rest > 0 ? rest : Scalar(0), z);
  }
}

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
