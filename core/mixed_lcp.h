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
