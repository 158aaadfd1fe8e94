#include "study/evaluation/backward_error.h"

#include <algorithm>

namespace lcpbench {

QuadVector complement(const Lcp& lcp, const QuadVector& z) {
  QuadVector w(lcp.q.begin(), lcp.q.end());
  for (std::size_t j = 0; j < z.size(); ++j) {
    if (z[j] == 0) continue;
    for (std::size_t i = 0; i < w.size(); ++i) w[i] += lcp.M(static_cast<Index>(i), static_cast<Index>(j)) * z[j];
  }
  return w;
}

BackwardError backward_error(const Lcp& lcp, const QuadVector& z, const QuadVector& w, const IslandRows& islands) {
  BackwardError worst;
  for (std::size_t island = 0; island < islands.count(); ++island) {
    LcpRow<Quad> row;
    for (const std::size_t i : islands.rows(island)) row.largest = std::max(row.largest, abs(z[i]));
    for (const std::size_t i : islands.rows(island)) {
      const auto index = static_cast<Index>(i);
      row.norm = 0;
      for (const double entry : lcp.M.row(index)) row.norm += abs(Quad{entry});
      if (row.norm == 0) row.norm = 1;
      row.q = lcp.q(index);
      row.z = z[i];
      row.w = w[i];
      const Quad error = quotient(row.violation(), row.scale());
      if (error > worst.error) worst = {error, i};
    }
  }
  return worst;
}

}  // namespace lcpbench
