#pragma once

#include "native/answer_test/contact_solvability.h"

namespace lcpbench {

/// Of a scaled tableau: what counts as rounding, and what is more than any rounding.
template <class Scalar>
constexpr Scalar kNoise = Scalar(sizeof(Scalar) == sizeof(double) ? 1e-11 : 0x1p-98);
template <class Scalar>
constexpr Scalar kClear = Scalar(sizeof(Scalar) == sizeof(double) ? 1e-7 : 0x1p-92);

/// The equations X'K u = 0 and sum u = 1 with an artificial variable each, the right-hand side last; below them the
/// reduced costs.
template <class Scalar>
struct ContactSolvability::Program {
  Scalar* entries = nullptr;
  Index rows = 0;
  Index edges = 0;
  bool first_phase = true;

  Index right() const { return edges + rows; }
  Index width() const { return edges + rows + 1; }
  Scalar* row(Index r) const { return entries + r * width(); }
  Scalar* costs() const { return row(rows); }
  Scalar value() const { return -costs()[right()]; }

  void exchange(Index r, Index entering) const {
    Scalar* const pivot_row = row(r);
    const Scalar inverse = 1 / pivot_row[entering];
    for (Index j = 0; j < width(); ++j) pivot_row[j] *= inverse;
    pivot_row[entering] = 1;
    for (Index i = 0; i <= rows; ++i) {
      Scalar* const other = row(i);
      const Scalar factor = other[entering];
      if (i == r || factor == 0) continue;
      for (Index j = 0; j < width(); ++j) other[j] -= factor * pivot_row[j];
      other[entering] = 0;
    }
  }
};

}  // namespace lcpbench
