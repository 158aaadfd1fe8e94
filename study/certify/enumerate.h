#pragma once

#include <vector>

#include "study/certify/certificate.h"
#include "study/certify/exact_lemke.h"

namespace lcpbench::exact {

enum class EnumerationEnding {
  kSolution,
  kNone,  ///< every complementary cone was excluded: the problem has no solution
  kTimeLimit,
};

struct EnumerationOutcome {
  EnumerationEnding ending = EnumerationEnding::kTimeLimit;
  IntegerVector z;  ///< kSolution: times the denominator
  Integer denominator{1};
  std::vector<ProofNode> proof;  ///< kNone, where it was asked for
};

/// Looks for z >= 0, w = q + M z >= 0, z'w = 0 in all 2^n complementary cones, by branch and bound: at each node some
/// pairs have z_i = 0 or w_i = 0 imposed, and the node is cut when the linear inequalities left over have no solution,
/// which a checked contradiction of them proves. Any M, singular bases too. Up to 2^n exact linear programs of 2 n
/// rows.
/// @param w_exponent  w_i of the problem is 2^w_exponent[i] times that of the LCP, up to a common factor; empty: no proof
///   is asked for
EnumerationOutcome enumerate_cones(const IntegerLcp& lcp, const std::vector<slong>& w_exponent,
                                   const Deadline& deadline);

enum class Feasibility { kFeasible, kInfeasible, kUnknown };

struct FeasibilityOutcome {
  Feasibility feasibility = Feasibility::kUnknown;
  IntegerVector point;  ///< kFeasible: z, times the denominator; kInfeasible: y >= 0, A'y <= 0, b'y < 0
  Integer denominator{1};
};

/// Whether some z >= 0 has A z + b >= 0: Lemke's method on the monotone LCP of [0 -A'; A 0]. The contradiction is
/// checked by multiplication. kUnknown when the deadline passed.
FeasibilityOutcome feasible_point(const IntegerMatrix& A, const IntegerVector& b, const Deadline& deadline);

}  // namespace lcpbench::exact
