#pragma once

// Not Drake: classes with the functions that examples/drake calls, under the same names and signatures, so that the
// example is compiled and run where there is no Drake. They sweep over the unknowns, which solves LCPs of symmetric
// positive definite M.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace drake {

template <class T>
using MatrixX = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>;
template <class T>
using VectorX = Eigen::Matrix<T, Eigen::Dynamic, 1>;

namespace solvers {

/// False where z does not come in empty: Drake would take it for a start.
template <class T>
bool sweep_stand_in(const MatrixX<T>& M, const VectorX<T>& q, VectorX<T>* z, int* sweeps) {
  if (z->size() != 0) return false;
  z->setZero(q.size());
  for (*sweeps = 1; *sweeps < 100000; ++*sweeps) {
    T change = 0;
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const T next = std::max((*z)(i) - (M.row(i).dot(*z) + q(i)) / M(i, i), T(0));
      change = std::max(change, std::abs(next - (*z)(i)));
      (*z)(i) = next;
    }
    if (change <= T(1e-14) * z->template lpNorm<Eigen::Infinity>()) return true;
  }
  return false;
}

template <class T>
class MobyLCPSolver {
 public:
  bool SolveLcpFast(const MatrixX<T>& M, const VectorX<T>& q, VectorX<T>* z, const T& = T(-1)) const {
    return sweep_stand_in(M, q, z, &pivots_);
  }
  bool SolveLcpLemke(const MatrixX<T>& M, const VectorX<T>& q, VectorX<T>* z, const T& = T(-1),
                     const T& = T(-1)) const {
    return sweep_stand_in(M, q, z, &pivots_);
  }
  bool SolveLcpLemkeRegularized(const MatrixX<T>& M, const VectorX<T>& q, VectorX<T>* z, int = -20, unsigned = 1,
                                int = 1, const T& = T(-1), const T& = T(-1)) const {
    return sweep_stand_in(M, q, z, &pivots_);
  }
  int get_num_pivots() const { return pivots_; }

 private:
  mutable int pivots_ = 0;
};

}  // namespace solvers
}  // namespace drake
