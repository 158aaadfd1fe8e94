#include "study/run/trials.h"

#include <functional>
#include <numeric>
#include <set>

namespace lcpbench {

std::vector<TrialClass> trial_classes(std::int64_t trials, const std::vector<std::int64_t>& steps) {
  if (trials <= 0 || steps.empty()) return {};
  std::set<std::int64_t, std::greater<>> multiples;  // least common ones of some of the steps, below `trials`
  std::int64_t common = 1;                           // that of all; or else `trials`, which divides trial 0 alone
  for (const std::int64_t step : steps) {
    std::set<std::int64_t, std::greater<>> added;
    if (step < trials) added.insert(step);
    for (const std::int64_t multiple : multiples) {
      const std::int64_t factor = step / std::gcd(multiple, step);
      if (factor <= (trials - 1) / multiple) added.insert(factor * multiple);
    }
    multiples.merge(added);
    const std::int64_t factor = step / std::gcd(common, step);
    common = factor <= (trials - 1) / common ? factor * common : trials;
  }
  multiples.insert(common);
  std::vector<TrialClass> classes;
  for (const std::int64_t multiple : multiples) {
    std::int64_t count = (trials - 1) / multiple;  // trial 0 is counted apart
    for (const TrialClass& above : classes) {
      if (above.multiple % multiple == 0) count -= above.count;
    }
    classes.push_back({multiple, multiple % trials, count});
  }
  ++classes.front().count;  // trial 0, which all steps divide
  std::erase_if(classes, [](const TrialClass& each) { return each.count == 0; });
  return classes;
}

std::int64_t count_trials(std::int64_t trials, const std::vector<std::int64_t>& steps) {
  std::int64_t count = 0;
  for (const TrialClass& each : trial_classes(trials, steps)) count += each.count;
  return count;
}

}  // namespace lcpbench
