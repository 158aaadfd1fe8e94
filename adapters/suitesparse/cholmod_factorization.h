#pragma once

#include <cstdint>
#include <memory>

#include "native/velocity_ipm/sparse_factorization.h"

namespace lcpbench {

/// How CHOLMOD goes about it; `kAuto` is its own choice by the work per entry of the factor.
enum class CholmodFactor { kAuto, kSimplicial, kSupernodal };
/// kGiven: the order that the matrix comes in; the others: CHOLMOD looks for one of its own.
enum class CholmodOrdering { kGiven, kAmd, kMetis };

struct CholmodOptions {
  CholmodFactor factor = CholmodFactor::kAuto;
  CholmodOrdering ordering = CholmodOrdering::kGiven;
  std::int64_t refinements = 1;  ///< steps x += A^-1 (b - A x) after each solution
};

/// CHOLMOD's Cholesky factorization, nothing added to the matrix. A pivot that is not positive (LL') or zero (LDL') is
/// a breakdown. Throws std::bad_alloc when CHOLMOD runs out of memory or of 32-bit indices.
/// [Chen, Davis, Hager, Rajamanickam 2008]
std::unique_ptr<SparseFactorization> cholmod_factorization(const CholmodOptions& options);

}  // namespace lcpbench
