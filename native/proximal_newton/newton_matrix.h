#pragma once

#include <Eigen/SparseLU>
#include <vector>

#include "core/contact_problem.h"
#include "native/cone_ipm/dense_lu.h"
#include "native/proximal_newton/contact_rows.h"

namespace lcpbench {

/// G + sum of J_i' slope_i J_i over contacts i, and its LU factors. Sparse, unless a third of its entries may be
/// nonzero.
class NewtonMatrix {
 public:
  /// Finds the places of all entries, and an order of elimination. @pre G is given, or has factors
  /// @param rows of each contact; must outlive the factors
  void load(const Inertia& inertia, const std::vector<ContactRows>& rows);

  const SparseMatrix& G() const { return G_; }

  /// Cost: that of the pairs of coordinates that each contact moves, and of the elimination. Allocates if sparse.
  /// @param slopes 3 x 3, one for each contact; a zero first entry stands for a zero matrix
  /// @returns whether every pivot was found
  bool factor(const std::vector<Eigen::Matrix3d>& slopes);
  /// x := its inverse times x. @pre factor() was true
  void solve(Vector& x);

  /// Multiplications of the last factor(), about.
  double work() const { return work_; }

 private:
  /// Approximate minimum degree of the symmetric pattern. Eigen's own has the inverse of the permutation that SparseLU
  /// expects.
  struct SymmetricOrdering {
    using PermutationType = Eigen::AMDOrdering<int>::PermutationType;
    void operator()(const SparseMatrix& A, PermutationType& permutation) {
      Eigen::AMDOrdering<int>()(A, permutation);
      permutation = permutation.inverse().eval();
    }
  };

  const std::vector<ContactRows>* rows_ = nullptr;
  SparseMatrix G_, matrix_;
  Vector inertia_;  // G in the places of matrix_
  std::vector<std::vector<int>> places_;  // of the pairs of coordinates, by columns, of contacts that move the same
  std::vector<std::size_t> places_of_;    // each contact's
  Eigen::SparseLU<SparseMatrix, SymmetricOrdering> sparse_;
  DenseLu dense_;
  bool is_dense_ = false;
  double work_ = 0;
};

}  // namespace lcpbench
