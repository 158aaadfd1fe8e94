#include <cmath>

#include "study/evaluation/quad_lcp.h"

namespace lcpbench {

BareQuadLcp::BareQuadLcp(const Lcp& lcp) : lcp_(lcp) { q_.assign(lcp.q.begin(), lcp.q.end()); }

QuadVector BareQuadLcp::response(const QuadVector& z) {
  QuadVector w = q_;
  for (std::size_t j = 0; j < size(); ++j) remove(j, -z[j], w);
  return w;
}

void BareQuadLcp::respond(std::span<const std::size_t> rows, const QuadVector& z, QuadVector& u) {
  for (const std::size_t i : rows) {
    u[i] = q_[i];
    for (const std::size_t j : rows) {
      if (z[j] != 0) u[i] -= M(i, j) * -z[j];
    }
  }
}

void BareQuadLcp::remove(std::size_t j, Quad value, QuadVector& u) {
  if (value == 0) return;
  for (std::size_t i = 0; i < size(); ++i) u[i] -= M(i, j) * value;
}

Quad BareQuadLcp::row(std::size_t i, const QuadVector&, const QuadVector& u) const { return u[i]; }

Quad BareQuadLcp::diagonal(std::size_t i) { return M(i, i); }

Quad BareQuadLcp::abs_row_times(std::size_t i, const QuadVector& z, std::span<const std::size_t> support) {
  Quad sum = 0;
  for (const std::size_t j : support) sum += abs(M(i, j) * z[j]);
  return sum;
}

Quad BareQuadLcp::abs_row_sum(std::size_t i) {
  Quad sum = 0;
  for (std::size_t j = 0; j < size(); ++j) sum += abs(Quad{M(i, j)});
  return sum;
}

std::vector<double> BareQuadLcp::estimate_w(const QuadVector&, const QuadVector& u,
                                            std::span<const std::size_t> rows) const {
  std::vector<double> w(size(), 0.0);
  for (const std::size_t i : rows) w[i] = to_double(u[i]);
  return w;
}

void BareQuadLcp::fill_row(std::size_t i, MagnitudeEstimate::Row& row, MagnitudeEstimate& estimate) {
  for (std::size_t j = 0; j < size(); ++j) {
    if (M(i, j) == 0) continue;
    estimate.add(j, std::abs(M(i, j)));
    row.sum += std::abs(M(i, j));
  }
  row.diagonal = M(i, i);
}

}  // namespace lcpbench
