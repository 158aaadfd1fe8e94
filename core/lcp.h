#pragma once

#include "core/types.h"

namespace lcpbench {

/// LCP(q, M): find z >= 0 with w = M z + q >= 0 and z'w = 0. [Cottle, Pang, Stone 1992, (1.1.1)]
struct Lcp {
  Matrix M;  ///< n x n
  Vector q;  ///< n

  Index size() const { return q.size(); }
};

}  // namespace lcpbench
