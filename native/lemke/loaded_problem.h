#pragma once

#include "native/kernels/pack.h"
#include "native/lemke/matrix_columns.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// What all bases keep: M, q, the covering vector, and where each variable stands.
struct LoadedProblem {
  MatrixColumns M;
  Buffer<double> q;
  Buffer<Count> slot_of;  ///< of each of the 2 n + 1 variables; meaningful while it is basic

  Count n() const { return M.n(); }
  Count artificial() const { return 2 * M.n(); }

  void load(const Input& input) {
    M.load(input);
    q.resize(input.n);
    for (Count i = 0; i < input.n; ++i) q[i] = input.q[i];
    slot_of.fill(2 * n() + 1, -1);
  }

  /// Whether w = q is nonnegative to the tolerance at z = 0.
  bool zero_solves(double zero_tolerance) const {
    for (Count i = 0; i < n(); ++i) {
      if (!(q[i] >= 0 || q[i] > -zero_tolerance)) return false;
    }
    return true;
  }

  Count most_negative_row() const {
    Count row = 0;
    for (Count i = 1; i < n(); ++i) {
      if (q[i] < q[row]) row = i;
    }
    return row;
  }

  double cover(Count row) const { return q[row] < 0 ? 1 : 0; }
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
