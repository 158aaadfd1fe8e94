#pragma once

#include <cstdint>
#include <vector>

#include "core/exact_matrix.h"
#include "core/lcp.h"

namespace lcpbench {

/// Decides LCP(q, M), n <= 12, in exact arithmetic by going through all 2^n supports of z.
///
/// For a support S the points z_S >= 0, w_S = 0, w >= 0 form a polyhedron without lines, so when it is not empty it has
/// a vertex: a point at which z vanishes outside some S' in S and the rows of S' together with further rows w_j = 0
/// determine z_S'. These points are all tried, so singular principal submatrices are decided like the others.
/// Supports come in the order of the number whose bit i says that i is in S. 2^n systems of order <= n when no
/// principal submatrix is singular, at most 3^n otherwise; what double cannot rule out is solved exactly. Allocates.
/// [Cottle, Pang, Stone 1992, section 1.3: complementary cones]
class ExactSearch {
 public:
  static constexpr Index kMaxSize = 12;

  enum class End { kFound, kNone, kTimeLimit, kSystemLimit };

  /// @param lcp of order <= kMaxSize; must stay as it is until the next load
  void load(const Lcp& lcp);

  /// Ends at the first solution; with kSystemLimit also where numbers take too many digits.
  /// @param deadline_s on wall_clock_s() @param most_systems that are solved before it gives up
  End run(double deadline_s, std::int64_t most_systems);

  /// Whether there is a solution with this support (ascending), of which M's block is regular. False also where numbers
  /// take too many digits.
  bool solves_with(const std::vector<Index>& support);

  /// The solution (n), rounded.
  const Vector& z() const { return z_; }

 private:
  enum class Point { kSolution, kNone, kSingular };

  void start(std::vector<Index> support);
  bool find_with_support();
  bool complete(std::size_t first_other);
  Point try_rows();
  bool is_ruled_out() const;
  bool is_solution(const ExactSolution& solution);
  Index rank(bool with_q);

  const Lcp* lcp_ = nullptr;
  ExactMatrix M_{0, 0};
  std::vector<Dyadic> q_;
  std::vector<Index> support_, others_;
  std::vector<Index> rows_;  ///< w = 0 in these determines a point
  Vector z_;
  double deadline_s_ = 0;
  std::int64_t most_systems_ = 0;
  std::int64_t systems_ = 0;  ///< of this run
  End stopped_ = End::kNone;  ///< by a limit
};

}  // namespace lcpbench
