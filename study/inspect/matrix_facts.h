#pragma once

#include "core/islands.h"
#include "study/inspect/inspection.h"

namespace lcpbench {

/// Facts of (q, M). @param impulses  leading rows that are no rows of friction cones (all of a bare LCP); of these the
/// spectrum is taken, of `independent` alone where friction columns come in opposite pairs.
MatrixFacts matrix_facts(const Lcp& lcp, const std::vector<Index>& independent);

/// Facts of q, or of its first `rows` entries. @param M  empty where it is not formed
VelocityFacts velocity_facts(const Vector& q, Index rows, const Matrix& M);

/// The number of islands, and how many of the first `rows` rows are in the one that has most of these.
std::pair<Index, Index> island_sizes(const RowIslands& islands, Index rows);

}  // namespace lcpbench
