#pragma once

#include "native/kernels/pack.h"
#include "native/lemke/exact_data.h"
#include "native/lemke/matrix_columns.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// What all bases keep: q, the covering vector, and where each variable stands.
template <class Scalar>
struct LoadedProblem {
  MatrixColumns<Scalar> M;
  Buffer<Scalar> q;
  Buffer<Count> slot_of;  ///< of each of the 2 n + 1 variables; meaningful while it is basic

  Count n() const { return M.n(); }
  Count artificial() const { return 2 * M.n(); }

  void load(const Input& input) {
    M.load(input);
    load_constants(input, q);
    slot_of.fill(2 * n() + 1, -1);
  }

  bool zero_solves(Scalar zero_tolerance) const {
    for (Count i = 0; i < n(); ++i) {
      if (!(q[i] > -zero_tolerance)) return false;
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

  Scalar cover(Count row) const { return q[row] < 0 ? Scalar(1) : Scalar(0); }
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
