#pragma once

#include "study/inspect/inspection.h"

namespace lcpbench {

/// Facts of (q, M). @param impulses  leading rows that are no rows of friction cones (all of a bare LCP); of these the
/// spectrum is taken, of `independent` alone where friction columns come in opposite pairs.
MatrixFacts matrix_facts(const Lcp& lcp, const std::vector<Index>& independent);

/// Facts of q, or of its first `rows` entries. @param M  empty where it is not formed
VelocityFacts velocity_facts(const Vector& q, Index rows, const Matrix& M);

/// Groups of indices that are joined: the number of groups and the size of the largest.
class Components {
 public:
  explicit Components(Index count);
  void join(Index a, Index b);
  Index count() const;
  Index largest() const;
  Index root(Index a) const;

 private:
  std::vector<Index> parent_;
};

}  // namespace lcpbench
