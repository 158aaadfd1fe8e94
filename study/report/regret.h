#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <nlohmann/json.hpp>

#include "study/summary/summary.h"

namespace lcpbench::report {

/// What it costs to take `auto`: its times over those of the fastest answer to the same problem. Gathered while the
/// answers are read: a query would look each answer up in three tables.
class Regrets {
 public:
  /// Adds the problems of a set. O(answers).
  /// @param cells  of the set, with their outcomes
  void add(const Summary& summary, std::size_t problems, std::span<const Cell> cells);

  /// One record for each error, ascending: see tables/regret.sql.
  nlohmann::ordered_json records() const;

 private:
  struct AtTarget {
    std::vector<double> ratios;
    std::int64_t large = 0;   ///< ratios above 3
    std::int64_t missed = 0;  ///< problems that others answered within the error
  };
  static constexpr std::array kTargets{1e-9, 1e-6, 1e-4, 1e-2};
  std::array<AtTarget, kTargets.size()> at_;
};

}  // namespace lcpbench::report
