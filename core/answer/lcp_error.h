#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "core/islands.h"
#include "core/lcp.h"

namespace lcpbench {

/// What an answer to LCP(q, M), mixed or not, leaves of its conditions, in double or in 113 bits.
template <class Real>
struct LcpError {
  Real backward = 0;    ///< the largest |residual with c_i| / (|q_i| + c_i max|z|), see lcp_residual()
  Real natural = 0;     ///< the largest |residual with 1|
  Index row = -1;       ///< where the first one is; -1: it is zero
  std::vector<Real> w;  ///< M z + q
};

/// min(c z, w) of row i; of a mixed LCP mid(c (z - lower), c (z - upper), w). Zero at a solution. @param c above zero
template <class Real>
Real lcp_residual(const Lcp& lcp, Index i, const std::vector<Real>& z, Real c, Real w) {
  const Real at = z[static_cast<std::size_t>(i)];
  Real value = w;
  const auto at_most = [&](Real above) { value = above < value ? above : value; };
  const auto at_least = [&](Real below) { value = below > value ? below : value; };
  if (!lcp.is_mixed()) {
    at_most(c * at);
  } else if (const int of = lcp.bounds.friction_of[static_cast<std::size_t>(i)]; of >= 0) {
    const Real limit = Real{lcp.bounds.mu(i)} * z[static_cast<std::size_t>(of)];
    at_most(c * (at + limit));
    at_least(c * (at - limit));
  } else {
    if (std::isfinite(lcp.bounds.lower(i))) at_most(c * (at - Real{lcp.bounds.lower(i)}));
    if (std::isfinite(lcp.bounds.upper(i))) at_least(c * (at - Real{lcp.bounds.upper(i)}));
  }
  return value;
}

/// By the conditions of the problem itself, whatever z was found by. c_i is the sum of |M_ij| over the row, 1 for a row
/// of zeros; max|z| is that of the rows that M connects with row i. 0/0 = 0. A NaN in z or w is no solution: infinity.
/// O(n^2). @pre z has n entries @param islands  of M
template <class Real>
LcpError<Real> lcp_error(const Lcp& lcp, const std::vector<Real>& z, const RowIslands& islands) {
  const auto magnitude = [](Real x) { return x < 0 ? -x : x; };
  std::vector<Real> largest(static_cast<std::size_t>(islands.count), 0);
  LcpError<Real> worst{.w = std::vector<Real>(lcp.q.begin(), lcp.q.end())};
  std::vector<Real>& w = worst.w;
  std::vector<Real> norm(w.size(), 0);
  for (std::size_t j = 0; j < z.size(); ++j) {
    Real& most = largest[static_cast<std::size_t>(islands.of_row[j])];
    if (!(magnitude(z[j]) <= most)) most = magnitude(z[j]);
    for (std::size_t i = 0; i < w.size(); ++i) {
      const Real entry = lcp.M(static_cast<Index>(i), static_cast<Index>(j));
      if (z[j] != 0) w[i] += entry * z[j];
      norm[i] += magnitude(entry);
    }
  }
  for (std::size_t i = 0; i < w.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const Real c = norm[i] > 0 ? norm[i] : Real{1};
    const LcpRow<Real> scale{
        .norm = c, .q = lcp.q(row), .largest = largest[static_cast<std::size_t>(islands.of_row[i])]};
    const Real violation = magnitude(lcp_residual(lcp, row, z, c, w[i]));
    const Real natural = magnitude(lcp_residual(lcp, row, z, Real{1}, w[i]));
    Real error = violation == 0 ? Real{0} : violation / scale.scale();
    if (!(error >= 0)) error = Real{HUGE_VAL};
    if (!(natural <= worst.natural)) worst.natural = natural;
    if (error > worst.backward) {
      worst.backward = error;
      worst.row = row;
    }
  }
  return worst;
}

template <class Real>
LcpError<Real> lcp_error(const Lcp& lcp, const std::vector<Real>& z) {
  return lcp_error(lcp, z, row_islands(lcp.M));
}

}  // namespace lcpbench
