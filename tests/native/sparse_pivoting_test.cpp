// Bare LCPs with a sparse M: the stage of `auto` for them. Work is counted, not timed.
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "generators/random.h"
#include "native/lcp_ladder/sparse_pivoting.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench {
SolverDefinition lcpbench_solver_auto();
}

namespace lcpbench::sparse_pivoting_test {
namespace {

constexpr double kForever = std::numeric_limits<double>::infinity();
constexpr const char* kSparse = "sparse principal pivoting";

Answer solve_by_auto(const Problem& problem) {
  const auto solver = lcpbench_solver_auto().make({});
  solver->load(problem);
  Answer answer;
  solver->solve({}, answer);
  return answer;
}

/// q = w - M z for a drawn z >= 0, w >= 0 with z'w = 0.
Vector planted(const Matrix& M, std::uint64_t seed) {
  DrawSequence draws(TrialKey{stream_id("tests/sparse_pivoting"), seed, 0}, Purpose::kPlantedValues, 0);
  Vector z = Vector::Zero(M.rows());
  Vector w = Vector::Zero(M.rows());
  for (Index i = 0; i < M.rows(); ++i) {
    Vector& positive = draws.integer(0, 1) == 0 ? z : w;
    positive(i) = static_cast<double>(draws.integer(1, 99));
  }
  return w - M * z;
}

Matrix banded(Index n, std::initializer_list<std::pair<Index, double>> diagonals) {
  Matrix M = Matrix::Zero(n, n);
  for (const auto& [offset, value] : diagonals) {
    for (Index i = std::max<Index>(0, -offset); i < n - std::max<Index>(0, offset); ++i) M(i, i + offset) = value;
  }
  return M;
}

Matrix grid_laplacian(Index side) {
  Matrix M = banded(side * side, {{0, 4}, {1, -1}, {-1, -1}, {side, -1}, {-side, -1}});
  for (Index row = 1; row < side; ++row) M(row * side, row * side - 1) = M(row * side - 1, row * side) = 0;
  return M;
}

Matrix arrow(Index n) {
  Matrix M = banded(n, {{0, 2}});
  M.col(0).setConstant(-1);
  M.row(0).setConstant(-1);
  M(0, 0) = static_cast<double>(n);
  return M;
}

/// The P-matrix and q on which block exchanges go round, n - 3 rows of no account behind it.
Lcp cycling(Index n) {
  Lcp lcp{Matrix::Identity(n, n), Vector::Ones(n)};
  lcp.M.topLeftCorner(3, 3) << 1, 0, 3, -1, 1, 0, -3, 2, 1;
  lcp.q.head(3) << 5, -3, -4;
  return lcp;
}

TEST(SparsePivotingTest, SolvesSparseProblemsInFewFactorizations) {
  const std::pair<const char*, Matrix> matrices[] = {
      {"tridiagonal", banded(500, {{0, 2}, {1, -1}, {-1, -1}})},
      {"one-sided", banded(400, {{0, 2}, {1, -1}})},
      {"a K-matrix", banded(400, {{0, 5}, {1, -3}, {-1, -0.5}, {7, -1}})},
      {"positive entries", banded(400, {{0, 5}, {1, 3}, {-1, 1}, {-2, -0.5}})},
      {"a P-matrix that is not monotone", banded(400, {{0, 1}, {1, 4}})},
      {"an arrow", arrow(400)},
      {"a grid", grid_laplacian(20)}};
  for (const auto& [name, M] : matrices) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const Problem problem("x", Lcp{M, planted(M, seed)});
      const Answer answer = solve_by_auto(problem);
      EXPECT_EQ(answer.claim, Claim::kSolved) << name;
      EXPECT_EQ(answer.detail, kSparse) << name;
      EXPECT_LE(Evaluator(problem).errors(answer).backward_row_norm, 1e-12) << name;
      EXPECT_LE(answer.counters.factorizations, 40) << name;
    }
  }
}

