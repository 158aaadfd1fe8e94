#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "generators/sets.h"
#include "native/velocity_ipm/assembly_tree.h"
#include "tests/support/brick_wall.h"
#include "tests/support/contacts.h"
#include "tests/support/exact_velocity.h"
#include "tests/support/solving.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench::velocity_ipm_test {
namespace {

using testing::frictionless;

constexpr int kMostSteps = 25;

Answer solve(const Problem& problem, const Options& options = {}, const SolveRequest& request = {}) {
  return testing::solve(Spec{"velocity_ipm", options}, problem, request);
}

/// The same problem without its sparsity.
ContactProblem dense(const ContactProblem& sparse) {
  return frictionless(sparse.v, to_dense(sparse.N), DenseInertia{dense_inertia(sparse.inertia)});
}

TEST(VelocityIpmTest, FinishesThePaperSetsToFullAccuracy) {
  for (const char* name : {"paper/monotone/exp1", "paper/monotone/exp2{redundancy=combination}",
                           "paper/monotone/exp5-1e5", "paper/monotone/exp5-1e8", "paper/monotone/exp5-1e10"}) {
    const auto set = open_set(name);
    const double bound = std::string(name).find("exp5") == std::string::npos ? 1e-12 : 1e-9;
    for (int trial = 0; trial < 60; ++trial) {
      const Problem problem = set->generate(31, trial);
      const Answer answer = solve(problem);
      ASSERT_EQ(answer.claim, Claim::kSolved) << name << ", trial " << trial << ": " << answer.detail;
      ASSERT_TRUE(Evaluator(problem).errors(answer).solved) << name << ", trial " << trial;
      if (answer.velocity.size() == 0 && bound == 1e-9) continue;  // in doubt
      QuadVector exact;
      ASSERT_TRUE(testing::exact_velocity(*problem.contact(), answer.z, exact)) << name << ", trial " << trial;
      ASSERT_LE(testing::velocity_error(*problem.contact(), answer.velocity, exact), bound) << name << ", " << trial;
    }
  }
}

// Through 1e5 the iteration alone gets there; what it claims is true beyond, too.
TEST(VelocityIpmTest, ConvergesInAFewStepsAndClaimsOnlyWhatIsTrue) {
  for (const char* name : {"paper/monotone/exp1", "paper/monotone/exp2", "paper/monotone/exp5-1e5",
                           "paper/monotone/exp5-1e10{redundancy=combination}"}) {
    const auto set = open_set(name);
    const bool easy = std::string(name).find("1e10") == std::string::npos;
    for (int trial = 0; trial < 60; ++trial) {
      const Problem problem = set->generate(32, trial);
      const Answer answer = solve(problem, {{"finish", "false"}});
      if (easy) {
        ASSERT_EQ(answer.claim, Claim::kSolved) << name << ", trial " << trial << ": " << answer.detail;
        EXPECT_LE(answer.counters.iterations, 40) << name << ", trial " << trial;
      }
      if (answer.claim == Claim::kSolved) {
        EXPECT_TRUE(Evaluator(problem).errors(answer).solved) << name << ", trial " << trial;
      }
    }
  }
}

// A ball between plates, and normals whose positive combinations span the plane: no velocity parts from all of them.
TEST(VelocityIpmTest, NeedsNoCentralPath) {
  const Matrix plates = testing::matrix_of(2, {1, -1, 0, 0});
  Matrix star(2, 3);
  star << 1, -1, 0, 0.5, 0.5, -1;
  for (const Matrix& N : {plates, star}) {
    const Problem problem("caught",
                          frictionless(testing::vector_of({-0.75, 0.5}), N, DenseInertia{2 * Matrix::Identity(2, 2)}));
    const Answer answer = solve(problem, {{"finish", "false"}});
    ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
    EXPECT_LE(answer.counters.iterations, kMostSteps);
    EXPECT_LE(Evaluator(problem).errors(answer).velocity_residual_relative, 1e-8);
  }
}

TEST(VelocityIpmTest, SparseAndDenseAlgebraGiveTheSameVelocity) {
  const ContactProblem wall = contact_problem(testing::brick_wall(4, 5));
  const Answer sparse = solve(Problem("sparse", wall));
  const Answer full = solve(Problem("dense", dense(wall)));
  ASSERT_EQ(sparse.claim, Claim::kSolved) << sparse.detail;
  ASSERT_EQ(full.claim, Claim::kSolved) << full.detail;
  const Vector difference = post_impact_velocity(wall, sparse.z) - post_impact_velocity(wall, full.z);
  EXPECT_LE(difference.lpNorm<Eigen::Infinity>(), 1e-12 * wall.v.norm());
  EXPECT_EQ(sparse.counters.pivots, 0);  // the sparse finish has no active set to change
}

// Bodies of any number of coordinates, some of which no contact touches, and contacts that touch none; up to
// what the regularised finish of the sparse algebra leaves.
TEST(VelocityIpmTest, SparseAlgebraTakesBodiesOfAnySize) {
  const auto set = open_set("paper/monotone/exp1");
  for (int trial = 0; trial < 40; trial += 4) {
    Matrix N = Matrix::Zero(5, 1);
    Matrix G = Matrix::Identity(0, 0);
    Vector v = Vector::Constant(5, 0.25);
    for (int part = 0; part < 4; ++part) {  // several problems as the contacts of one body
      const Problem problem = set->generate(37, trial + part);
      const ContactProblem& contact = *problem.contact();
      const Index ngc = contact.ngc();
      N.conservativeResizeLike(Matrix::Zero(N.rows() + ngc, N.cols() + contact.nc()));
      N.bottomRightCorner(ngc, contact.nc()) = to_dense(contact.N);
      G.conservativeResizeLike(Matrix::Zero(G.rows() + ngc, G.rows() + ngc));
      G.bottomRightCorner(ngc, ngc) = dense_inertia(contact.inertia);
      v.conservativeResize(v.size() + ngc);
      v.tail(ngc) = contact.v;
    }
    ContactProblem bodies =
        frictionless(v, N, BlockInertia{{2 * Matrix::Identity(2, 2), Matrix::Identity(3, 3), G}});
    bodies.N = SparseMatrix(N.sparseView());
    ASSERT_GT(G.rows(), 16) << "no longer than what is summed at once";
    const Answer sparse = solve(Problem("sparse", bodies));
    const Answer full = solve(Problem("dense", dense(bodies)));
    ASSERT_EQ(sparse.claim, Claim::kSolved) << "trial " << trial << ": " << sparse.detail;
    ASSERT_EQ(full.claim, Claim::kSolved) << "trial " << trial << ": " << full.detail;
    const Vector difference = post_impact_velocity(bodies, sparse.z) - post_impact_velocity(bodies, full.z);
    EXPECT_LE(difference.norm(), 1e-10 * v.norm()) << "trial " << trial;
  }
}

TEST(VelocityIpmTest, SolvesAWallOf2400ContactsToFullAccuracy) {
  const Problem wall("wall", testing::brick_wall(15, 21));
  EXPECT_GE(wall.size(), 2300);
  const Answer answer = solve(wall);
  ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_LE(answer.counters.iterations, kMostSteps);
  const Errors errors = Evaluator(wall).errors(answer);
  EXPECT_TRUE(errors.solved);
  EXPECT_LE(errors.velocity_residual_relative, 1e-12);
  EXPECT_GE(errors.min_z, 0);
  // The iteration alone stops at its tolerance, and not before.
  for (const char* tolerance : {"1e-5", "1e-6", "1e-7", "1e-8"}) {
    const Answer unfinished = solve(wall, {{"finish", "false"}, {"tolerance", tolerance}});
    EXPECT_EQ(unfinished.claim, Claim::kSolved) << tolerance;
    const double residual = Evaluator(wall).errors(unfinished).velocity_residual_relative;
    EXPECT_GE(residual, 1e-12) << tolerance;
    EXPECT_LE(residual, 1.01 * std::stod(tolerance)) << tolerance;
  }
}

/// The lower triangle of the matrix of a grid of side x side points, each tied to its four neighbours, and of as many
/// points that are tied to nothing.
SparseMatrix grid_matrix(int side) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < 2 * side * side; ++i) entries.emplace_back(i, i, 5.0);
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      const int point = row * side + column;
      if (column + 1 < side) entries.emplace_back(point + 1, point, -1.0);
      if (row + 1 < side) entries.emplace_back(point + side, point, -1.0);
    }
  }
  SparseMatrix matrix(2 * side * side, 2 * side * side);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

