// Rows that nothing couples are judged by their own scale: no fast or heavy part of a problem hides another's failure.

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/evaluation_cases.h"

namespace lcpbench::island_evaluation_test {
namespace {

TEST(IslandEvaluationTest, AFastContactHidesNoFailedOne) {
  const Problem problem("two",
                        frictionless(vec({20000, -1}), Matrix::Identity(2, 2), DenseInertia{Matrix::Identity(2, 2)}));
  const Errors errors = evaluate(problem, vec({0, 0}));
  EXPECT_EQ(errors.velocity_residual_relative, 1);
  EXPECT_EQ(errors.velocity_residual_m_per_s, 1);
  EXPECT_FALSE(errors.solved);
  EXPECT_EQ(errors.worst.row, 1);
  EXPECT_EQ(errors.worst.w, -1);
  EXPECT_EQ(errors.worst.scale, 1);
  EXPECT_EQ(verdict(Claim::kSolved, errors, Truth::kSolvable), Verdict::kWrong);
  const Errors right = evaluate(problem, vec({0, 1}));
  EXPECT_TRUE(right.solved);
  EXPECT_EQ(right.worst.row, -1);
}

TEST(IslandEvaluationTest, CouplingMakesOneIslandWithOneScale) {
  Matrix G(2, 2);
  G << 1, 0.5, 0.5, 1;
  const Problem problem("coupled", frictionless(vec({-20000, 9999}), Matrix::Identity(2, 2), DenseInertia{G}));
  const Errors errors = evaluate(problem, vec({15000, 0}));  // the first stops and makes the second approach by 1
  EXPECT_DOUBLE_EQ(errors.velocity_residual_relative, 1 / 20000.0);
  EXPECT_TRUE(errors.solved);
}

TEST(IslandEvaluationTest, ALargeBlockHidesNoFailedOne) {
  const Problem problem("lcp", Lcp{Matrix::Identity(2, 2), vec({-1e10, -1})});
  const Errors errors = evaluate(problem, vec({1e10, 0}));
  EXPECT_EQ(errors.backward_row_norm, 1);
  EXPECT_EQ(errors.worst.row, 1);
  EXPECT_FALSE(errors.solved);
  EXPECT_TRUE(evaluate(problem, vec({1e10, 1})).solved);
}

/// Entries are tiny, and dust, beside the largest of their own block only.
TEST(IslandEvaluationTest, EachBlockHasItsOwnDust) {
  const Lcp lcp{Matrix::Identity(3, 3), vec({-1e10, -1, 1})};
  EXPECT_TRUE(evaluate(Problem("lcp", lcp), vec({1e10, 1, 0})).solved);
  EXPECT_FALSE(evaluate(Problem("lcp", lcp), vec({1e10, 1 + 1e-5, 0})).solved);
  Matrix M = Matrix::Identity(3, 3);
  M(1, 2) = M(2, 1) = 0.5;
  const Lcp coupled{M, vec({-1e10, -1, 1})};
  EXPECT_TRUE(evaluate(Problem("lcp", coupled), vec({1e10, 1, -1e-12})).solved);
  EXPECT_FALSE(evaluate(Problem("lcp", coupled), vec({1e10, 1, -1e-5})).solved);
}

/// q = -3 v_1 + v_2 is 3.1e-5 in truth and 6.1e-5 in double: z from either is right, though they differ by as much.
TEST(IslandEvaluationTest, RoundingOfAllOfQIsNoResidual) {
  constexpr double kUnit = 0x1p40;  // so that rounding is more than the least speed that counts
  const Matrix N = vec({-3, 1});
  const Problem problem("cancels",
                        frictionless(kUnit * vec({0.1, 0.3}), N, DenseInertia{Matrix::Identity(2, 2)}));
  const double q_in_double = kUnit * (-3 * 0.1 + 0.3);
  ASSERT_LT(q_in_double, 0);
  const Errors errors = evaluate(problem, vec({-q_in_double / 10}));
  EXPECT_GT(errors.velocity_residual_m_per_s, 1e-17 * kUnit);
  EXPECT_LT(errors.velocity_residual_m_per_s, 3 * 0x1p-53 * 0.6 * kUnit);
  EXPECT_LE(errors.velocity_residual_relative, kSolvedVelocityResidual);
  EXPECT_TRUE(errors.solved);
  EXPECT_FALSE(evaluate(problem, vec({1e-13 * kUnit})).solved);
}

/// The floor is of the island alone: the rounding of another's velocities excuses nothing.
TEST(IslandEvaluationTest, TheFloorIsTheIslandsOwn) {
  Matrix N = Matrix::Zero(3, 2);
  N(0, 0) = -3;
  N(1, 0) = 1;
  N(2, 1) = 1;
  const Problem problem("two", frictionless(vec({1e10, 3e10, -1e-8}), N, DenseInertia{Matrix::Identity(3, 3)}));
  const Errors errors = evaluate(problem, vec({0, 0}));
  EXPECT_EQ(errors.velocity_residual_relative, 1);
  EXPECT_EQ(errors.worst.row, 1);
}

TEST(IslandEvaluationTest, RowsOfAFrictionalContactAreJudgedTogether) {
  Matrix N(4, 2), D(4, 4);
  N << 0, 0, 1, 0, 0, 0, 0, 1;
  D << 1, -1, 0, 0, 0, 0, 0, 0, 0, 0, 1, -1, 0, 0, 0, 0;
  ContactProblem contact;
  contact.v = vec({1000, -1000, 1, -2});
  contact.N = N;
  contact.D = D;
  contact.mu = vec({0.5, 0.5});
  contact.edges = {2, 2};
  contact.inertia = DenseInertia{Matrix::Identity(4, 4)};
  const Problem problem("two sliders", contact);
  // z = [f_N; f_D of 1; f_D of 2; lambda]: the first slides on at 500 m/s, the second stops.
  Vector z = vec({1000, 2, 0, 500, 0, 1, 500, 0});
  const Errors right = evaluate(problem, z);
  EXPECT_EQ(right.velocity_residual_relative, 0);
  z(5) = 0;  // the second's friction left out: its foot slides on at 1 m/s
  const Errors errors = evaluate(problem, z);
  EXPECT_EQ(errors.velocity_residual_m_per_s, 1);
  EXPECT_EQ(errors.velocity_residual_relative, 0.5);
  EXPECT_EQ(errors.worst.row, 5);
  EXPECT_TRUE(errors.criterion);
  EXPECT_EQ(verdict(Claim::kSolved, errors, Truth::kSolvable), Verdict::kWrong);
}

/// Islands leave problems that are one alone: residuals of the evaluation before it knew of islands.
TEST(IslandEvaluationTest, OneIslandKeepsItsResidualsBitForBit) {
  constexpr std::array kBefore{0x1.650133bp-5,        0x1.4103faab05948p+2, 0x1.d544f63c53961p+2,
                               0x1.ef9aa8602c5fep+1, 0x1.0730a068bd69bp+1, 0x1.035b502c4c6dcp+3};
  Draw draw(2024);
  for (std::size_t trial = 0; trial < kBefore.size(); ++trial) {
    const ContactProblem contact = random_frictional(draw, 4, 1 + static_cast<Index>(trial % 3), 4);
    const Vector z = random_answer(draw, lcp_size(contact));
    const Errors errors = evaluate(Problem("one island", contact), z);
    const Vector approach = -(to_dense(contact.N).transpose() * contact.v), along = to_dense(contact.D).transpose() * contact.v;
    const double fastest = std::max(approach.cwiseAbs().maxCoeff(), along.cwiseAbs().maxCoeff());
    EXPECT_EQ(errors.velocity_residual_m_per_s, kBefore[trial]) << trial;
    EXPECT_DOUBLE_EQ(errors.velocity_residual_relative,
                     kBefore[trial] / std::max({1e-8, 1e-6 * fastest, approach.maxCoeff()}))
        << trial;
  }
}

}  // namespace
}  // namespace lcpbench::island_evaluation_test
