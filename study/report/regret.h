#pragma once

#include <array>
#include <span>
#include <vector>

#include "study/store/sqlite.h"
#include "study/summary/summary.h"

namespace lcpbench::report {

/// The regret of `auto`: how many times as long it takes as the fastest solver of the same problem, for each of some
/// target errors (docs/howto/report.md#regret-of-auto). `auto` is the one with the largest stated error up to the
/// target. The fastest is among the answers that were said to be solved and have at most this error.
/// Gathered while the answers are read: a query would look each answer up in three tables.
class Regrets {
 public:
  /// Adds the problems of a set; once for each set. O(answers).
  /// @param cells  all of the set, with their outcomes
  void add(const Summary& summary, std::size_t problems, std::span<const Cell> cells);

  /// Makes the temporary table `regrets` (target, place: a running number, ratio). The ratio is NULL where a timed
  /// answer of some solver was within the target, and none of `auto`.
  void fill_table(sqlite::Database& database) const;

 private:
  static constexpr std::array kTargets{1e-9, 1e-6, 1e-4, 1e-2};
  std::array<std::vector<double>, kTargets.size()> ratios_;
};

}  // namespace lcpbench::report
