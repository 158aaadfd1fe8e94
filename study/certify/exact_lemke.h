#pragma once

#include "study/certify/exact_problem.h"

namespace lcpbench::exact {

enum class LemkeEnding {
  kSolution,
  kRay,
  kGaveUp,  ///< the deadline passed, the integers need too much memory, or the equations of the basis are singular
};

struct LemkeOutcome {
  LemkeEnding ending = LemkeEnding::kGaveUp;
  /// kSolution: a point at which z_i = 0 but for the basis and the kept rows, w_i = 0 on the basis, and the kept rows
  /// are complementary; kRay: the n z-parts of the ray's direction, 0 but for the kept rows
  IntegerMatrix x{};
};

/// Lemke's method with a covering vector of ones and the lexicographic ratio test, in integers, on the LCP that is left
/// in the z of `kept` where w_i = 0 for i in `basis` and z_i = 0 for all others. Entries of the basis that depend on
/// those before are kept rather. Every entry of the tableau is a minor of the data, so the divisions are exact. Finite.
/// If M is positive semidefinite, it ends with a solution, or with a ray, which proves that there is none. For other M
/// a ray need not prove anything. [Cottle, Pang, Stone 1992, sections 4.4 and 4.9; Edmonds 1967 for the pivots]
/// |kept|^2 exact operations a pivot, on integers of up to n + k times the length of the system's.
LemkeOutcome exact_lemke(const ExactSystem& system, const std::vector<Index>& basis, std::vector<Index> kept,
                         const Deadline& deadline);

}  // namespace lcpbench::exact
