#pragma once

#include <csignal>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/spec.h"
#include "study/store/store.h"

namespace lcpbench {

struct BenchPlan {
  std::vector<std::string> sets;  ///< names or globs
  std::vector<Spec> solvers;
  Spec reference;
  std::int64_t problems = 200;  ///< of each set
  std::uint64_t seed = 1;
  double time_limit_s = 10.0;
  double repeat_until_s = 2e-4;
  /// Set to non-zero from outside (a signal handler): no problem is begun any more.
  const volatile std::sig_atomic_t* stop = nullptr;
};

/// One solver against the reference on one set. Times are thread CPU time of set-up and solve together [s]: what it
/// takes from the problem's data to the answer. NaN where no problem was timed.
struct BenchCell {
  std::string set;
  SolverRow solver;
  std::int64_t problems = 0;  ///< that were solved
  std::int64_t timed = 0;     ///< problems on which this answer and the reference's were both verified
  double speedup_mean = 0;    ///< summed time of the reference / summed time of the solver
  double speedup_low = 0;     ///< 95 % bootstrap interval of it over problems
  double speedup_high = 0;
  double speedup_geomean = 0;  ///< geometric mean of the ratios
  double reference_mean_s = 0;
  double solver_mean_s = 0;
};

/// Times solvers against the reference, in one thread, interleaved problem by problem: the reference and all solvers in
/// order, then in reverse order, each the mean of its two times, so that drifts cancel. Both sides run at the
/// instruction-set level of this process. An answer counts as verified when its verdict is solved, both times.
/// @param on_set called with each set's name before it is run
/// @returns the cells of every set that was begun, each with the problems that were solved until `stop`
/// @throws InputError for unknown sets and solvers that are not available.
std::vector<BenchCell> run_bench(const BenchPlan& plan, const std::function<void(const std::string&)>& on_set);

}  // namespace lcpbench
