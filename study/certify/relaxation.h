#pragma once

#include <vector>

#include "core/lcp.h"
#include "core/types.h"
#include "study/certify/deadline.h"

namespace lcpbench::exact {

/// The linear relaxation of an LCP: w = q + M z >= 0 and z >= 0, with some entries imposed to be zero in place of
/// complementarity. It is solved in double, by the dual simplex method on a dense dictionary. The result is a guess and
/// no proof: where rounding misled it, even entries that are not finite. O(n^2) a pivot; an object is O(n^2) to copy.
///
/// Variables: w_i is i, z_i is n + i.
class Relaxation {
 public:
  enum class Ending { kFeasible, kInfeasible, kStuck };

  /// @param lcp of at least one row, with finite entries
  explicit Relaxation(const Lcp& lcp);

  Index size() const { return static_cast<Index>(nonbasic_.size()); }

  /// From now on the variable is zero.
  void impose(Index variable) { imposed_[static_cast<std::size_t>(variable)] = true; }

  /// Looks for a vertex with the least sum of z, with weights from 1 to 1.36 against ties, in units that even out the
  /// entries of M. Goes on from the dictionary of the last solve.
  /// @returns kFeasible: found. kInfeasible: a row contradicts the inequalities. kStuck: too many pivots, or the
  /// deadline passed.
  Ending solve(const Deadline& deadline);

  /// After kFeasible: the vertex, in the units of the problem.
  Vector z() const;
  Vector w() const;

  /// After kInfeasible: y with q'y < 0, y_i >= 0 where w_i is not imposed to be zero, and (M'y)_j <= 0 where z_j is
  /// not. The largest entry is 1 in size.
  Vector contradiction() const;

  /// After kInfeasible, for y = contradiction(): the j with (M'y)_j = 0, but for rounding, because z_j is basic and its
  /// row is not the contradicting one. In no particular order.
  std::vector<Index> tight_columns() const;

  /// After kInfeasible: another y, with (M'y)_j < 0 in those tight columns whose rows allow it, each by itself, so that
  /// y can be rounded. Columns whose z_j is imposed to be zero need no room.
  Vector contradiction_with_room() const;

 private:
  void pivot(Index row, Index column);
  bool is_imposed(Index variable) const { return imposed_[static_cast<std::size_t>(variable)]; }
  Vector contradiction(double epsilon, const Eigen::RowVectorXd& slope) const;
  bool has_room(Index row) const;
  double room(const Eigen::RowVectorXd& slope, double constant) const;

  Vector row_unit_;     // w = row_unit times the dictionary's w
  Vector column_unit_;  // z = column_unit times the dictionary's z
  Matrix A_;            // basic = b + A nonbasic
  Vector b_;
  Vector cost_;  // of the nonbasic variables, >= 0 but for imposed ones
  std::vector<Index> basic_;
  std::vector<Index> nonbasic_;
  std::vector<char> imposed_;
  Index contradicting_row_ = -1;
  double side_ = 1;  // +1: the contradicting row's variable is too small; -1: imposed to be zero and too large
};

}  // namespace lcpbench::exact
