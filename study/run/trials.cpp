#include "study/run/trials.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace lcpbench {
namespace {

/// The steps without those that another one divides: they add no trial.
void keep_primitive(std::vector<std::int64_t>& steps) {
  std::sort(steps.begin(), steps.end());
  std::vector<std::int64_t> kept;
  for (const std::int64_t step : steps) {
    if (std::none_of(kept.begin(), kept.end(), [step](std::int64_t smaller) { return step % smaller == 0; })) {
      kept.push_back(step);
    }
  }
  steps = std::move(kept);
}

}  // namespace

std::int64_t count_trials(std::int64_t trials, std::vector<std::int64_t> steps) {
  if (trials <= 0 || steps.empty()) return 0;
  keep_primitive(steps);
  std::map<std::int64_t, std::int64_t> signs;  // of each common multiple: how often its multiples are counted
  for (const std::int64_t step : steps) {
    std::map<std::int64_t, std::int64_t> added;
    if (step < trials) added[step] = 1;
    for (const auto& [multiple, sign] : signs) {
      const std::int64_t factor = multiple / std::gcd(multiple, step);
      if (factor <= (trials - 1) / step) added[factor * step] -= sign;
    }
    for (const auto& [multiple, sign] : added) {
      if ((signs[multiple] += sign) == 0) signs.erase(multiple);
    }
  }
  // Every step divides trial 0. It is counted apart, so that multiples beyond the trials need not be kept.
  std::int64_t count = 1;
  for (const auto& [multiple, sign] : signs) count += sign * ((trials - 1) / multiple);
  return count;
}

std::int64_t common_multiple(std::int64_t trial, const std::vector<std::int64_t>& steps) {
  if (trial == 0) return steps.empty() ? -1 : 0;
  std::int64_t multiple = -1;
  for (const std::int64_t step : steps) {
    if (trial % step == 0) multiple = multiple < 0 ? step : std::lcm(multiple, step);
  }
  return multiple;
}

std::vector<TrialClass> trial_classes(std::int64_t trials, const std::vector<std::int64_t>& steps) {
  if (trials <= 0 || steps.empty()) return {};
  std::set<std::int64_t> multiples;
  for (const std::int64_t step : steps) {
    std::set<std::int64_t> added;
    if (step < trials) added.insert(step);
    for (const std::int64_t multiple : multiples) {
      const std::int64_t factor = multiple / std::gcd(multiple, step);
      if (factor <= (trials - 1) / step) added.insert(factor * step);
    }
    multiples.merge(added);
  }
  std::vector<TrialClass> classes{{0, 1}};
  for (const std::int64_t multiple : multiples) classes.push_back({multiple, (trials - 1) / multiple});
  // The largest have no multiples among them; each of the others gives up what those above it have.
  for (auto lower = classes.rbegin(); lower + 1 != classes.rend(); ++lower) {
    for (auto upper = classes.rbegin(); upper != lower; ++upper) {
      if (upper->multiple % lower->multiple == 0) lower->count -= upper->count;
    }
  }
  std::erase_if(classes, [](const TrialClass& each) { return each.count == 0; });
  return classes;
}

}  // namespace lcpbench
