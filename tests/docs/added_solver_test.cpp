// The solver that docs/howto/adding-a-solver.md has its reader write compiles, solves, and says so when it cannot.
#include <gtest/gtest.h>

#include "core/registry.h"

namespace lcpbench {

SolverDefinition lcpbench_solver_gauss_seidel();

namespace {

Answer solved(const Options& options) {
  Matrix M(2, 2);
  M << 2, 1, 1, 2;
  Vector q(2);
  q << -5, -6;
  const auto solver = lcpbench_solver_gauss_seidel().make(options);
  solver->load(Problem("two unknowns", Lcp{.M = M, .q = q}));
  Answer answer;
  solver->solve({}, answer);
  return answer;
}

TEST(AddedSolverTest, SolvesTheExampleOfTheProblemFile) {
  const Answer answer = solved({});
  EXPECT_EQ(answer.claim, Claim::kSolved);
  ASSERT_EQ(answer.z.size(), 2);
  EXPECT_NEAR(answer.z(0), 4.0 / 3, 1e-9);
  EXPECT_NEAR(answer.z(1), 7.0 / 3, 1e-9);
}

TEST(AddedSolverTest, DoesNotClaimWhatItDidNotReach) {
  EXPECT_EQ(solved({{"max_iterations", "1"}}).claim, Claim::kIterationLimit);
}

}  // namespace
}  // namespace lcpbench