TEST(EliminationOrderTest, OrdersEveryRowOnceAndFillsAGridLessThanItsBand) {
  const SparseMatrix grid = grid_matrix(60);
  const std::vector<int> order = elimination_order(grid);
  std::vector<int> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  for (int i = 0; i < static_cast<int>(sorted.size()); ++i) ASSERT_EQ(sorted[static_cast<std::size_t>(i)], i);

  Eigen::PermutationMatrix<Eigen::Dynamic> position(grid.rows());
  for (int k = 0; k < static_cast<int>(order.size()); ++k) position.indices()(order[static_cast<std::size_t>(k)]) = k;
  SparseMatrix ordered;
  ordered.selfadjointView<Eigen::Lower>() = grid.selfadjointView<Eigen::Lower>().twistedBy(position);
  using Cholesky = Eigen::SimplicialLLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>>;
  const Cholesky by_degree(ordered);
  const Cholesky banded(grid);
  const SparseMatrix sparse_factor = by_degree.matrixL();
  const SparseMatrix banded_factor = banded.matrixL();
  EXPECT_LE(3 * sparse_factor.nonZeros(), banded_factor.nonZeros());  // 60 entries in each column of the band
  EXPECT_TRUE(elimination_order(SparseMatrix(0, 0)).empty());
}

TEST(VelocityIpmTest, SaysUnsolvableOnlyWithTheFinishAndSolvedNever) {
  Matrix N(2, 2);
  N << 1, -1, 1, 1;
  Matrix Ginv = Matrix::Identity(2, 2);
  Ginv(1, 1) = 0;
  const Problem crushed("crushed", frictionless(testing::vector_of({0, -1}), N, InverseInertia{Ginv}));
  const Answer answer = solve(crushed);
  EXPECT_EQ(answer.claim, Claim::kUnsolvable) << answer.detail;
  EXPECT_TRUE(Evaluator(crushed).check_farkas(answer.farkas));
  EXPECT_NE(solve(crushed, {{"finish", "false"}}).claim, Claim::kSolved);
}

TEST(VelocityIpmTest, RefusesWhatItsAlgebraCannotTake) {
  ContactProblem wall = contact_problem(testing::brick_wall(2, 2));
  std::get<BlockInertia>(wall.inertia).blocks[0].setOnes();
  const Answer answer = solve(Problem("singular", wall));
  EXPECT_EQ(answer.claim, Claim::kUnsupported);
  EXPECT_NE(answer.detail.find("blocks"), std::string::npos);
  EXPECT_EQ(solve(Problem("bare", Lcp{Matrix::Identity(2, 2), -testing::ones(2)})).claim, Claim::kUnsupported);
}

}  // namespace
}  // namespace lcpbench::velocity_ipm_test
