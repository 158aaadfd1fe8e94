// Scenes of the size that sparse solvers are for. Slow: the evaluation alone takes seconds.
#include <gtest/gtest.h>

#include "study/evaluation/evaluation.h"
#include "study/run/open_solver.h"
#include "tests/support/brick_wall.h"

namespace lcpbench {
namespace {

Answer solve(const std::string& solver, const Problem& problem) {
  TimedAnswer result;
  open_solver(parse_spec(solver))->run(problem, {.time_limit_s = 600}, result);
  return result.answer;
}

TEST(LargeScenesTest, AHundredThousandContactsInThisProcessAndThroughAWorker) {
  const Problem wall("wall", testing::brick_wall(100, 126));
  ASSERT_GE(wall.size(), 99000);
  for (const char* solver : {"velocity_ipm", "velocity_ipm_cholmod"}) {
    if (!why_unavailable(find_solver(solver)).empty()) continue;
    const Answer answer = solve(solver, wall);
    ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
    EXPECT_LE(answer.counters.iterations, 25);
    EXPECT_LE(Evaluator(wall).errors(answer).velocity_residual_relative, 1e-10);
  }
}

}  // namespace
}  // namespace lcpbench
