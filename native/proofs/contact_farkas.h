#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "core/contact_problem.h"
#include "native/proofs/farkas_support.h"

namespace lcpbench {

/// Whether the inertia is given in a form that may be singular: by factors or as G*.
bool may_be_singular(const ContactProblem& contact);

/// Whether ContactFarkas may find a proof that there is no solution: some contact has no compliance, and the inertia
/// may be singular or an offset b is negative. Without such a proof tangential offsets, too, may leave no solution.
bool may_be_unsolvable(const ContactProblem& contact);

/// Looks for a proof that contacts have no solution.
///
/// Impulses change the velocity within the range of X only (G = X diag(alpha) X'; X = G* where that is given, I where G
/// is). So there is no solution if some u >= 0, zero for contacts with compliance, has X'N u = 0 and (N'v + b)'u < 0:
/// no impulse changes (N'v+ + b)'u. Without friction there is either a solution or such a u. [Farkas 1902]
///
/// The simplex method in double solves the linear program min (N'v + b)'u, X'N u = 0, sum u = 1, u >= 0. If at most 64
/// contacts have u > 0 in its solution, FarkasSupport looks for a u of these contacts without rounding. A u is missed
/// where rounding in double leads to other contacts.
class ContactFarkas {
 public:
  /// Makes room for this problem and all with no more factors and contacts. Allocates.
  void reserve(const ContactProblem& contact);

  /// Allocates where room is missing. @param contact  kept by reference: only its v may change until the next load()
  void load(const ContactProblem& contact);

  /// Whether a proof is found. O(factors (factors + contacts)) per step of the simplex method, and usually about
  /// factors + contacts steps; the exact proof allocates. @pre load()
  /// @param v  velocity before the impact (ngc), in place of the v of load()
  /// @param deadline_s  on wall_clock_s(): false after it. The exact proof is not interrupted.
  bool proves_unsolvable(const double* v, double deadline_s);

  /// The u (nc) of the last proof, up to a factor, rounded to doubles. @pre proves_unsolvable() was true
  void write_proof(Eigen::Ref<Vector> u) const { farkas_support_.write_proof(u); }

 private:
  double* row(Index r) const { return tableau_.get() + r * width(); }
  double* costs() const { return row(rows_); }
  /// Column of the right-hand sides.
  Index right() const { return count() + rows_; }
  Index width() const { return right() + 1; }
  Index count() const { return static_cast<Index>(normals_.size()); }

  void fill();
  void start_second_phase(const double* v);
  bool pivot_to_end(double deadline_s);
  void drop_artificial();
  void exchange(Index leaving, Index entering);
  bool take_support();

  const ContactProblem* contact_ = nullptr;
  std::optional<FarkasSupport::ConstMatrixMap> X_;   // none: I
  Index rows_ = 0;                                   // one for each column of X, and sum u = 1
  std::vector<Index> normals_;                       // contacts without compliance
  std::vector<int> row_exponent_, column_exponent_;  // powers of two that bring entries to about one
  /// By rows: the equations, with an artificial variable each, the right-hand side last; below them the reduced costs.
  std::unique_ptr<double[]> tableau_;
  std::size_t room_ = 0;
  std::vector<Index> basis_;    // by row: an index into normals_; from count() on, count() + row of an artificial one
  std::vector<Index> support_;  // contacts
  FarkasSupport farkas_support_;
};

}  // namespace lcpbench
