#pragma once

// Not Drake: see moby_lcp_solver.h beside this file.

#include <drake/solvers/moby_lcp_solver.h>

namespace drake::solvers {

template <class T>
class UnrevisedLemkeSolver {
 public:
  bool SolveLcpLemke(const MatrixX<T>& M, const VectorX<T>& q, VectorX<T>* z, int* num_pivots, const T& = T(-1)) const {
    return sweep_stand_in(M, q, z, num_pivots);
  }
};

}  // namespace drake::solvers
