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

/// Whether contacts may have no solution: their inertia may be singular, or an offset is negative.
bool may_be_unsolvable(const ContactProblem& contact);

/// Looks for a proof that contacts have no solution.
///
/// No impulse moves what X' (of G = X diag(alpha) X'; G* where that is given; I where G is given) maps to zero. So
/// there is no solution if some u >= 0 has X'N u = 0 and (N'v + b)'u < 0. Without friction there is either a solution
/// or such a u. [Farkas 1902]
///
/// The linear program min (N'v + b)'u, X'N u = 0, sum u = 1, u >= 0 is solved in double by the simplex method. That the
/// normals of its last basis have such a u is then proven for the data as they are (FarkasSupport), if they are at most
/// 64. Where double ends in another basis there may be such a u, and it is not found.
class ContactFarkas {
 public:
  /// Room for this problem and all that are not larger. Allocates.
  void reserve(const ContactProblem& contact);

  /// @param contact must stay as it is until the next load, v apart. Allocates where there is no room.
  void load(const ContactProblem& contact);

  /// O(factors (factors + contacts)) per step of the simplex method, and about factors + contacts steps; the exact
  /// proof allocates. @pre load() @param v velocity before the impact (ngc)
  /// @param deadline_s on wall_clock_s(): false after it; the exact proof is not interrupted
  bool proves_unsolvable(const double* v, double deadline_s);

  /// The u (nc) of the last proves_unsolvable() that was true, rounded to doubles.
  void write_proof(Eigen::Ref<Vector> u) const { farkas_support_.write_proof(u); }

 private:
  double* row(Index r) const { return tableau_.get() + r * width(); }
  double* costs() const { return row(rows_); }
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
  std::optional<FarkasSupport::ConstMatrixMap> X_;  // none: I
  Index rows_ = 0;                                  // one for each column of X, and sum u = 1
  std::vector<Index> normals_;                      // contacts that cannot yield
  std::vector<int> row_exponent_, column_exponent_;  // powers of two that bring entries to about one
  /// By rows: the equations, with an artificial variable each, the right-hand side last; below them the reduced costs.
  std::unique_ptr<double[]> tableau_;
  std::size_t room_ = 0;
  std::vector<Index> basis_;    // by row: a place in normals_, or their number + the row of an artificial variable
  std::vector<Index> support_;  // contacts
  FarkasSupport farkas_support_;
};

}  // namespace lcpbench
