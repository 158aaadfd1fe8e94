#include "study/run/trials.h"

#include <algorithm>
#include <functional>
#include <map>
#include <numeric>

namespace lcpbench {

std::vector<TrialClass> trial_classes(std::int64_t trials, const std::vector<std::int64_t>& steps) {
  if (trials <= 0 || steps.empty()) return {};
  std::int64_t period = 1;  // after so many trials the same steps divide again; at most `trials`
  for (const std::int64_t step : steps) {
    const std::int64_t factor = step / std::gcd(period, step);
    period = factor <= trials / period ? factor * period : trials;
  }
  std::map<std::int64_t, std::int64_t, std::greater<>> counts{{period, (trials - 1) / period + 1}};  // by multiple
  for (std::int64_t trial = 1; trial < period; ++trial) {
    std::int64_t multiple = 0;
    for (const std::int64_t step : steps) {
      if (trial % step == 0) multiple = std::lcm(std::max<std::int64_t>(multiple, 1), step);
    }
    if (multiple > 0) counts[multiple] += (trials - 1 - trial) / period + 1;
  }
  std::vector<TrialClass> classes;
  for (const auto& [multiple, count] : counts) classes.push_back({multiple, multiple == period ? 0 : multiple, count});
  return classes;
}

std::int64_t count_trials(std::int64_t trials, const std::vector<std::int64_t>& steps) {
  std::int64_t count = 0;
  for (const TrialClass& each : trial_classes(trials, steps)) count += each.count;
  return count;
}

}  // namespace lcpbench
