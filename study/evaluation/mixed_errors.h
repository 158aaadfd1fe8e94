#pragma once

#include "core/lcp.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench {

/// The measures of a finite z of n entries by the conditions of the mixed LCP, in 113 bits: backward_row_norm and
/// natural_residual with mid(z - lower, z - upper, w) in the place of min(z, w). @pre lcp.is_mixed()
Errors mixed_errors(const Lcp& lcp, const Vector& z);

/// Whether rows are limited by what others carry: what holds for LCPs on a fixed box need then not hold.
bool has_friction(const Lcp& lcp);

}  // namespace lcpbench
