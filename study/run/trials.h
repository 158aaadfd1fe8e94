#pragma once

#include <cstdint>
#include <vector>

namespace lcpbench {

// The trials of a set that a study runs are those that at least one of some steps divides. Time grows with the least
// common multiple of the steps, or with the number of trials where that is less.

/// Trials that the same steps divide.
struct TrialClass {
  std::int64_t multiple = 0;  ///< the greatest multiple of a class that divides them
  std::int64_t trial = 0;     ///< one of them
  std::int64_t count = 0;
};

/// The trials in [0, trials) that at least one step divides, by falling multiple: a trial is of the first class
/// whose multiple divides it. @pre every step >= 1
std::vector<TrialClass> trial_classes(std::int64_t trials, const std::vector<std::int64_t>& steps);

/// How many of the trials in [0, trials) at least one of the steps divides. @pre every step >= 1
std::int64_t count_trials(std::int64_t trials, const std::vector<std::int64_t>& steps);

}  // namespace lcpbench
