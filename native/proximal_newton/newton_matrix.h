#pragma once

#include <memory>
#include <vector>

#include "core/contact_problem.h"
#include "native/proximal_newton/contact_rows.h"
#include "native/velocity_ipm/sparse_factorization.h"

namespace lcpbench {

/// weight G + sum of J_i' slope_i J_i over contacts i, and its LU factors.
class NewtonMatrix {
 public:
  /// Finds the places of all entries, and an order of elimination. @pre G is given, or has factors
  /// @param rows of each contact; must outlive the factors
  void load(const Inertia& inertia, const std::vector<ContactRows>& rows);

  const SparseMatrix& G() const { return G_; }

  /// Cost: that of the pairs of coordinates that each contact moves, and of the elimination. Does not allocate.
  /// @param slopes 3 x 3, one for each contact; a zero first entry stands for a zero matrix
  /// @returns whether every pivot was found
  bool factor(const std::vector<Eigen::Matrix3d>& slopes, double weight = 1);
  /// x := its inverse times x. @pre factor() was true
  void solve(Vector& x);

  /// Of the last factor(), see BudgetedSolver::work().
  double work() const { return work_; }

 private:
  const std::vector<ContactRows>* rows_ = nullptr;
  SparseMatrix G_;
  std::vector<int> position_;      // of each coordinate in the order of elimination
  std::vector<double> G_entries_;  // in the places of entries_
  std::vector<double> entries_;    // of the lower triangle, and of that of the transpose
  std::vector<std::vector<int>> places_;  // of the pairs of coordinates, by columns, of contacts that move the same
  std::vector<std::size_t> places_of_;    // each contact's
  std::unique_ptr<UnsymmetricFactorization> factors_;
  Vector ordered_;
  double work_ = 0;
};

}  // namespace lcpbench
