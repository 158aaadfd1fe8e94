#include "native/principal_pivoting/principal_solver.h"

#include "core/timed_solve.h"

namespace lcpbench {

void PrincipalSolver::on_load(const Problem& problem) {
  tableau_.load(make_lcp(problem));
  test_.load(problem);
  const Index n = tableau_.size();
  bounds_.resize(n);
  farkas_.resize(n);
  pivot_limit_ = settings_.max_pivots > 0 ? settings_.max_pivots : std::max<std::int64_t>(1000, n * n);
}

void PrincipalSolver::on_solve(const SolveRequest& request, Answer& answer) {
  answer.counters = {.iterations = -1, .pivots = 0, .factorizations = 0};
  const double deadline_s = wall_clock_s() + request.time_limit_s;
  const End end = run(deadline_s, answer.counters);
  if (end != End::kUnblocked) tableau_.solution(answer.z);
  switch (end) {
    case End::kNonnegative:
      answer.claim = Claim::kSolved;
      test_.settle(answer, deadline_s);
      return;
    case End::kUnblocked: test_.settle_ray(answer, deadline_s, &farkas_); return;
    case End::kNoPivot: answer.detail = no_pivot_; return;
    case End::kSingularBasis: answer.detail = "the basis is singular to working precision"; return;
    case End::kPivotLimit: answer.claim = Claim::kIterationLimit; return;
    case End::kTimeLimit: answer.claim = Claim::kTimeLimit; return;
  }
}

}  // namespace lcpbench
