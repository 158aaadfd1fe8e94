#pragma once

#include <vector>

#include "core/types.h"

namespace lcpbench {

/// An elimination order for a sparse symmetric matrix: position k is eliminated k-th. By nested dissection: a level set
/// in the middle of a breadth-first search from a far corner separates the graph; it comes last, the halves before it
/// alike, pieces of a few rows in breadth-first order. For planar graphs with levels of O(sqrt(n)) vertices the factor
/// has O(n log n) entries and costs O(n^1.5). O(nnz log n). [George 1973; George, Liu 1978]
/// @param lower  the lower triangle (the diagonal is not looked at)
std::vector<int> nested_dissection(const SparseMatrix& lower);

}  // namespace lcpbench
