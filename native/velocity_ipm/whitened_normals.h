#pragma once

#include <memory>

#include "core/contact_problem.h"
#include "native/velocity_ipm/coupled_compliance.h"
#include "native/velocity_ipm/settings.h"
#include "native/velocity_ipm/sparse_factorization.h"

namespace lcpbench {

/// The contact normals in coordinates in which the inertia is the identity: W with W'W = N'G*N, and what an
/// interior-point method needs of it. A velocity there, y, stands for the change u - v = S y, with S S' = G*.
class WhitenedNormals {
 public:
  virtual ~WhitenedNormals() = default;

  virtual Index coordinates() const = 0;
  /// Of each column of W: the diagonal of N'G*N, without compliance.
  virtual Vector squared_norms() const = 0;
  /// y = W f.
  virtual void combine(const Vector& f, Vector& y) const = 0;
  /// s = W'y.
  virtual void project(const Vector& y, Vector& s) const = 0;
  /// Factors I + W diag(weights) W', weights >= 0. False when the factorization breaks down.
  virtual bool factor(const Vector& weights) = 0;
  /// Factors I + (W K)(W K)' in its place, with the weights K K' that `coupled` has factored. @pre loaded with it
  virtual bool factor_coupled(const CoupledCompliance& coupled) = 0;
  /// y := (I + W diag(weights) W')^-1 y, of the last factorization.
  virtual void solve(Vector& y) const = 0;
  /// Multiplications, see BudgetedSolver::work().
  struct Cost {
    double product = 0;  ///< combine() or project(), with the vector operations that go with it
    double factor = 0;
    double solve = 0;
  };
  virtual Cost cost() const = 0;
};

/// S with S S' = G* to rounding, and ngc rows. O(ngc^3)
///
/// The inverse of G's Cholesky factor, upper triangular, if the factorization succeeds in double; rounding may let it
/// succeed for a singular G with ngc factors or more. Else, and for a given G* or fewer factors, one column for each
/// eigenvector whose eigenvalue exceeds ngc eps times the largest in size.
Matrix inverse_root(const Inertia& inertia);

/// Dense Cholesky: O(ngc^2 (nc + ngc)) per factorization. Any inertia; of a singular one the range, as inverse_root()
/// finds it.
std::unique_ptr<WhitenedNormals> dense_whitened_normals(const ContactProblem& problem);

/// Sparse Cholesky by `factorization`, analysed once, its rows in the order of elimination_order(). nullptr unless the
/// inertia comes in positive definite blocks.
/// @param coupled  what factor_coupled() will be called with, if it will
std::unique_ptr<WhitenedNormals> sparse_whitened_normals(const ContactProblem& problem,
                                                         std::unique_ptr<SparseFactorization> factorization,
                                                         const CoupledCompliance& coupled = {});

/// Whether the Newton matrix is factored as a sparse one: with a sparse N and an inertia of blocks, as every scene has.
bool suits_sparse_algebra(const ContactProblem& problem);

}  // namespace lcpbench
