#pragma once

#include "native/contact_lemke/path.h"

// What a path ends in: the impulses of its last basis.

namespace lcpbench::lemke::LCPBENCH_LEVEL {

template <class Scalar>
inline auto Path<Scalar>::finish(double* z) -> Ending {
  if (!compute_values()) return Ending::kBreakdown;
  refine();
  Scalar poison = 0;
  for (Count j = 0; j < kernel_.order(); ++j) poison += Scalar(0) * x_[j];
  if (!(poison == 0)) return Ending::kBreakdown;
  const Scalar* impulses = x_.data();
  if constexpr (kRoundsShares) {
    if (round_impulses(coefficients_.data())) impulses = coefficients_.data();
  }
  write_impulses(impulses, z);
  return Ending::kSolved;
}

/// The impulses of the kernel as doubles, each rounded so that the others can make up for it. Where contacts nearly
/// depend on each other, impulses of 1e12 N s may leave a velocity of zero, and rounding each for itself moves it.
template <class Scalar>
inline bool Path<Scalar>::round_impulses(Scalar* rounded) {
  if (!response_.has_factors()) return false;
  const auto counts = [this](Count j) { return j != artificial_ && x_[j] > 0; };
  shares_.clear();
  for (Count j = 0; j < kernel_.order(); ++j) {
    rounded[j] = 0;
    if (!counts(j)) continue;
    Scalar* const to = shares_.next_column();
    if (to == nullptr) return false;
    load_column(kernel_.column_label(j));
    response_.whiten(column_.data(), to);
    for (Count i = contacts_.padded_ngc(); i < contacts_.extent(); ++i) {
      to[i] = square_root(contacts_.compliance()[i - contacts_.padded_ngc()]) * column_[i];
    }
    scale(to, x_[j], contacts_.extent());
  }
  return shares_.round([&](Count column, Scalar share) {
    Count j = 0;
    for (;; ++j) {
      if (counts(j) && column-- == 0) break;
    }
    const double value = static_cast<double>(share * x_[j]);
    rounded[j] = value > 0 ? Scalar(value) : Scalar(0);
    return rounded[j] / x_[j];
  });
}

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
