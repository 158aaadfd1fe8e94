#pragma once

#include <vector>

#include "core/contact_problem.h"
#include "core/quad.h"

namespace lcpbench {

/// Shows in 113 bits that contacts have no solution: that some u, positive for the given normals and zero for all
/// others, has X'N u = 0 and (N'v + b)'u < 0. u is found by elimination of A = X'N of these normals, whose rank has to
/// be one less than their number, with a visible gap. What is proven exactly is decided by the doubles that
/// write_proof() makes of u: see core/answer/farkas.h.
class FarkasSupport {
 public:
  using ConstMatrixMap = Eigen::Map<const Matrix>;

  /// Allocates. False where there is no such u, and where 113 bits do not show it.
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
