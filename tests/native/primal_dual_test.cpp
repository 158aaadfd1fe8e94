#include <cmath>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench {
SolverDefinition lcpbench_solver_primal_dual();
}

namespace lcpbench::primal_dual_test {
namespace {

using testing::TextbookLcp;
using testing::Uniform;

Answer solve(const Problem& problem, const Options& options = {}, const SolveRequest& request = {}) {
  const auto solver = lcpbench_solver_primal_dual().make(options);
  solver->load(problem);
  Answer answer;
  solver->solve(request, answer);
  return answer;
}

Answer solve(const Lcp& lcp, const Options& options = {}) { return solve(Problem("case", lcp), options); }

/// Symmetric, eigenvalues in [1, 3], with a planted solution.
Lcp well_conditioned(Index n, Vector& z) {
  Uniform uniform(7);
  const Matrix A = uniform.matrix(n, n);
  return testing::plant(A * A.transpose() / static_cast<double>(n) + Matrix::Identity(n, n), uniform.vector(n), z);
}

class PrimalDualOnTextbookLcps : public ::testing::TestWithParam<TextbookLcp> {};

TEST_P(PrimalDualOnTextbookLcps, SolvesMonotoneOnesAndClaimsNoOther) {
  const TextbookLcp& textbook = GetParam();
  const Answer answer = solve(textbook.lcp);
  if (!textbook.solvable) {
    EXPECT_NE(answer.claim, Claim::kSolved);
    return;
  }
  if (textbook.monotone) {
    EXPECT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  }
  if (answer.claim == Claim::kSolved) {
    EXPECT_LE(testing::relative_residual(textbook.lcp, answer.z), 1e-8) << answer.z.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(All, PrimalDualOnTextbookLcps, ::testing::ValuesIn(testing::textbook_lcps()),
                         [](const auto& test) { return test.param.name; });

TEST(PrimalDualTest, FindsThePlantedSolutionInAFewStepsWhateverTheSize) {
  for (const Index n : {1, 5, 20, 80}) {
    Vector z;
    const Lcp lcp = well_conditioned(n, z);
    const Answer answer = solve(lcp);
    ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
    EXPECT_LE((answer.z - z).lpNorm<Eigen::Infinity>(), 1e-12) << "n = " << n;
    const Answer untested = solve(lcp, {{"test", "none"}});  // y and its multiplier are both about sqrt(eps) = 1e-7
    EXPECT_EQ(untested.claim, Claim::kSolved);
    EXPECT_LE((untested.z - z).lpNorm<Eigen::Infinity>(), 1e-6) << "n = " << n;
    EXPECT_EQ(untested.counters.iterations, answer.counters.iterations) << "n = " << n;
    EXPECT_LE(answer.counters.iterations, 50) << "n = " << n;
    EXPECT_EQ(answer.counters.factorizations, answer.counters.iterations) << "n = " << n;
  }
}

TEST(PrimalDualTest, ATighterGapCostsStepsAndGainsAccuracy) {
  Vector z;
  const Lcp lcp = well_conditioned(20, z);
  const Answer loose = solve(lcp, {{"eps", "1e-6"}, {"accept_residual", "1"}, {"test", "none"}});
  const Answer tight = solve(lcp, {{"eps", "1e-14"}, {"test", "none"}});
  EXPECT_LT(loose.counters.iterations, tight.counters.iterations);
  EXPECT_GT((loose.z - z).norm(), 10 * (tight.z - z).norm());
}

// On active rows the program of the paper leaves y and its multiplier both at zero, z'w leaves one of them positive.
TEST(PrimalDualTest, TheComplementarityObjectiveIsMoreAccurateAtTheSameGap) {
  Vector z;
  const Lcp lcp = well_conditioned(20, z);
  const Answer work = solve(lcp, {{"test", "none"}});
  const Answer complementarity = solve(lcp, {{"objective", "complementarity"}, {"test", "none"}});
  ASSERT_EQ(complementarity.claim, Claim::kSolved);
  EXPECT_LE((complementarity.z - z).norm(), 1e-2 * (work.z - z).norm());
}

TEST(PrimalDualTest, SaysWhenItsToleranceWasOutOfReach) {
  Vector z;
  const Lcp lcp = well_conditioned(20, z);
  const Answer answer = solve(lcp, {{"eps", "0"}, {"eps_feas", "0"}});  // the gap of an interior point is positive
  EXPECT_EQ(answer.claim, Claim::kSolved);
  EXPECT_EQ(answer.detail.rfind("no step reduces the residual further; ", 0), 0U) << answer.detail;
  EXPECT_LE((answer.z - z).norm(), 1e-6);
  EXPECT_LE(answer.counters.iterations, 100);
}

TEST(PrimalDualTest, ClaimsNothingItsOwnResidualDoesNotBear) {
  Vector z;
  const Lcp lcp = well_conditioned(20, z);
  EXPECT_EQ(solve(lcp, {{"accept_residual", "1e-12"}}).claim, Claim::kNumericalFailure);
}

TEST(PrimalDualTest, StopsAtItsLimits) {
  Vector z;
  const Lcp lcp = well_conditioned(20, z);
  const Answer three_steps = solve(lcp, {{"max_iterations", "3"}});
  EXPECT_EQ(three_steps.claim, Claim::kIterationLimit);
  EXPECT_EQ(three_steps.counters.iterations, 3);
  EXPECT_EQ(solve(Problem("case", lcp), {}, {.time_limit_s = 0}).claim, Claim::kTimeLimit);
}

TEST(PrimalDualTest, TheShiftSolvesTheShiftedProblem) {
  Lcp lcp{testing::matrix_of(2, {2, 0, 0, 4}), testing::vector_of({-2, -4})};
  const Answer answer =
      solve(lcp, {{"diagonal_shift", "0.25"}, {"accept_residual", "1"}, {"test", "none"}});  // + 1 on the diagonal
  EXPECT_NEAR(answer.z(0), 2.0 / 3, 1e-6);
  EXPECT_NEAR(answer.z(1), 4.0 / 5, 1e-6);
  EXPECT_EQ(solve(lcp, {{"diagonal_shift", "0.25"}}).claim, Claim::kNumericalFailure);  // judged on M as given
}

// A particle in the plane hits the ground with v = (3, -4) and mu = 1/2: it slides on, f_N = 4, friction mu f_N.
TEST(PrimalDualTest, FrictionIsOutsideItsClassButNeverFalselySolved) {
  ContactProblem particle;
  particle.v = testing::vector_of({3, -4});
  particle.N = Matrix(testing::vector_of({0, 1}));
  particle.D = Matrix(testing::matrix_of(2, {1, -1, 0, 0}));
  particle.edges = {2};
  particle.mu = testing::vector_of({0.5});
  particle.inertia = DenseInertia{Matrix::Identity(2, 2)};
  const Answer answer = solve(Problem("particle", particle));
  if (answer.claim == Claim::kSolved) {
    EXPECT_NEAR(answer.z(0), 4, 1e-4);
    EXPECT_NEAR(answer.z(2) - answer.z(1), 2, 1e-4);
  }
  Uniform uniform(11);
  for (int trial = 0; trial < 200; ++trial) {
    const Index n = uniform.integer(1, 6);
    const Lcp any{uniform.matrix(n, n), uniform.vector(n)};
    const Answer claimed = solve(any);
    if (claimed.claim == Claim::kSolved) {
      ASSERT_LE(testing::relative_residual(any, claimed.z), 1.001e-4);
    }
  }
}

TEST(PrimalDualTest, UpdateSolvesForTheNewVelocity) {
  ContactProblem ball;
  ball.v = testing::vector_of({-1});
  ball.N = Matrix(Matrix::Ones(1, 1));
  ball.D = Matrix(1, 0);
  ball.edges = {0};
  ball.mu = Vector::Zero(1);
  ball.inertia = DenseInertia{2 * Matrix::Identity(1, 1)};
  const auto solver = lcpbench_solver_primal_dual().make({});
  solver->load(Problem("ball", ball));
  Answer answer;
  solver->solve({}, answer);
  EXPECT_NEAR(answer.z(0), 2, 1e-6);  // m v
  solver->update(testing::vector_of({-3}));
  solver->solve({}, answer);
  EXPECT_NEAR(answer.z(0), 6, 1e-6);
}

}  // namespace
}  // namespace lcpbench::primal_dual_test
