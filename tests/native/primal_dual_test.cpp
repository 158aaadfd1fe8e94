#include <string>

#include <gtest/gtest.h>

#include "core/timed_solve.h"
#include "tests/support/solving.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench::primal_dual_test {
namespace {

using testing::Uniform;

Answer solve(const Lcp& lcp, const std::string& settings = "") {
  return testing::solve("primal_dual{" + settings + "}", Problem("case", lcp));
}

/// Symmetric, eigenvalues in [1, 3], with a planted solution.
Lcp well_conditioned(Index n, Vector& z) {
  Uniform uniform(7);
  const Matrix A = uniform.matrix(n, n);
  return testing::plant(A * A.transpose() / static_cast<double>(n) + Matrix::Identity(n, n), uniform.vector(n), z);
}

TEST(PrimalDualTest, FindsThePlantedSolutionInAFewStepsWhateverTheSize) {
  for (const Index n : {1, 5, 20, 80}) {
    Vector z;
    const Lcp lcp = well_conditioned(n, z);
    const Answer answer = solve(lcp);
    ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
    EXPECT_LE((answer.z - z).lpNorm<Eigen::Infinity>(), 1e-12) << "n = " << n;
    const Answer untested = solve(lcp, "test=none");  // y and its multiplier are both about sqrt(eps) = 1e-7
    EXPECT_EQ(untested.claim, Claim::kSolved);
    EXPECT_LE((untested.z - z).lpNorm<Eigen::Infinity>(), 1e-6) << "n = " << n;
    EXPECT_LE(answer.counters.iterations, 50) << "n = " << n;
    EXPECT_EQ(answer.counters.factorizations, answer.counters.iterations) << "n = " << n;
  }
}

TEST(PrimalDualTest, ATighterGapGainsAccuracy) {
  Vector z;
  const Lcp lcp = well_conditioned(20, z);
  const Answer loose = solve(lcp, "eps=1e-6,test=none");
  const Answer tight = solve(lcp, "eps=1e-14,test=none");
  EXPECT_LT(loose.counters.iterations, tight.counters.iterations);
  EXPECT_GT((loose.z - z).norm(), 10 * (tight.z - z).norm());
}

// A step of some thousands of rows takes seconds: what stops it is asked many times within one.
TEST(PrimalDualTest, IsStoppedWithinAStep) {
  Vector z;
  const Lcp lcp = well_conditioned(300, z);
  int asked = 0;
  const StopCheck stop([&] { return ++asked > 10; });
  const Answer answer = testing::solve("primal_dual", Problem("case", lcp), {.time_limit_s = 1e6});
  EXPECT_EQ(answer.claim, Claim::kTimeLimit);
  EXPECT_EQ(answer.counters.iterations, 0);
}

TEST(PrimalDualTest, SaysWhenItsToleranceWasOutOfReach) {
  Vector z;
  const Lcp lcp = well_conditioned(20, z);
  const Answer answer = solve(lcp, "eps=0,eps_feas=0");  // the gap of an interior point is positive
  EXPECT_EQ(answer.claim, Claim::kSolved);
  EXPECT_TRUE(answer.detail.starts_with("no step reduces the residual further; ")) << answer.detail;
  EXPECT_LE((answer.z - z).norm(), 1e-6);
}

// The method itself stops at absolute tolerances; its support is solved for with rows and columns of one scale.
TEST(PrimalDualTest, FinishesOnASupportOfEveryScale) {
  for (const Index n : {4, 9, 12}) {
    Lcp lcp{testing::tridiagonal(n, 4, -1), Vector(n)};
    Vector scale(n);
    for (Index i = 0; i < n; ++i) scale(i) = std::ldexp(1.0, static_cast<int>(i % 4) * 8 - 12);
    lcp.M = scale.asDiagonal() * lcp.M * scale.asDiagonal();
    lcp.q = -lcp.M * scale.cwiseInverse();
    const Answer answer = solve(lcp);
    ASSERT_EQ(answer.claim, Claim::kSolved) << n << ": " << answer.detail;
    EXPECT_TRUE(answer.z.cwiseProduct(scale).isApprox(testing::ones(n), 1e-9)) << answer.z.transpose();
  }
}

}  // namespace
}  // namespace lcpbench::primal_dual_test
