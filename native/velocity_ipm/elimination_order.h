#pragma once

#include <vector>

#include "core/types.h"

namespace lcpbench {

/// An elimination order for a sparse symmetric matrix, by approximate minimum degree: position k is eliminated k-th.
/// [Amestoy, Davis, Duff 1996; Eigen::AMDOrdering]
/// @param lower  the lower triangle (the values are not looked at)
std::vector<int> elimination_order(const SparseMatrix& lower);

}  // namespace lcpbench
