#pragma once

#include "native/kernels/pack.h"
#include "native/lemke/matrix_columns.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// What all bases keep: M, q, the covering vector, and where each variable stands.
struct LoadedProblem {
  MatrixColumns M;
  Buffer<double> q;
  Buffer<Count> slot_of;  ///< of each of the 2 n + 1 variables; meaningful while it is basic
  Buffer<double> cover;   ///< n: the covering vector

  Count n() const { return M.n(); }
  Count artificial() const { return 2 * M.n(); }

  void load(const Input& input) {
    M.load(input);
    q.resize(input.n);
    for (Count i = 0; i < input.n; ++i) q[i] = input.q[i];
    slot_of.fill(2 * n() + 1, -1);
    cover.resize(input.n);
    for (Count i = 0; i < input.n; ++i) cover[i] = input.covers_all && i < input.dense ? generic(i) : q[i] < 0 ? 1 : 0;
  }

  /// Whether w = q is nonnegative to the tolerance at z = 0.
  bool zero_solves(double zero_tolerance) const {
    for (Count i = 0; i < n(); ++i) {
      if (!(q[i] >= 0 || q[i] > -zero_tolerance)) return false;
    }
    return true;
  }

  /// The row that q + cover z0 >= 0 makes wait longest as z0 grows.
  Count last_to_be_covered() const {
    Count last = 0;
    for (Count i = 1; i < n(); ++i) {
      if (needed(i) > needed(last)) last = i;
    }
    return last;
  }

  /// The z0 with which q + cover z0 is nonnegative in that row.
  double needed(Count row) const { return q[row] < 0 ? -q[row] / cover[row] : 0; }

 private:
  /// Different numbers from 1 to 2: rows do not tie because their q are equal.
  static double generic(Count row) {
    const double turns = 0.6180339887498949 * static_cast<double>(row + 1);
    return 1 + turns - static_cast<double>(static_cast<Count>(turns));
  }
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
