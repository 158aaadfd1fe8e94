#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "core/islands.h"
#include "core/lcp.h"

namespace lcpbench {

/// The error of an answer to a mixed LCP, by the measure of bare LCPs.
template <class Real>
struct MixedError {
  Real backward = 0;  ///< the largest |mid(c_i (z_i - lower_i), c_i (z_i - upper_i), w_i)| / (|q_i| + c_i max|z|)
  Real natural = 0;   ///< the largest |mid(z_i - lower_i, z_i - upper_i, w_i)|
  Index row = -1;     ///< where the first one is; -1: it is zero
  Real w = 0;         ///< there
};

/// mid(c (z - lower), c (z - upper), w) of row i, which is zero at a solution. @param c above zero
template <class Real>
Real mixed_residual(const LcpBounds& bounds, Index i, const std::vector<Real>& z, Real c, Real w) {
  const int of = bounds.friction_of[static_cast<std::size_t>(i)];
  const Real limit = of >= 0 ? Real{bounds.mu(i)} * z[static_cast<std::size_t>(of)] : Real{0};
  const Real at = z[static_cast<std::size_t>(i)];
  Real value = w;
  if (of >= 0 || std::isfinite(bounds.lower(i))) {
    const Real above = c * (of >= 0 ? at + limit : at - Real{bounds.lower(i)});
    if (above < value) value = above;
  }
  if (of >= 0 || std::isfinite(bounds.upper(i))) {
    const Real below = c * (of >= 0 ? at - limit : at - Real{bounds.upper(i)});
    if (below > value) value = below;
  }
  return value;
}

/// By the conditions of the mixed LCP itself, whatever z was found by. c_i is the sum of |M_ij| over the row, 1 for a
/// row of zeros; the largest z_j is that of the rows that M connects with row i. A NaN in z or w is no solution:
/// infinity. O(n^2). @pre lcp.is_mixed(), z has n entries
template <class Real>
MixedError<Real> mixed_error(const Lcp& lcp, const std::vector<Real>& z) {
  const auto magnitude = [](Real x) { return x < 0 ? -x : x; };
  const RowIslands islands = row_islands(lcp.M);
  std::vector<Real> largest(static_cast<std::size_t>(islands.count), 0);
  std::vector<Real> w(lcp.q.begin(), lcp.q.end());
  std::vector<Real> norm(w.size(), 0);
  for (std::size_t j = 0; j < z.size(); ++j) {
    Real& most = largest[static_cast<std::size_t>(islands.of_row[j])];
    if (!(magnitude(z[j]) <= most)) most = magnitude(z[j]);
    for (std::size_t i = 0; i < w.size(); ++i) {
      const Real entry = lcp.M(static_cast<Index>(i), static_cast<Index>(j));
      w[i] += entry * z[j];
      norm[i] += magnitude(entry);
    }
  }
  MixedError<Real> worst;
  for (std::size_t i = 0; i < w.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const Real c = norm[i] > 0 ? norm[i] : Real{1};
    const Real scale = magnitude(lcp.q(row)) + c * largest[static_cast<std::size_t>(islands.of_row[i])];
    const Real violation = magnitude(mixed_residual(lcp.bounds, row, z, c, w[i]));
    const Real natural = magnitude(mixed_residual(lcp.bounds, row, z, Real{1}, w[i]));
    Real error = violation == 0 ? Real{0} : violation / scale;
    if (!(error >= 0)) error = Real{HUGE_VAL};
    if (!(natural <= worst.natural)) worst.natural = natural;
    if (error > worst.backward) {
      worst.backward = error;
      worst.row = row;
      worst.w = w[i];
    }
  }
  return worst;
}

/// A mixed LCP as an LCP with z >= 0 alone, for solvers that know no other.
///
/// A bound becomes the origin of its unknown. A second bound takes a slack of its own, and a row of friction is split
/// into its two signs and a multiplier, as a pyramid of two edges is: the solutions are the same. Free unknowns, whose
/// rows are equations in any order, are eliminated, if need be together with as many rows that have a bound, which then
/// change the places of z and w; where no such block is regular, each becomes the difference of two unknowns >= 0.
class LcpReduction {
 public:
  /// O(n^3) where unknowns are free. @pre mixed.is_mixed(), and check_lcp() accepts it
  explicit LcpReduction(const Lcp& mixed);

  const Lcp& lcp() const { return lcp_; }
  /// Nothing was rounded: if there is no solution of lcp(), there is none of the mixed LCP.
  bool is_exact() const { return exact_; }
  /// The z of the mixed LCP. @param x  of lcp()
  Vector restore(const Vector& x) const;

 private:
  struct Unknown {
    Index row;    ///< of the mixed LCP; -1: a slack or a multiplier
    double sign;  ///< of its part in z
  };

  void expand(const Lcp& mixed);
  std::vector<Index> exchanged_with(const std::vector<Index>& free) const;
  bool eliminate(const std::vector<Index>& free, const std::vector<Index>& exchanged);
  void split(const std::vector<Index>& free);

  Lcp lcp_;                        ///< at first with all unknowns
  Vector origin_;                  ///< n: z where all unknowns are zero
  std::vector<Unknown> unknowns_;  ///< all, in the order of kept_ and eliminated_
  std::vector<Index> kept_;        ///< that of each row of lcp(); an exchanged row has the place of its unknown
  std::vector<Index> eliminated_;  ///< free, then exchanged: recover_ x + recover_origin_
  Index exchanged_ = 0;            ///< how many of them are exchanged
  Matrix recover_;
  Vector recover_origin_;
  bool exact_ = true;
};

/// Rows of a bare LCP that are a free unknown written as the difference of two: M_k = -M_i, q_k = -q_i, and alike the
/// columns. Each row is in one pair at most. O(n^2), and O(n) more for two rows whose sums are opposite, too.
std::vector<std::pair<Index, Index>> split_unknowns(const Lcp& lcp);

/// The mixed LCP with one free unknown for each pair. @param rows  receives the row of `lcp` of each of its rows
Lcp with_free_unknowns(const Lcp& lcp, const std::vector<std::pair<Index, Index>>& pairs, std::vector<Index>& rows);

}  // namespace lcpbench
