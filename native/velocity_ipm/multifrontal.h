#pragma once

#include <memory>

#include "core/isa.h"
#include "native/velocity_ipm/sparse_factorization.h"

namespace lcpbench {

/// Sparse Cholesky factorization by dense fronts, A = L L', nothing added to the matrix. All memory is taken by
/// analyze(): neither factor() nor solve() allocates. A pivot that is not positive, or not finite, is a breakdown.
/// [Duff, Reid 1983, The multifrontal solution of indefinite sparse symmetric linear equations; Liu 1992]
/// @param level instruction-set level of the kernels; must not exceed best_isa_level()
std::unique_ptr<SparseFactorization> multifrontal_cholesky(IsaLevel level = isa_level());

/// The same for unsymmetric matrices, A = L U. Rows are exchanged only within panels of 64 columns of a front. Even a
/// regular matrix is a breakdown if a column finds no pivot within its panel.
std::unique_ptr<UnsymmetricFactorization> multifrontal_lu(IsaLevel level = isa_level());

}  // namespace lcpbench
