#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/islands.h"
#include "core/lcp.h"

namespace lcpbench {

/// What an answer to LCP(q, M), mixed or not, leaves of its conditions, in double or in 113 bits.
template <class Real>
struct LcpError {
  Real backward = 0;    ///< eta, the largest error of all rows
  Real natural = 0;     ///< the largest |lcp_residual()| with c = 1
  Index row = -1;       ///< where the first one is; -1: it is zero
  Real scale = 0;       ///< of that row
  std::vector<Real> w;  ///< M z + q
};

/// The error of a row is |lcp_residual()| with c_i, relative to the larger of |q_i| + sum_j |M_ij| |z_j| and this share
/// of its floor F_i.
inline constexpr double kLcpFloorShare = 0.01;

/// min(c z, w) of row i; of a mixed LCP the middle one of c (z - lower), c (z - upper) and w. Zero at a solution.
/// @param c above zero
template <class Real>
Real lcp_residual(const Lcp& lcp, Index i, const std::vector<Real>& z, Real c, Real w) {
  const Real at = z[static_cast<std::size_t>(i)];
  if (!lcp.is_mixed()) return c * at < w ? c * at : w;
  if (const int of = lcp.bounds.friction_of[static_cast<std::size_t>(i)]; of >= 0) {
    const Real limit = Real{lcp.bounds.mu(i)} * z[static_cast<std::size_t>(of)];
    const Real one = c * (at + limit), other = c * (at - limit);  // in either order: z of a normal row may be below zero
    const Real above = other < one ? one : other, below = other < one ? other : one;
    const Real capped = above < w ? above : w;
    return below > capped ? below : capped;
  }
  Real value = w;
  if (const double lower = lcp.bounds.lower(i); std::isfinite(lower)) value = std::min(value, c * (at - Real{lower}));
  if (const double upper = lcp.bounds.upper(i); std::isfinite(upper)) value = std::max(value, c * (at - Real{upper}));
  return value;
}

/// c_i, the sum of |M_ij| over the row; 1 for a row of zeros. O(n^2)
template <class Real>
std::vector<Real> lcp_norms(const Lcp& lcp) {
  std::vector<Real> norms(static_cast<std::size_t>(lcp.size()), 0);
  for (Index j = 0; j < lcp.size(); ++j) {
    for (Index i = 0; i < lcp.size(); ++i) norms[static_cast<std::size_t>(i)] += Real{std::abs(lcp.M(i, j))};
  }
  for (Real& norm : norms) norm = norm > 0 ? norm : Real{1};
  return norms;
}

/// F_i of each row, from the problem alone: min(c_i max_k (Q_k / c_k), max_k Q_k) over the rows k that M connects with
/// row i. Q_k = |q_k| + sum_j |M_kj| |p_j|, p_j the number within the bounds of z_j that is nearest to zero.
/// O(n), of a mixed LCP O(n^2)
template <class Real>
std::vector<Real> lcp_floors(const Lcp& lcp, const RowIslands& islands, const std::vector<Real>& norms) {
  std::vector<Real> sizes(norms.size(), 0);
  for (std::size_t i = 0; i < sizes.size(); ++i) sizes[i] = Real{std::abs(lcp.q(static_cast<Index>(i)))};
  for (Index j = 0; lcp.is_mixed() && j < lcp.size(); ++j) {
    const double nearest = std::max(lcp.bounds.lower(j), std::min(0.0, lcp.bounds.upper(j)));
    for (Index i = 0; nearest != 0 && i < lcp.size(); ++i) {
      sizes[static_cast<std::size_t>(i)] += Real{std::abs(lcp.M(i, j))} * Real{std::abs(nearest)};
    }
  }
  std::vector<Real> largest(static_cast<std::size_t>(islands.count), 0), largest_share = largest;
  const auto island = [&](std::size_t i) { return static_cast<std::size_t>(islands.of_row[i]); };
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    largest[island(i)] = std::max(largest[island(i)], sizes[i]);
    largest_share[island(i)] = std::max(largest_share[island(i)], sizes[i] / norms[i]);
  }
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    sizes[i] = std::min(norms[i] * largest_share[island(i)], largest[island(i)]);
  }
  return sizes;
}

/// By the conditions of the problem itself, whatever z was found by. 0/0 = 0. A NaN in z or w is no solution: infinity.
/// O(n^2). @pre z has n entries @param islands  of M
template <class Real>
LcpError<Real> lcp_error(const Lcp& lcp, const std::vector<Real>& z, const RowIslands& islands) {
  const auto magnitude = [](Real x) { return x < 0 ? -x : x; };
  LcpError<Real> worst{.w = std::vector<Real>(lcp.q.begin(), lcp.q.end())};
  std::vector<Real>& w = worst.w;
  std::vector<Real> terms(w.size());
  std::transform(w.begin(), w.end(), terms.begin(), magnitude);
  for (std::size_t j = 0; j < z.size(); ++j) {
    if (z[j] == 0) continue;
    for (std::size_t i = 0; i < w.size(); ++i) {
      const Real term = Real{lcp.M(static_cast<Index>(i), static_cast<Index>(j))} * z[j];
      w[i] += term;
      terms[i] += magnitude(term);
    }
  }
  const std::vector<Real> norms = lcp_norms<Real>(lcp), floors = lcp_floors(lcp, islands, norms);
  for (std::size_t i = 0; i < w.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const Real violation = magnitude(lcp_residual(lcp, row, z, norms[i], w[i]));
    const Real natural = magnitude(lcp_residual(lcp, row, z, Real{1}, w[i]));
    const Real scale = std::max(terms[i], Real{kLcpFloorShare} * floors[i]);
    Real error = violation == 0 ? Real{0} : violation / scale;
    if (!(error >= 0)) error = Real{HUGE_VAL};
    if (!(natural <= worst.natural)) worst.natural = natural;
    if (error > worst.backward) {
      worst.backward = error;
      worst.row = row;
      worst.scale = scale;
    }
  }
  return worst;
}

template <class Real>
LcpError<Real> lcp_error(const Lcp& lcp, const std::vector<Real>& z) {
  return lcp_error(lcp, z, row_islands(lcp.M));
}

}  // namespace lcpbench
