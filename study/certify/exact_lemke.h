#pragma once

#include <optional>

#include "study/certify/deadline.h"
#include "study/certify/exact_system.h"

namespace lcpbench::exact {

/// LCP(q, M) over the integers.
struct IntegerLcp {
  IntegerMatrix M;
  IntegerVector q;

  Index size() const { return static_cast<Index>(q.size()); }
};

/// A contact system with its potentials eliminated: M = R'K^-1 L + S and q, both times the denominator of K^-1 L.
struct EliminatedSystem {
  IntegerLcp lcp;
  IntegerMatrix potentials;  ///< k x n: denominator K^-1 L
  Integer denominator{1};
};

/// No value where K is singular. @throws TimePassed
std::optional<EliminatedSystem> eliminate_potentials(const ExactSystem& system, const Deadline& deadline);

/// The point of `system` with this z / denominator.
ExactPoint with_potentials(const EliminatedSystem& eliminated, const IntegerVector& z, const Integer& denominator);

enum class LemkeEnding { kSolution, kRay, kTimeLimit };

struct LemkeOutcome {
  LemkeEnding ending = LemkeEnding::kTimeLimit;
  IntegerVector z;         ///< kSolution: z times the denominator; kRay: the z-part of the ray's direction
  Integer denominator{1};  ///< > 0
};

/// Lemke's method with the lexicographic ratio test and covering vector 1, in integers: every tableau entry is a minor
/// of the data, so the divisions are exact. Finite; solves, or proves unsolvable, every LCP of a positive semidefinite
/// M. [Cottle, Pang, Stone 1992, sections 4.4 and 4.9; Edmonds 1967 for the pivots]
/// n^2 exact operations a pivot, on integers of up to n + k times the length of the data's.
LemkeOutcome exact_lemke(const IntegerLcp& lcp, const Deadline& deadline);

}  // namespace lcpbench::exact
