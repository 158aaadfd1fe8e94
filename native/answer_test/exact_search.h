#pragma once

#include <cstdint>
#include <vector>

#include "core/lcp.h"
#include "native/answer_test/exact_system.h"

namespace lcpbench::enumeration {

/// Decides LCP(q, M), n <= 12, in exact integer arithmetic by going through all 2^n supports of z.
///
/// For a support S the points z_S >= 0, w_S = 0, w >= 0 form a polyhedron without lines, so when it is not empty it has
/// a vertex: a point at which z vanishes outside some S' in S and the rows of S' together with further rows w_j = 0
/// determine z_S'. These points are all tried, so singular principal submatrices are decided like the others.
/// Supports come in the order of the number whose bit i says that i is in S. 2^n systems of order <= n when no
/// principal submatrix is singular, at most 3^n otherwise. [Cottle, Pang, Stone 1992, section 1.3: complementary cones]
class ExactSearch {
 public:
  static constexpr Index kMaxSize = 12;

  enum class End { kFound, kNone, kTimeLimit, kSystemLimit };

  /// Room for any problem of that order, so that load() allocates nothing.
  void reserve(Index n);

  /// @param lcp of order <= kMaxSize. Allocates where there is no room for its numbers.
  void load(const Lcp& lcp);

  /// Ends at the first solution. Allocates nothing.
  /// @param deadline_s on wall_clock_s() @param most_systems that are solved before it gives up
  End run(double deadline_s, std::int64_t most_systems);

  /// Whether there is a solution with this support, of which M's block is regular.
  bool solves_with(const std::vector<Index>& support);

  /// Of the solution, ascending.
  const std::vector<Index>& support() const { return support_; }
  /// Entry k of support() in the solution, rounded once.
  double nearest(std::size_t k) { return system_.nearest(k); }

 private:
  void start(std::uint32_t support);
  bool find_with_support(std::uint32_t support);
  bool complete(Index first_row);
  bool is_solution();

  Index n_ = 0;
  Rows rows_;
  System system_;
  std::vector<Index> support_, others_;
  double deadline_s_ = 0;
  std::int64_t most_systems_ = 0;
  std::int64_t systems_ = 0;  // of this run
  End stopped_ = End::kNone;  // by a limit
};

}  // namespace lcpbench::enumeration
