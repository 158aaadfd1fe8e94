#pragma once

#include <optional>
#include <vector>

#include "study/certify/deadline.h"
#include "study/certify/integers.h"

namespace lcpbench::exact {

/// Rows and columns of a nonsingular square part of a matrix.
struct Minor {
  std::vector<Index> rows;
  std::vector<Index> columns;
};

/// A largest nonsingular minor of A modulo a prime of 63 bits, and so nonsingular over the integers: columns are taken
/// from the left unless they depend on those before, each with the first free row that keeps the minor nonzero.
/// O(rows cols rank).
/// With a probability near 2^-63 a column is left out that is independent over the integers.
/// @throws TimePassed
Minor independent_minor(const IntegerMatrix& A, const Deadline& deadline);

/// Equations A x = b; b has one column.
struct Equations {
  IntegerMatrix A;
  IntegerMatrix b;
};

/// The square system of a minor.
Equations part(const Equations& e, const Minor& minor);

/// Numerators of a solution of a largest independent part of the equations, over a positive denominator; unknowns that
/// depend on those before are zero. No value where that part leaves out the first equation or has no solution.
/// @throws TimePassed
std::optional<IntegerVector> solve_independent_part(const Equations& e, const Deadline& deadline);

}  // namespace lcpbench::exact
