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

TEST(LargeScenesTest, AHundredThousandContactsInThisProcess) {
  const Problem wall("wall", testing::brick_wall(100, 126));
  ASSERT_GE(wall.size(), 99000);
  const Answer answer = solve("velocity_ipm", wall);
  ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_LE(answer.counters.iterations, 25);
  EXPECT_LE(Evaluator(wall).errors(answer).velocity_residual_relative, 1e-10);
}

TEST(LargeScenesTest, AHundredThousandContactsThroughAWorker) {
  const std::string why = why_unavailable(find_solver("velocity_ipm_cholmod"));
  if (!why.empty()) GTEST_SKIP() << why;
  const Problem wall("wall", testing::brick_wall(100, 126));
  const Answer answer = solve("velocity_ipm_cholmod", wall);
  ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_LE(answer.counters.iterations, 25);
  EXPECT_LE(Evaluator(wall).errors(answer).velocity_residual_relative, 1e-10);
}

TEST(LargeScenesTest, FourThousandContactsWithFriction) {
  const Problem wall("wall", testing::frictional_brick_wall(21, 27, 0.5));
  ASSERT_GE(wall.contact()->nc(), 4000);
  const Answer answer = solve("friction_ipm", wall);
  ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_LE(Evaluator(wall).errors(answer).velocity_residual_relative, 1e-8);
}

}  // namespace
}  // namespace lcpbench
