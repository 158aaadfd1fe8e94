#pragma once

#include <cstdint>
#include <vector>

#include "core/lcp.h"
#include "core/quad.h"

namespace lcpbench {

/// Solves LCP(q, M), n <= 12, by going through all 2^n supports of z, in 113 bits.
///
/// For a support S the points z_S >= 0, w_S = 0, w >= 0 form a polyhedron without lines, so when it is not empty it has
/// a vertex: a point at which z vanishes outside some S' in S and the rows of S' together with further rows w_j = 0
/// determine z_S'. These points are all tried, so that singular principal submatrices are no obstacle. Supports come in
/// the order of the number whose bit i says that i is in S. 2^n systems of order <= n when no principal submatrix is
/// singular, at most 3^n otherwise. That none is found proves nothing. Allocates.
/// [Cottle, Pang, Stone 1992, section 1.3: complementary cones]
class SupportSearch {
 public:
  static constexpr Index kMaxSize = 12;

  enum class End { kFound, kNone, kTimeLimit, kSystemLimit };

  /// @param lcp of order <= kMaxSize; must stay as it is until the next load
  void load(const Lcp& lcp);

  /// Ends at the first solution: a point whose backward error is at most 2^-100.
  /// @param deadline_s on wall_clock_s() @param most_systems that are solved before it gives up
  End run(double deadline_s, std::int64_t most_systems);

  /// The solution (n), rounded.
  const Vector& z() const { return z_; }

 private:
  bool complete(std::size_t first_other);
  bool try_rows();
  bool add_if_independent(Index row);

  const Lcp* lcp_ = nullptr;
  std::vector<Quad> column_size_;  ///< the largest |entry|, by which pivots are compared
  std::vector<Index> support_, others_;
  /// w = 0 in these determines a point; [M q] of them on the support, each reduced by those before it.
  std::vector<Index> rows_;
  std::vector<std::vector<Quad>> reduced_;
  std::vector<std::size_t> pivots_;  ///< of reduced_: the columns of the largest entries
  Vector z_;
  double deadline_s_ = 0;
  std::int64_t systems_left_ = 0;
  End stopped_ = End::kNone;  ///< by a limit
};

}  // namespace lcpbench
