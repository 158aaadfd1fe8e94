#pragma once

#include "core/types.h"
#include "study/certify/deadline.h"

namespace lcpbench::exact {

/// Whether a symmetric matrix of doubles is proven to be positive definite.
///
/// Fast: Cholesky's method in double on A less a bound of its rounding error. [Rump, Verification of positive
/// definiteness, BIT 46 (2006)] Where that ends early, the signs of the leading principal minors, exactly, which
/// decides; for orders up to 64, since it takes O(n^3) operations on integers of O(n) words. @pre finite and symmetric.
/// @throws TimePassed
bool positive_definite(const Matrix& A, const Deadline& deadline);

}  // namespace lcpbench::exact
