#pragma once

#include <cstdint>
#include <memory>

#include "core/solver.h"
#include "native/auto/report.h"

namespace lcpbench {

struct LaterEngines;

/// Whether it has dense matrices only, for which memory can be taken before the problem is known.
inline bool is_dense(AutoMethod method) {
  return method == AutoMethod::kActiveSet || method == AutoMethod::kContactLemke;
}

/// One try at an island. A brief one ends early where the method does not suit: contact_lemke after its first path in
/// double, or at a limit of pivots; friction_ipm after `rounds` convex problems; psor after `sweeps`.
struct AutoTry {
  AutoMethod method = AutoMethod::kActiveSet;
  bool brief = false;
  std::int64_t sweeps = 0;
  std::int64_t rounds = 2;
  bool exact = false;  ///< of psor: takes exact parts
};

/// Residual that a brief psor has to reach, relative to max|q| of each island, where no error is stated: what follows
/// it would reach 1e-9 or less.
inline constexpr double kSweptResidual = 1e-12;

/// A smaller stated error counts as this one: iterative methods in double reach it, as a rule.
inline constexpr double kLeastError = 1e-12;

/// What is left of a solve's limits, and the error that it may leave.
struct AutoLimits {
  double deadline_s = 0;        ///< on wall_clock_s(); infinity: none
  std::int64_t max_pivots = 0;  ///< 0: none
  double error = 0;             ///< 0: none is stated

  /// Seconds left.
  double time() const;
  /// Pivots left when so many are done; meaningless without a limit.
  std::int64_t pivots(const Counters& done) const { return max_pivots - done.pivots; }
  bool exhausted(const Counters& done) const { return max_pivots > 0 && pivots(done) <= 0; }
};

/// At its defaults. @param later what the rungs of contact_lemke beyond double run on
std::unique_ptr<Solver> make_method(AutoMethod method, const std::shared_ptr<LaterEngines>& later);

/// Whether the limits leave nothing for another try. The claim then says so, and z is zero.
bool ends_at_limit(const AutoLimits& limits, const Problem& problem, Answer& answer, const AutoReport& report);

/// Solves what `solver`, which is of this method, has loaded, and counts it in.
/// @param request with what is left of limits.time()
void run_try(const AutoTry& now, Solver& solver, const Problem& problem, const SolveRequest& request,
             const AutoLimits& limits, Answer& answer, AutoReport& report);

/// Whether another method may get where this one did not: it ended neither with an answer nor for a limit of the
/// caller's.
bool gave_up(Claim claim, const AutoLimits& limits, const AutoReport& report);

}  // namespace lcpbench
