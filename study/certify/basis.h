#pragma once

#include <optional>
#include <vector>

#include "study/certify/deadline.h"
#include "study/certify/exact_system.h"
#include "study/certify/integer_solve.h"

namespace lcpbench::exact {

// Functions that take a deadline @throw TimePassed.

/// K p - L z = 0, then w = 0 on `rows`, in x = [p; z of `basis`].
Equations basis_equations(const ExactSystem& system, const std::vector<Index>& basis, const std::vector<Index>& rows);

/// The point at which z is zero but for `basis`, and w is zero there: one exact solve of order k + |basis|.
/// No value where that system is singular. Signs are not looked at.
std::optional<ExactPoint> basis_point(const ExactSystem& system, const std::vector<Index>& basis,
                                      const Deadline& deadline);

/// As basis_point, for singular systems too: of `basis`, the most important first, as many entries as the equations of
/// the rows of `basis` and `tight`, w = 0, determine; the rest stay zero.
std::optional<ExactPoint> purified_point(const ExactSystem& system, const std::vector<Index>& basis,
                                         const std::vector<Index>& tight, const Deadline& deadline);

/// The next basis to try after a point that is no solution: without the z_i < 0, with the w_i < 0.
/// [Kostreva, block principal pivoting, 1978]
std::vector<Index> exchanged_basis(const ExactSystem& system, const ExactPoint& point, const Deadline& deadline);

/// The u with L u = 0 and q'u = -1, up to a positive factor, that is zero but for `support`; entries of the support
/// that depend on those before stay zero. No value where there is none.
std::optional<IntegerVector> annihilator(const ExactSystem& system, const std::vector<Index>& support,
                                         const Deadline& deadline);

}  // namespace lcpbench::exact
