#pragma once

#include <vector>

#include "core/contact_problem.h"
#include "core/quad.h"

namespace lcpbench {

/// Proves that contacts have no solution: that some u, positive for the given normals and zero for all others, has
/// X'N u = 0 and (N'v + b)'u < 0, for the data as they are.
///
/// With A = X'N of the given normals, independent rows of A, one fewer than normals, and sum u = 1 are a square system.
/// It is solved without any rounding: the other rows depend on these, and vanish at that solution too.
class FarkasSupport {
 public:
  using ConstMatrixMap = Eigen::Map<const Matrix>;

  /// Allocates. False where there is no such u, and where it is not found.
  /// @param X of G = X diag(alpha) X' with alpha > 0, or G*, or G (ngc rows). Null: I @param v ngc entries
  bool proves_unsolvable(const ContactProblem& contact, const ConstMatrixMap* X, const double* v,
                         const std::vector<Index>& normals);

  /// u (nc) := what the last proves_unsolvable() proved, rounded: small integers where there are such in the same
  /// proportion. @pre it was true
  void write_proof(Eigen::Ref<Vector> u) const;

 private:
  std::vector<Index> normals_;
  std::vector<Quad> ratios_;  ///< of the last proof: u of each normal over the least
};

}  // namespace lcpbench
