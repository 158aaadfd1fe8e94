#include "native/auto/methods.h"

#include <cmath>
#include <string_view>

#include "core/timed_solve.h"
#include "native/active_set/active_set.h"
#include "native/contact_lemke/contact_lemke.h"

namespace lcpbench {

double AutoLimits::time() const { return std::isinf(deadline_s) ? deadline_s : deadline_s - wall_clock_s(); }

void run_method(AutoMethod method, Solver& solver, const SolveRequest& request, const AutoLimits& limits,
                Answer& answer, AutoReport& report) {
  const bool in_time = request.time_limit_s > 0;
  if (!in_time || limits.exhausted(report.counters())) {
    answer.claim = in_time ? Claim::kIterationLimit : Claim::kTimeLimit;
    answer.z.setZero();
    return;
  }
  const std::int64_t pivots = limits.max_pivots > 0 ? limits.pivots(report.counters()) : 0;
  switch (method) {
    case AutoMethod::kActiveSet:
      ++report.active_set;
      static_cast<ActiveSet&>(solver).limit_iterations(pivots);
      break;
    case AutoMethod::kContactLemke:
      ++report.contact_lemke;
      static_cast<ContactLemke&>(solver).limit_pivots(pivots);
      break;
    case AutoMethod::kVelocityIpm: ++report.velocity_ipm; break;
    case AutoMethod::kFrictionIpm: ++report.friction_ipm; break;
  }
  solver.solve(request, answer);
  report.add(answer.counters, is_sparse(method) ? std::string_view() : std::string_view(answer.detail));
}

bool gave_up(Claim claim, std::int64_t max_pivots) {
  return claim == Claim::kNumericalFailure || claim == Claim::kUnsupported ||
         (claim == Claim::kIterationLimit && max_pivots == 0);
}

}  // namespace lcpbench
