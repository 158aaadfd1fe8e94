#include "study/run/trials.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace lcpbench {
namespace {

/// x with a x = 1 modulo m, by the extended Euclidean algorithm. @pre a and m have no common divisor
std::int64_t inverse(std::int64_t a, std::int64_t m) {
  std::int64_t remainder = m;
  std::int64_t next_remainder = a % m;
  std::int64_t x = 0;
  std::int64_t next_x = 1;
  while (next_remainder != 0) {
    const std::int64_t quotient = remainder / next_remainder;
    x = std::exchange(next_x, x - quotient * next_x);
    remainder = std::exchange(next_remainder, remainder - quotient * next_remainder);
  }
  return (x % m + m) % m;
}

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

std::int64_t Progression::next(std::int64_t from) const {
  const std::int64_t past = from % period;
  return from - past + (past <= first ? first : first + period);
}

std::int64_t Progression::count(std::int64_t end) const { return first < end ? (end - 1 - first) / period + 1 : 0; }

std::optional<Progression> multiples_in_shard(std::int64_t step, std::int64_t shard, std::int64_t shards) {
  // step k = shard (mod shards) is solvable when their greatest common divisor divides `shard`.
  const std::int64_t divisor = std::gcd(step, shards);
  if (shard % divisor != 0) return std::nullopt;
  const std::int64_t modulus = shards / divisor;
  const std::int64_t k = shard / divisor % modulus * inverse(step / divisor, modulus) % modulus;
  return Progression{step * k, step * modulus};
}

std::int64_t count_trials(std::int64_t trials, std::vector<std::int64_t> steps, std::int64_t shard,
                          std::int64_t shards) {
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
  std::int64_t count = shard == 0 ? 1 : 0;
  for (const auto& [multiple, sign] : signs) {
    const std::optional<Progression> members = multiples_in_shard(multiple, shard, shards);
    if (members) count += sign * (members->count(trials) - (members->first == 0 ? 1 : 0));
  }
  return count;
}

}  // namespace lcpbench
