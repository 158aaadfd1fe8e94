#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "study/report/reliability.h"
#include "study/summary/summary.h"
#include "study/store/store.h"

namespace lcpbench::report {

/// Errors at which `auto` is compared with the fastest solver.
inline constexpr std::array kRegretTargets{1e-2, 1e-4, 1e-6, 1e-9};

/// A regret above this is a large one.
inline constexpr double kLargeRegret = 3;

/// One problem at one target: `auto` beside the fastest solver that claimed an answer of at most this error.
struct Regret {
  std::size_t set = 0;  ///< index into Summary::sets
  std::uint64_t seed = 0;
  std::int64_t trial = 0;
  double target = 0;
  std::size_t solver = 0;   ///< `auto` as it is set for this target; index into Summary::solvers
  std::size_t fastest = 0;  ///< may be `auto` itself
  double time_s = 0;        ///< of `auto`; NaN where it did not reach the target
  double fastest_s = 0;
  std::string methods;  ///< that `auto` ran, see methods_of()

  bool reached() const { return time_s == time_s; }
  double value() const { return time_s / fastest_s; }
};

/// Regrets of several problems at one target.
struct RegretStatistics {
  double target = 0;
  std::int64_t problems = 0;  ///< on which some solver reached the target
  Estimate geometric_mean;    ///< of those on which `auto` did; the interval is normal on the scale of the logarithms
  double p99 = 0;
  double max = 0;
  Share large;   ///< above kLargeRegret, of those that `auto` reached
  Share missed;  ///< that `auto` did not reach
};

/// What some methods of `auto` cost at one target.
struct MethodRegret {
  std::string methods;
  RegretStatistics statistics;
  double share_of_loss = 0;  ///< of the sum of log(regret) over all problems at this target; NaN where that is 0
};

/// How far `auto` is from the fastest solver of a store.
struct RegretStudy {
  std::vector<Regret> regrets;  ///< by target, set and problem
  std::vector<RegretStatistics> targets;
  std::vector<std::vector<MethodRegret>> methods;  ///< for each of `targets`, the largest share of the loss first
};

/// The methods in a detail of `auto`, without counts and precision: "contact_lemke", "friction_ipm + contact_lemke",
/// "several islands: active_set + contact_lemke", "at rest"; "no method" for "". Another text comes back as it is.
std::string methods_of(std::string_view detail);

/// @param regrets of one target
RegretStatistics regret_statistics(double target, const std::vector<const Regret*>& regrets);

/// At each target `auto` is the one with the largest stated error up to it (`error`, 0 where none is stated), and no
/// other setting. It is compared with every solver at single settings that solves the problem's own friction model,
/// native ones at the same instruction-set level. Proven unsolvable problems and untimed answers do not count. Empty
/// where the store has no `auto`. O(answers), and one look into the store for each problem.
RegretStudy regret_study(Store& store, const Summary& summary);

/// regret.csv: one record for each problem and target.
nlohmann::ordered_json regret_json(const Summary& summary, const std::vector<Regret>& regrets);

/// `regret` of summary.json: the statistics of each target, and what the methods cost.
nlohmann::ordered_json regret_summary_json(const RegretStudy& study);

}  // namespace lcpbench::report