TEST(SparsePivotingTest, LeavesDenseSmallAndNonPositiveProblemsToOthers) {
  SparsePivoting method;
  EXPECT_FALSE(method.load({Matrix::Ones(300, 300) + Matrix::Identity(300, 300), Vector::Ones(300)}));
  EXPECT_FALSE(method.load({Matrix::Identity(SparsePivoting::kLeast - 1, SparsePivoting::kLeast - 1),
                            Vector::Ones(SparsePivoting::kLeast - 1)}));
  EXPECT_TRUE(method.load({Matrix::Identity(SparsePivoting::kLeast, SparsePivoting::kLeast),
                           Vector::Ones(SparsePivoting::kLeast)}));
  EXPECT_FALSE(method.load({banded(300, {{0, 0}, {1, 1}, {-1, -1}}), Vector::Ones(300)}));
  // Few nonzeros, and full factors.
  Matrix scattered = Matrix::Identity(400, 400);
  DrawSequence draws(TrialKey{stream_id("tests/sparse_pivoting"), 9, 0}, Purpose::kPlantedValues, 0);
  for (int k = 0; k < 3000; ++k) scattered(draws.integer(0, 399), draws.integer(0, 399)) = 1;
  scattered.diagonal().setConstant(100);
  EXPECT_FALSE(method.load({scattered, Vector::Ones(400)}));
}

TEST(SparsePivotingTest, ExchangesOnePairAtATimeWhereBlocksGoRound) {
  const Lcp lcp = cycling(300);
  SparsePivoting method;
  ASSERT_TRUE(method.load(lcp));
  Vector z(300);
  ASSERT_EQ(method.run(kForever, z), SparsePivoting::End::kSolved);
  EXPECT_GT(method.counts().single, 0);
  Answer answer;
  answer.z = z;
  EXPECT_TRUE(Evaluator(Problem("x", lcp)).errors(answer).solved);
  EXPECT_EQ(method.run(-kForever, z), SparsePivoting::End::kTimeLimit);
}

TEST(SparsePivotingTest, CountsOnlyTheFactorizationsThatItMakes) {
  SparsePivoting method;
  Vector z(300);
  for (const int factorizations : {0, 1}) {  // w = q, then z = -q
    ASSERT_TRUE(method.load({Matrix::Identity(300, 300), Vector::Constant(300, factorizations == 0 ? 1 : -1)}));
    ASSERT_EQ(method.run(kForever, z), SparsePivoting::End::kSolved);
    EXPECT_EQ(method.counts().steps, factorizations + 1);
    EXPECT_EQ(method.counts().factorizations, factorizations);
  }
}

TEST(SparsePivotingTest, OtherMethodsFollowWhereItGivesUp) {
  // Every row cycles: more single exchanges than the work allows.
  Lcp cycles{Matrix::Zero(300, 300), Vector(300)};
  for (Index i = 0; i < 300; i += 3) {
    const Lcp one = cycling(3);
    cycles.M.block(i, i, 3, 3) = one.M;
    cycles.q.segment(i, 3) = one.q;
  }
  SparsePivoting method;
  ASSERT_TRUE(method.load(cycles));
  Vector z(300);
  EXPECT_EQ(method.run(kForever, z), SparsePivoting::End::kWorkLimit);
  // All z basic: singular.
  Lcp singular{Matrix::Zero(300, 300), Vector(300)};
  for (Index i = 0; i < 300; i += 2) {
    singular.M.block(i, i, 2, 2).setOnes();
    singular.q.segment(i, 2) << -1, -2;
  }
  ASSERT_TRUE(method.load(singular));
  EXPECT_EQ(method.run(kForever, z), SparsePivoting::End::kSingular);
  for (const Lcp& lcp : {cycles, singular}) {
    const Problem problem("x", lcp);
    const Answer answer = solve_by_auto(problem);
    EXPECT_EQ(answer.claim, Claim::kSolved) << answer.detail;
    EXPECT_TRUE(Evaluator(problem).errors(answer).solved);
  }
}

TEST(SparsePivotingTest, ClaimsNothingWithoutASolution) {
  // w_0 = -1 - z_1 < 0 for every z >= 0 with complementary rows: M is no P-matrix.
  Matrix M = Matrix::Identity(300, 300);
  M.topLeftCorner(2, 2) << 1, -2, -2, 1;
  const Problem problem("x", Lcp{M, Vector::Constant(300, -1)});
  const Answer answer = solve_by_auto(problem);
  EXPECT_NE(answer.claim, Claim::kSolved);
}

}  // namespace
}  // namespace lcpbench::sparse_pivoting_test
