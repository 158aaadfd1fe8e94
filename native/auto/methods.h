#pragma once

#include <cstdint>

#include "core/solver.h"
#include "native/auto/report.h"

namespace lcpbench {

/// What `auto` chooses among for contacts.
enum class AutoMethod { kActiveSet, kContactLemke, kVelocityIpm, kFrictionIpm };

inline bool is_sparse(AutoMethod method) {
  return method == AutoMethod::kVelocityIpm || method == AutoMethod::kFrictionIpm;
}

/// What is left of a solve's limits.
struct AutoLimits {
  double deadline_s = 0;        ///< on wall_clock_s(); infinity: none
  std::int64_t max_pivots = 0;  ///< 0: none

  /// Seconds left.
  double time() const;
  /// Pivots left when so many are done; meaningless without a limit.
  std::int64_t pivots(const Counters& done) const { return max_pivots - done.pivots; }
  bool exhausted(const Counters& done) const { return max_pivots > 0 && pivots(done) <= 0; }
};

/// Solves what `solver`, which is of this method, has loaded, and counts it in. Where the limits leave nothing the
/// claim says so, and z is zero. @param request with what is left of limits.time()
void run_method(AutoMethod method, Solver& solver, const SolveRequest& request, const AutoLimits& limits,
                Answer& answer, AutoReport& report);

/// Whether another method may get where this one did not: it ended neither with an answer nor for a limit of the
/// caller's.
bool gave_up(Claim claim, std::int64_t max_pivots);

/// Whether the solver takes a problem of this size; else load() is refused, and update() must not be called.
inline bool takes(const Solver& solver, const Problem& problem) {
  return problem.size() <= solver.capabilities().max_size;
}

}  // namespace lcpbench
