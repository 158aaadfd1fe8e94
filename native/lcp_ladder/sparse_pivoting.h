#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/SparseLU>

#include "core/lcp.h"

namespace lcpbench {

/// Solves a bare LCP whose M has few nonzeros, and few after elimination, by block principal pivoting: every z_i and
/// w_i that is negative changes sides; where that has not made fewer of them for kChances steps, only the last one does
/// [Murty 1974] until there are fewer. Each step factors the block of the basic z anew. In exact arithmetic finite for
/// P-matrices [Kostreva 1978; Judice, Pires 1994]; mostly some ten steps, whatever n. The work of all steps is limited
/// (kWork). Answers are not tested.
class SparsePivoting {
 public:
  enum class End { kSolved, kSingular, kWorkLimit, kTimeLimit };

  struct Counts {
    std::int64_t steps = 0;           ///< bases whose z and w were computed
    std::int64_t factorizations = 0;  ///< of blocks of basic z; without basic z there is none
    std::int64_t exchanges = 0;       ///< of z_i and w_i
    std::int64_t single = 0;          ///< steps that exchanged one pair only, because the blocks made no progress
  };

  /// Whether M is taken: n >= kLeast, a positive diagonal, and at most n^2 / kSparse nonzeros both in M and below the
  /// diagonal of its factor (of M + M', without cancellation). Stops reading M at one too many. O(n^2), memory in
  /// proportion to the factor.
  bool load(const Lcp& lcp);

  /// Allocates. @param z n entries, the basic solution where it ends with kSolved
  /// @param deadline_s on wall_clock_s()
  End run(double deadline_s, Vector& z);

  const Counts& counts() const { return counts_; }

  static constexpr Index kLeast = 200;
  static constexpr Index kSparse = 32;

 private:
  using Factors = Eigen::SparseLU<SparseMatrix, Eigen::NaturalOrdering<SparseMatrix::StorageIndex>>;

  bool find_basic_solution();
  void find_negative();

  SparseMatrix M_, sizes_;    // M and |M| in an order in which elimination makes few nonzeros
  Vector q_;                  // in that order
  std::vector<Index> row_;    // in the problem, of each row in that order
  Vector z_, w_;              // of the present basis
  std::vector<char> basic_;   // n: z_i is
  std::vector<Index> block_;  // the i with basic z_i
  std::vector<Index> negative_;
  std::int64_t work_ = 0;
  Counts counts_;
};

}  // namespace lcpbench
