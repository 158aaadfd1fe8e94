#pragma once

#include <cstdint>
#include <vector>

namespace lcpbench {

// The trials of a set that a study runs are those that at least one of some steps divides. Nothing here takes time or
// memory that grows with the number of trials.

/// How many of the trials in [0, trials) at least one of the steps divides. By inclusion and exclusion over the least
/// common multiples of the steps. @pre every step >= 1
std::int64_t count_trials(std::int64_t trials, std::vector<std::int64_t> steps);

/// The least common multiple of the steps that divide a trial; 0 for trial 0, which all divide; -1 where none
/// does. A step divides the trial if and only if it divides this number.
std::int64_t common_multiple(std::int64_t trial, const std::vector<std::int64_t>& steps);

/// Trials that the same steps divide.
struct TrialClass {
  std::int64_t multiple = 0;  ///< common_multiple() of each of them
  std::int64_t count = 0;
};

/// The trials in [0, trials) that at least one step divides, by common multiple, ascending: first trial 0 alone.
std::vector<TrialClass> trial_classes(std::int64_t trials, const std::vector<std::int64_t>& steps);

}  // namespace lcpbench
