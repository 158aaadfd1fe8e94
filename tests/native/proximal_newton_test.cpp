#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "core/compliance.h"
#include "core/timed_solve.h"
#include "generators/random.h"
#include "generators/sets.h"
#include "native/proximal_newton/friction_polygon.h"
#include "tests/support/brick_wall.h"
#include "tests/support/contacts.h"
#include "tests/support/solving.h"

namespace lcpbench::proximal_newton_test {
namespace {

using testing::expect_solved;
using testing::in_dense_matrices;
using testing::solve;

using Point = FrictionPolygon::Point;

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

// The last is a bridge of 1,116 contacts with mu up to 2: the rounds of friction_ipm and the sweeps of psor leave more
// than 1e-3 after ten times the time.
TEST(ProximalNewtonTest, SolvesTheClassesThatAreHeldOutOfFitsAndWhatOtherMethodsWanderAbout) {
  for (const char* name : {"cradle{nc_max=100}", "dome{nc_max=100}", "drystone{nc_max=100}", "net{nc_max=100}",
                           "ragdolls{nc_max=100}", "tracks{nc_max=100}", "bridge{nc_max=2000}"}) {
    const bool is_bridge = std::string(name).starts_with("bridge");
    const Problem problem = open_set("made/" + std::string(name))->generate(is_bridge ? 20261204 : 7, 0);
    expect_solved(problem, solve("proximal_newton", problem), 1e-8);
  }
}

TEST(ProximalNewtonTest, TakesFewStepsFromTheLastAnswerAndNoSenselessStart) {
  const Problem wall("wall", testing::frictional_brick_wall(4, 5, 0.5));
  const Answer first = solve("proximal_newton", wall);
  expect_solved(wall, first);
  EXPECT_GT(first.counters.iterations, 5);
  const Answer again = solve("proximal_newton", wall, {.start = &first.z});
  EXPECT_EQ(again.claim, Claim::kSolved);
  EXPECT_LE(again.counters.iterations, 3);
  const Vector senseless = Vector::Constant(wall.size(), 1e300);
  EXPECT_EQ(solve("proximal_newton", wall, {.start = &senseless}).z, first.z);
}

TEST(ProximalNewtonTest, SaysWhatItDoesNotTake) {
  ContactProblem contact = in_dense_matrices(*open_set("rigid/frictional/exp1{edges=8}")->generate(1, 0).contact());
  ContactProblem singular = contact;
  singular.inertia = InverseInertia{Matrix::Zero(contact.ngc(), contact.ngc())};
  EXPECT_EQ(solve("proximal_newton", Problem("singular", singular)).detail, "it needs an inertia of full rank");
  std::get<Matrix>(contact.D).col(1) *= 2;  // one of four pairs
  std::get<Matrix>(contact.D).col(5) *= 2;
  const Answer answer = solve("proximal_newton", Problem("no polygon", contact));
  EXPECT_EQ(answer.claim, Claim::kUnsupported);
  EXPECT_EQ(answer.detail, "contact 0: its friction directions are not those of a regular polygon");
}

/// Nearly singular: its inverse in double proves nothing, and that in 113 bits takes minutes, which nothing would stop.
TEST(ProximalNewtonTest, ALargeNearlySingularGinvIsRefusedAtOnce) {
  constexpr Index kSize = 400;
  Matrix Ginv = Matrix::Identity(kSize, kSize);
  for (Index i = 0; i + 1 < kSize; i += 2) Ginv(i, i + 1) = Ginv(i + 1, i) = 1 - 0x1p-45;
  ContactProblem contact;
  contact.inertia = InverseInertia{Ginv};
  contact.v = Vector::Constant(kSize, -1);
  contact.N = Matrix(Matrix::Identity(kSize, kSize));
  contact.D = Matrix(kSize, 0);
  contact.edges.assign(static_cast<std::size_t>(kSize), 0);
  contact.mu = Vector::Zero(kSize);
  for (const char* solver : {"proximal_newton", "contact_ipm"}) {
    const double begin_s = thread_cpu_clock_s();
    const Answer answer = solve(solver, Problem("local", contact));
    EXPECT_EQ(answer.claim, Claim::kUnsupported) << solver;
    EXPECT_EQ(answer.detail.rfind("it needs G, and takes long to invert a Ginv", 0), 0U) << answer.detail;
    EXPECT_LT(thread_cpu_clock_s() - begin_s, 5) << "113 bits take some 20 s";
  }
}

}  // namespace
}  // namespace lcpbench::proximal_newton_test
