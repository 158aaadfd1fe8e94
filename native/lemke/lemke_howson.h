#pragma once

#include <cstdint>
#include <vector>

#include "core/lcp.h"

namespace lcpbench {

/// Solves the LCP of a bimatrix game: M = [0 A; B 0] but for the order of its rows, no entry negative, and q < 0. A and B
/// are the costs of two players; a solution, scaled, is an equilibrium. Every game has one, and Lemke's method, whose
/// covering vector has no part in the game, may end in a ray all the same. The path of Lemke and Howson drops the
/// complementarity of one pair, and cannot: it begins at a vertex that two pivots reach. On the full tableau, in double.
/// Answers are not tested. [Lemke, Howson 1964; Cottle, Pang, Stone 1992, section 4.4.21]
class LemkeHowson {
 public:
  static constexpr Index kLargest = 1000;
  enum class End { kSolved, kFailed, kTimeLimit };

  /// Whether the LCP is one of a game. Takes memory for n (n + 2) doubles. O(n^2)
  bool load(const Lcp& lcp);

  /// The path that drops pair `dropped`. @param z  n entries: at kSolved the solution, with negative entries made zero
  /// @param deadline_s  on wall_clock_s()
  End run(Index dropped, std::int64_t most_pivots, double deadline_s, Vector& z);

  /// Of the last run().
  std::int64_t pivots() const { return pivots_; }

 private:
  void fill();
  void exchange(Index row, Index column);
  Index last_to_rise(Index column, bool side) const;
  Index first_to_fall(Index column) const;

  const Lcp* lcp_ = nullptr;
  std::vector<bool> side_;      // of each row
  Matrix tableau_;              // basic = constants + tableau times nonbasic: n columns, q, and what breaks ties
  Eigen::RowVectorXd entering_;
  std::vector<Index> basic_, nonbasic_;  // w_i = i, z_i = n + i
  std::int64_t pivots_ = 0;
};

}  // namespace lcpbench
