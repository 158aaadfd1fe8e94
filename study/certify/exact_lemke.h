#pragma once

#include "study/certify/deadline.h"
#include "study/certify/exact_system.h"

namespace lcpbench::exact {

/// LCP(q, M) over the integers, or that of a reduced system: then M and q are the rational ones times the denominator.
struct IntegerLcp {
  IntegerMatrix M;
  IntegerVector q;
  Integer denominator{1};  ///< > 0; its power r - 1 divides every minor of [q M] of order r

  Index size() const { return static_cast<Index>(q.size()); }
};

enum class LemkeEnding {
  kSolution,
  kRay,
  kGaveUp,  ///< the deadline passed, or the integers need too much memory
};

struct LemkeOutcome {
  LemkeEnding ending = LemkeEnding::kGaveUp;
  IntegerVector z;         ///< kSolution: z times the denominator; kRay: the z-part of the ray's direction
  Integer denominator{1};  ///< > 0
};

/// Lemke's method with a covering vector of ones and the lexicographic ratio test, in integers: every tableau entry is
/// a minor of the data, so the divisions are exact. Finite. If M is positive semidefinite, it ends with a solution, or
/// with a ray, which proves that there is none. For other M a ray need not prove anything.
/// [Cottle, Pang, Stone 1992, sections 4.4 and 4.9; Edmonds 1967 for the pivots]
/// n^2 exact operations a pivot, on integers of up to n times the length of the data's; if k unknowns were eliminated
/// from a system to get a reduced one, of up to n + k times the length of the system's.
LemkeOutcome exact_lemke(const IntegerLcp& lcp, const Deadline& deadline);

}  // namespace lcpbench::exact
