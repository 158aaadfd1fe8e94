#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/lcp.h"
#include "core/quad.h"

namespace lcpbench {

/// Lemke's method on the full tableau, for bare LCPs on which the solver `lemke`, with the rules of the program LEMKE,
/// fails. Ties of the ratio test are broken by a second right-hand side, which makes cycling unlikely; the limit on
/// pivots ends it. M is scaled from both sides alike by powers of two, which keeps its class.
///
/// With Cover::kAll, in exact arithmetic and without cycling, the path of a copositive-plus M ends in a solution, or in
/// a ray that proves that there is none; that of a copositive M ends in a solution if q'u >= 0 for every solution u of
/// LCP(0, M). With Cover::kNegative nothing is guaranteed. O(n^2) per pivot, in double or in 113 bits. [Cottle, Pang,
/// Stone 1992, section 4.4; 4.9 on degeneracy]
class CoveringLemke {
 public:
  static constexpr Index kLargestQuad = 300;

  /// @param lcp must stay as it is until the next load. Takes memory for n (n + 3) doubles, and as many Quads up to
  /// kLargestQuad rows, touched only in run().
  void load(const Lcp& lcp);

  /// The rows where the covering vector is 1: all, or those with q < 0. It is 0 elsewhere.
  enum class Cover { kAll, kNegative };
  /// kSolved: the artificial variable left the basis, or q >= 0; z is not tested. kBreakdown: z is not finite.
  enum class End { kSolved, kRay, kPivotLimit, kTimeLimit, kBreakdown };

  struct Limits {
    double deadline_s = 0;  ///< on wall_clock_s()
    std::int64_t pivots = 0;
  };

  /// @tparam Scalar double, or Quad up to kLargestQuad rows
  /// @param z n entries: at kSolved the solution, with negative entries made zero; not finite at kBreakdown; else zero.
  /// Allocates nothing
  template <class Scalar>
  End run(Cover cover, const Limits& limits, Vector& z);

  /// Of the last run().
  std::int64_t pivots() const { return pivots_; }

 private:
  template <class Scalar>
  struct Tableau;

  void scale();
  int exponent_of_q() const;
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
  Index room_ = -1, quad_room_ = -1;  // the largest n that double_ and quad_ hold
  std::unique_ptr<double[]> double_;
  std::unique_ptr<Quad[]> quad_;
  std::vector<int> exponent_;            // n: row and column i times 2^exponent_[i]
  Vector power_;                         // n: that power, where all are well within the range of doubles
  std::vector<Index> basic_, nonbasic_;  // w_i = i, z_i = n + i, artificial = 2 n
  std::int64_t pivots_ = 0;
};

}  // namespace lcpbench
