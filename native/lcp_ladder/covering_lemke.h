#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/lcp.h"
#include "core/quad.h"

namespace lcpbench {

/// Lemke's method on the tableau of a bare LCP, for what the rules of LEMKE do not get through: covering vector 1 on
/// every row, ties of the ratio test broken by a second right-hand side, so that degenerate problems do not cycle, and
/// M scaled from both sides alike by powers of two, which keeps its class.
///
/// Processes any copositive-plus M, and copositive M whose covering vector excludes a ray. O(n^2) per pivot, in double
/// or in 113 bits. [Cottle, Pang, Stone 1992, section 4.4; 4.9 on degeneracy]
class CoveringLemke {
 public:
  static constexpr Index kLargestQuad = 300;

  /// @param lcp must stay as it is until the next load. Allocates about n (n + 3) numbers, touched only in run().
  void load(const Lcp& lcp);

  enum class Cover { kAll, kNegative };  ///< the rows where the covering vector is 1; it is 0 elsewhere
  enum class End { kSolved, kRay, kPivotLimit, kTimeLimit, kBreakdown };

  struct Limits {
    double deadline_s = 0;  ///< on wall_clock_s()
    std::int64_t pivots = 0;
  };

  /// @tparam Scalar double, or Quad up to kLargestQuad rows
  /// @param z n entries, the answer where it ends in kSolved, entries below zero made zero. Allocates nothing
  template <class Scalar>
  End run(Cover cover, const Limits& limits, Vector& z);

  /// Of the last run().
  std::int64_t pivots() const { return pivots_; }

 private:
  template <class Scalar>
  struct Tableau;

  void scale();
  template <class Scalar>
  void fill(Tableau<Scalar>& tableau, Cover cover);
  template <class Scalar>
  Index blocking_row(const Tableau<Scalar>& tableau, Index entering, Index artificial_row) const;
  template <class Scalar>
  Index first_row(const Tableau<Scalar>& tableau) const;
  template <class Scalar>
  void write_solution(const Tableau<Scalar>& tableau, Vector& z) const;

  const Lcp* lcp_ = nullptr;
  Index n_ = 0;
  Index room_ = -1;
  std::unique_ptr<double[]> double_;
  std::unique_ptr<Quad[]> quad_;
  std::vector<int> exponent_;            // n: row and column i times 2^exponent_[i]
  Vector power_;                         // n: that power, where all are well within the range of doubles
  std::vector<Index> basic_, nonbasic_;  // w_i = i, z_i = n + i, artificial = 2 n
  std::int64_t pivots_ = 0;
};

}  // namespace lcpbench
