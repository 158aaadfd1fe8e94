#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "generators/random.h"
#include "generators/sets.h"
#include "native/proximal_newton/friction_polygon.h"
#include "study/evaluation/evaluation.h"
#include "tests/support/brick_wall.h"

namespace lcpbench {
SolverDefinition lcpbench_solver_proximal_newton();
}

namespace lcpbench::proximal_newton_test {
namespace {

using Point = FrictionPolygon::Point;

Answer solve(const Problem& problem, const Options& options = {}, const SolveRequest& request = {}) {
  const auto solver = lcpbench_solver_proximal_newton().make(options);
  solver->load(problem);
  Answer answer;
  solver->solve(request, answer);
  return answer;
}

/// Points and sizes, some of them zero.
struct Draws {
  DrawSequence sequence{TrialKey{stream_id("tests/proximal_newton"), 1, 0}, Purpose::kPlantedValues, 0};
  double number() { return static_cast<double>(sequence.signed_grid()) * kGridStep; }  // in [-1, 1]
  Point point() { return 2 * Point(number(), number()); }
  double size() { return std::max(number(), 0.0); }
};

// A point of a convex set is the nearest one if no corner lies beyond it, as seen from outside.
TEST(FrictionPolygonTest, FindsTheNearestPoint) {
  Draws draws;
  for (const Index edges : {2, 4, 6, 8, 16}) {
    const FrictionPolygon polygon(edges);
    for (int trial = 0; trial < 1000; ++trial) {
      Point other = draws.point();
      if (edges == 2) other(1) = 0;  // there is no second tangent
      const double size = draws.size();
      const FrictionPolygon::Nearest nearest = polygon.nearest(other, size);
      double used = 0;
      const FrictionPolygon::Parts parts = polygon.split(nearest.point);
      Point sum = Point::Zero();
      for (std::size_t k = 0; k < 2; ++k) {
        const auto direction = edge_direction(parts.directions[k], edges);
        sum += parts.impulses[k] * Point(direction[0], direction[1]);
        used += std::abs(parts.impulses[k]);
      }
      EXPECT_LE((sum - nearest.point).norm(), 1e-14);  // products of numbers of the order of 1
      EXPECT_LE(used, size + 1e-14);
      for (Index k = 0; k < edges; ++k) {
        const auto direction = edge_direction(k, edges);
        const Point corner = size * Point(direction[0], direction[1]);
        EXPECT_LE((other - nearest.point).dot(corner - nearest.point), 1e-14);
      }
    }
  }
}

TEST(FrictionPolygonTest, KnowsHowTheNearestPointMoves) {
  constexpr double kStep = 1e-6;
  Draws draws;
  int compared = 0;
  for (const Index edges : {2, 4, 6, 8, 16}) {
    const FrictionPolygon polygon(edges);
    for (int trial = 0; trial < 200; ++trial) {
      const Point other = draws.point();
      const double size = 0.5 + draws.size();
      const auto at = [&](const Point& of, double most) { return polygon.nearest(of, most).point; };
      const FrictionPolygon::Nearest nearest = polygon.nearest(other, size);
      Eigen::Matrix<double, 2, 3> ahead, behind;
      for (int k = 0; k < 2; ++k) {
        ahead.col(k) = at(other + kStep * Point::Unit(k), size) - nearest.point;
        behind.col(k) = nearest.point - at(other - kStep * Point::Unit(k), size);
      }
      ahead.col(2) = at(other, size + kStep) - nearest.point;
      behind.col(2) = nearest.point - at(other, size - kStep);
      if ((ahead - behind).norm() > 1e-9) continue;  // a boundary between two cases lies there
      ++compared;
      EXPECT_LE((ahead.leftCols<2>() / kStep - nearest.slope).norm(), 1e-8);  // of rounding over kStep
      EXPECT_LE((ahead.col(2) / kStep - nearest.growth).norm(), 1e-8);
    }
  }
  EXPECT_GT(compared, 900);
}

// A bridge of 1,116 contacts with mu up to 2: the rounds of friction_ipm and the sweeps of psor leave more than 1e-3
// after ten times the time.
TEST(ProximalNewtonTest, SolvesWhatOtherMethodsWanderAbout) {
  const Problem bridge = open_set("made/bridge{nc_max=2000}")->generate(20261204, 0);
  const Answer answer = solve(bridge);
  EXPECT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_LT(Evaluator(bridge).errors(answer).velocity_residual_relative, 1e-8);
}

TEST(ProximalNewtonTest, SolvesTheClassesThatAreHeldOutOfFits) {
  for (const char* name : {"cradle", "dome", "drystone", "net", "ragdolls", "tracks"}) {
    const Problem problem = open_set("made/" + std::string(name) + "{nc_max=100}")->generate(7, 0);
    const Answer answer = solve(problem);
    EXPECT_EQ(answer.claim, Claim::kSolved) << name << answer.detail;
    EXPECT_LT(Evaluator(problem).errors(answer).velocity_residual_relative, 1e-8) << name;
  }
}

// From zero impulses the residuals stay at 2e-4 and 1.05e-4. Softer contacts lead to an answer.
TEST(ProximalNewtonTest, SoftensContactsWhereItWanders) {
  struct Case {
    const char* set;
    std::uint64_t seed;
    std::int64_t trial;
  };
  for (const Case& hard : {Case{"made/drystone{nc_max=1000}", 20262011, 2}, {"made/tower{nc_max=1000}", 20262012, 2}}) {
    const Problem problem = open_set(hard.set)->generate(hard.seed, hard.trial);
    const Answer answer = solve(problem, {{"tolerance", "1e-4"}});
    EXPECT_EQ(answer.claim, Claim::kSolved) << hard.set << ": " << answer.detail;
    EXPECT_LT(Evaluator(problem).errors(answer).velocity_residual_relative, 1e-4) << hard.set;
  }
}

TEST(ProximalNewtonTest, TakesFewStepsFromTheLastAnswer) {
  const Problem wall("wall", testing::frictional_brick_wall(4, 5, 0.5));
  const Answer first = solve(wall);
  ASSERT_EQ(first.claim, Claim::kSolved);
  const Answer again = solve(wall, {}, {.start = &first.z});
  EXPECT_EQ(again.claim, Claim::kSolved);
  EXPECT_LE(again.counters.iterations, 3);
  EXPECT_GT(first.counters.iterations, 5);
}

TEST(ProximalNewtonTest, ClaimsNoResidualAboveTheAcceptedOne) {
  const Problem wall("wall", testing::frictional_brick_wall(2, 2, 0.5));
  const Answer answer = solve(wall, {{"accept_residual", "1e-30"}});
  EXPECT_EQ(answer.claim, Claim::kNumericalFailure);
  EXPECT_LE(Evaluator(wall).errors(answer).velocity_residual_relative, 1.01e-9);  // that of `tolerance`
}

TEST(ProximalNewtonTest, BeginsFromNothingWhereAStartIsBeyondDouble) {
  const Problem wall("wall", testing::frictional_brick_wall(2, 2, 0.5));
  for (const double size : {1e200, 1e300}) {  // squares of the first, velocities of the second
    const Vector start = Vector::Constant(wall.size(), size);
    const Answer answer = solve(wall, {}, {.start = &start});
    EXPECT_EQ(answer.claim, Claim::kSolved) << size;
    EXPECT_EQ(answer.z, solve(wall).z) << size;
  }
}

TEST(ProximalNewtonTest, UpdateGivesBitForBitWhatLoadGives) {
  ContactProblem contact = contact_problem(testing::frictional_brick_wall(3, 3, 0.5));
  const auto solver = lcpbench_solver_proximal_newton().make({});
  solver->load(Problem("first", contact));
  contact.v *= 0.5;
  contact.v(2) -= 0.125;
  solver->update(contact.v);
  Answer updated;
  solver->solve({}, updated);
  const Answer loaded = solve(Problem("second", contact));
  EXPECT_EQ(updated.claim, loaded.claim);
  EXPECT_EQ(updated.z, loaded.z);
}

TEST(ProximalNewtonTest, SaysWhatItDoesNotTake) {
  ContactProblem contact = contact_problem(testing::frictional_brick_wall(2, 2, 0.5));
  contact.D = to_dense(contact.D);
  ContactProblem singular = contact;
  singular.inertia = InverseInertia{Matrix::Zero(contact.ngc(), contact.ngc())};
  EXPECT_EQ(solve(Problem("singular", singular)).detail, "it needs an inertia of full rank");
  const Index edges = contact.edges[0];
  ASSERT_GE(edges, 4);
  auto& D = std::get<Matrix>(contact.D);
  Matrix eight(D.rows(), D.cols() / edges * 8);  // eight directions of a contact that do not lie in a plane
  for (Index column = 0; column < eight.cols(); ++column) {
    const Index k = column % 8;
    eight.col(column) = (k < 4 ? 1 : -1) * Vector::Unit(D.rows(), k % 4);
  }
  contact.D = eight;
  contact.edges.assign(contact.edges.size(), 8);
  const Answer answer = solve(Problem("no plane", contact));
  EXPECT_EQ(answer.claim, Claim::kUnsupported);
  EXPECT_EQ(answer.detail, "contact 0: its friction directions are not those of a regular polygon");
}

TEST(ProximalNewtonTest, StopsAtItsLimits) {
  const Problem wall("wall", testing::frictional_brick_wall(3, 3, 0.5));
  const Answer few = solve(wall, {{"max_iterations", "1"}});
  EXPECT_EQ(few.claim, Claim::kIterationLimit);
  EXPECT_EQ(few.counters.iterations, 1);
  EXPECT_EQ(solve(wall, {}, {.time_limit_s = 0}).claim, Claim::kTimeLimit);
}

/// The two coordinates differ by one unit in the last place: a metric of G^-1 would enlarge every rounding error.
TEST(ProximalNewtonTest, SolvesWhereRoundingAloneKeepsTheInertiaRegular) {
  ContactProblem contact;
  contact.v = Vector{{0.8, -0.8}};
  contact.N = Matrix{{-1.31}, {-0.46}};
  contact.D = Matrix(2, 0);
  contact.edges = {0};
  contact.mu = Vector::Zero(1);
  contact.inertia = DenseInertia{Matrix{{1, 1}, {1, 1 + 0x1p-52}}};
  const Problem problem("nearly singular", contact);
  const Answer answer = solve(problem);
  EXPECT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_LE(Evaluator(problem).errors(answer).velocity_residual_relative, kSolvedVelocityResidual);
}

}  // namespace
}  // namespace lcpbench::proximal_newton_test
