#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace lcpbench {

// The trials of a set that a study runs are those that at least one of some steps divides. A shard runs those among
// them that leave its number as remainder. Nothing here takes time or memory that grows with the number of trials.

/// The numbers first, first + period, first + 2 period, ...
struct Progression {
  std::int64_t first = 0;  ///< in [0, period)
  std::int64_t period = 1;

  /// The smallest of them that is at least `from`. @pre from >= 0
  std::int64_t next(std::int64_t from) const;
  /// How many of them lie in [0, end).
  std::int64_t count(std::int64_t end) const;
};

/// The multiples of `step` that leave the remainder `shard` modulo `shards`; nullopt where there are none.
/// @pre step >= 1, 0 <= shard < shards, and step shards < 2^63.
std::optional<Progression> multiples_in_shard(std::int64_t step, std::int64_t shard, std::int64_t shards);

/// How many of the trials in [0, trials) at least one of the steps divides and belong to the shard. By inclusion and
/// exclusion over the least common multiples of the steps.
/// @pre as above for every step, and for `trials` in place of `step`.
std::int64_t count_trials(std::int64_t trials, std::vector<std::int64_t> steps, std::int64_t shard = 0,
                          std::int64_t shards = 1);

}  // namespace lcpbench
