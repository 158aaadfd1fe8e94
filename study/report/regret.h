#pragma once

#include <array>
#include <span>
#include <vector>

#include "study/store/sqlite.h"
#include "study/summary/summary.h"

namespace lcpbench::report {

/// What it costs to take `auto`: its times over those of the fastest answer to the same problem. Gathered while the
/// answers are read: a query would look each answer up in three tables.
class Regrets {
 public:
  /// Adds the problems of a set. O(answers).
  /// @param cells  of the set, with their outcomes
  void add(const Summary& summary, std::size_t problems, std::span<const Cell> cells);

  /// Makes the temporary table `regrets` (target, place, ratio); NULL where others answered within the error and `auto` did not.
  void fill_table(sqlite::Database& database) const;

 private:
  static constexpr std::array kTargets{1e-9, 1e-6, 1e-4, 1e-2};
  std::array<std::vector<double>, kTargets.size()> ratios_;
};

}  // namespace lcpbench::report
