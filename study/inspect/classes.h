#pragma once

#include <optional>
#include <utility>

#include "core/types.h"

namespace lcpbench {

enum class Tri { kUnknown, kNo, kYes };

/// Largest order for which principal minors are gone through.
inline constexpr Index kLargestMinors = 12;

/// Z: no entry off the diagonal is positive.
bool is_z_matrix(const Matrix& M);

/// P: all principal minors positive, by Schur complements in 113 bits: M_11 > 0, and M without its first row and column
/// and its Schur complement are P. kUnknown above kLargestMinors, and where a pivot drowns in the rounding. O(2^n).
/// [Tsatsomeros, Li 2000]
Tri is_p_matrix(const Matrix& M);

/// A principal submatrix of order one or two on which z'Mz < 0 for some z >= 0; nullopt where there is none. O(n^2).
std::optional<std::pair<Index, Index>> copositivity_counterexample(const Matrix& M);

/// "yes", "no", "unknown".
const char* to_string(Tri value);

}  // namespace lcpbench
