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

/// Solves A x = denominator b exactly for a square A and any number of right-hand sides, by p-adic lifting. [Dixon
/// 1982] FLINT's own lifting cannot be interrupted, and inverts A again for each b.
///
/// A^-1 modulo a prime of 61 bits gives one digit of x after the other; x follows from its digits by rational
/// reconstruction, tried each time their number has doubled and checked by multiplication, at the latest when there are
/// as many as Cramer's rule asks for. O(n^3) for A^-1, then O(n^2) products a digit; the deadline is read at each.
/// @throws TimePassed
class Lifting {
 public:
  /// @param A,deadline  outlive this
  Lifting(const IntegerMatrix& A, const Deadline& deadline);

  /// A^-1 was found to exist. False where A has more than 2^13 rows, and where it is singular modulo two primes, which
  /// happens to an invertible A with a probability near 2^-120.
  bool possible() const { return possible_; }

  /// False where possible() is, unless b is zero: then x is zero. @param b,x  n x 1
  bool solve(const IntegerMatrix& b, IntegerMatrix& x, Integer& denominator) const;

  /// |det A| / divisor, modulo as many primes as its bound asks for. @pre possible(); divisor > 0 divides det A
  Integer determinant_over(const Integer& divisor) const;

 private:
  const IntegerMatrix& A_;
  const Deadline& deadline_;
  Residues inverse_;
  bool possible_ = false;
};

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
