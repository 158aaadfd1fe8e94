#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "core/solver.h"
#include "native/auto/bare_lcp.h"

namespace lcpbench {

/// Solves a bare LCP: each block of rows that M connects with no others by itself. Pairs of rows that are a free
/// unknown, written as the difference of two, are eliminated first; if that gives no solution, the problem is solved as
/// it is.
class BareBlocks final : public Solver {
 public:
  /// @param joins_pairs free unknowns are looked for
  explicit BareBlocks(bool joins_pairs = true) : joins_pairs_(joins_pairs) {}
  const Capabilities& capabilities() const override;

 private:
  void on_load(const Problem& problem) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

  bool solve_with_free_unknowns(const SolveRequest& request, Answer& answer);
  void solve_blocks(double deadline_s, Answer& answer);

  BareLcp lcp_;
  std::vector<std::vector<Index>> blocks_;  ///< rows of each; empty: they are all one
  const bool joins_pairs_;
  std::vector<std::pair<Index, Index>> pairs_;
  std::unique_ptr<BareBlocks> free_;  ///< solves it with free unknowns in the place of pairs_
  std::vector<Index> of_free_;        ///< the row of each row of free_'s problem
  Answer part_;
};

}  // namespace lcpbench
