#pragma once

// Shared by the Bullet adapters that go through btMLCPSolverInterface.

#include <BulletDynamics/MLCPSolvers/btMLCPSolverInterface.h>

#include "core/lcp.h"

namespace lcpbench {

static_assert(sizeof(btScalar) == sizeof(double), "needs Bullet's float64 build");

/// An LCP in the form of Bullet's solvers of boxed problems: A x = b + w with A = M, b = -q and 0 <= x <= upper. In
/// this form a bound may depend on another unknown, as that of friction does; here none does.
class BulletMlcp {
 public:
  void load(const Lcp& lcp, double upper) {
    const int n = static_cast<int>(lcp.size());
    A_.resize(n, n);
    for (btVectorXu* vector : {&b_, &lower_, &upper_}) vector->resize(n);
    limit_dependency_.resize(0);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) A_.setElem(i, j, lcp.M(i, j));
      b_[i] = -lcp.q(i);
      lower_[i] = 0;
      upper_[i] = upper;
      limit_dependency_.push_back(-1);  // on no other unknown
    }
  }

  /// @param z  n: the start on entry, x on return
  /// @returns what the solver returns: its claim
  bool solve(btMLCPSolverInterface& solver, int iterations, Vector& z) {
    const int n = b_.rows();
    btVectorXu x(n);
    for (int i = 0; i < n; ++i) x[i] = z(i);
    const bool claim = solver.solveMLCP(A_, b_, x, lower_, upper_, limit_dependency_, iterations);
    for (int i = 0; i < n; ++i) z(i) = x[i];
    return claim;
  }

 private:
  btMatrixXu A_;
  btVectorXu b_;
  btVectorXu lower_;
  btVectorXu upper_;
  btAlignedObjectArray<int> limit_dependency_;
};

}  // namespace lcpbench
