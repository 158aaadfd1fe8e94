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
  write_impulses(z);
  return Ending::kSolved;
}

/// Writes the impulses of the kernel's columns to z, negative ones as 0. The impulse of each contact's base, which is no
/// column, is what the others leave of mu f_N.
template <class Scalar>
inline void Path<Scalar>::write_impulses(double* z) const {
  for (Count j = 0; j < kernel_.order(); ++j) {
    const Label label = kernel_.column_label(j);
    if (label.contact == kArtificial) continue;
    const Scalar value = x_[j] > 0 ? x_[j] : Scalar(0);
    if (label.is_normal()) z[label.contact] = static_cast<double>(value);
    if (!label.is_normal()) write_friction(label, value, z);
  }
  for (Count k = 0; k < friction_.count(); ++k) {
    const Count c = friction_.contact(k);
    Scalar rest = 0;
    for (Count j = 0; j < kernel_.order(); ++j) {
      const Label label = kernel_.column_label(j);
      if (label.contact == c && x_[j] > 0) rest += simplex_weight(label) * x_[j];
    }
    write_friction(Label{c, friction_.base(c)}, rest > 0 ? rest : Scalar(0), z);
  }
}

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
