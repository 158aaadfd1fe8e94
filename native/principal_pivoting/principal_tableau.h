#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/lcp.h"

namespace lcpbench {

/// The tableau of LCP(q, M) after principal pivots: basic = constants() + matrix() nonbasic, where for each i one of
/// z_i and w_i is basic, the other nonbasic.
///
/// Pivots update the whole tableau in O(n^2). Rounding errors grow with them, so rebuild() recomputes it from the data,
/// in an order that is chosen for small errors. Nothing allocates after load(). Vectors that are written must have n
/// entries already.
/// [Cottle, Pang, Stone 1992, section 2.3: principal pivotal transforms]
class PrincipalTableau {
 public:
  void load(Lcp lcp);

  /// Back to the data: every w is basic.
  void reset();

  Index size() const { return lcp_.size(); }
  const Lcp& lcp() const { return lcp_; }
  /// max|q| of the data; 0 for n = 0.
  double largest_q() const { return lcp_.size() > 0 ? lcp_.q.cwiseAbs().maxCoeff() : 0.0; }
  const Matrix& matrix() const { return M_; }
  const Vector& constants() const { return q_; }
  bool z_is_basic(Index i) const { return z_is_basic_[static_cast<std::size_t>(i)]; }
  /// Calls of pivot() since load(), reset() or rebuild().
  Index pivots_since_rebuild() const { return pivots_since_rebuild_; }

  /// Exchanges z_i and w_i. @pre M_ii != 0.
  void pivot(Index i) { exchange<1>({i}); }
  /// Exchanges both pairs. @pre the determinant of the principal block of i and j is not 0.
  void pivot(Index i, Index j) { exchange<2>({i, j}); }
  double determinant(Index i, Index j) const { return M_(i, i) * M_(j, j) - M_(i, j) * M_(j, i); }

  /// Recomputes the tableau of the present basis from the data, with 1 x 1 and 2 x 2 pivots chosen for size as by Bunch
  /// and Parlett. O(n^2) per basic z. False where the basis is singular (the tableau is then that of another basis), or
  /// the tableau is not finite.
  bool rebuild();

  /// Bounds on the errors of the constants, to first order, when the data have relative errors of `relative`: the sign
  /// of a constant within its bound is not known. O(n^2).
  void constant_errors(double relative, Vector& bounds);
  /// The same for the entries of column j: an entry within its bound may be 0. O(n^2).
  void column_errors(Index j, double relative, Vector& bounds);
  /// Whether the diagonal entry of column j stays positive under relative errors of `relative` of the data. With x the
  /// change of z per unit of the column's variable it is x'M x, computed here from the data: where it is zero, as for
  /// skew M, the entry in the tableau is rounding alone. O(n^2).
  bool gains(Index j, double relative);

  /// The basic solution: z_i = 0 where it is nonbasic, else its constant after two steps of iterative refinement on the
  /// data. Negative entries become 0. O(n^2).
  void solution(Vector& z);

 private:
  template <std::size_t K>
  void exchange(const std::array<Index, K>& pairs);
  bool pivot_largest();
  void errors_of_solve(const Eigen::Ref<const Vector>& solution, double relative, Vector& bounds);

  Lcp lcp_;
  Matrix M_;  // n x n
  Vector q_;  // n
  std::vector<char> z_is_basic_;
  Index pivots_since_rebuild_ = 0;
  Matrix rows_, columns_;  // 2 x n and n x 2: scratch of an exchange
  std::vector<char> wanted_;
  Vector work_, magnitude_;  // n
};

}  // namespace lcpbench
