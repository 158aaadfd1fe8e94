#pragma once

#include "core/types.h"

namespace lcpbench {

/// LCP(q, M): find z >= 0 with w = M z + q >= 0 and z'w = 0. [Cottle, Pang, Stone 1992, (1.1.1)]
struct Lcp {
  Matrix M;  ///< n x n
  Vector q;  ///< n

  Index size() const { return q.size(); }
};

/// One row of LCP(q, M) at some z, by which all code judges an answer.
template <class Real>
struct LcpRow {
  Real norm = 0;     ///< c: the sum of |M_ij| over the row; 1 for a row of zeros
  Real q = 0;
  Real z = 0;
  Real w = 0;
  Real largest = 0;  ///< |z_j| of the rows that M connects with this one

  /// |min(c z, w)|: a positive w and what a positive z adds may not both be there. NaN if w is.
  Real violation() const {
    const Real least = norm * z < w ? norm * z : w;
    return least < 0 ? -least : least;
  }
  /// What the violation is relative to.
  Real scale() const { return (q < 0 ? -q : q) + norm * largest; }
};

}  // namespace lcpbench
