#include <string>

#include <gtest/gtest.h>

#include "generators/sets.h"
#include "tests/support/brick_wall.h"
#include "tests/support/contacts.h"
#include "tests/support/solving.h"

namespace lcpbench::contact_ipm_test {
namespace {

using testing::expect_solved;
using testing::solve;

TEST(ContactIpmTest, SolvesWallsThatSlipInFewFactorizations) {
  const Problem wall("wall", testing::frictional_brick_wall(6, 8, 0.5));
  const Answer answer = solve("contact_ipm{tolerance=1e-6}", wall);
  expect_solved(wall, answer, 1e-6);
  EXPECT_LE(answer.counters.factorizations, 25);
}

// From the usual start the path soon ends at the boundary, and proximal_newton goes on for 50 to 190 factorizations.
TEST(ContactIpmTest, BeginsAnewWhereAHeavyBodyStandsOnALightOne) {
  for (const char* engine : {"bullet", "dart", "mujoco", "ode"}) {
    const auto set = open_set(std::string("scene/mass-ratio-1e6/") + engine);
    for (std::int64_t step = 0; step < *set->count(); ++step) {
      const Problem problem = set->generate(1, step);
      const Answer answer = solve("contact_ipm{tolerance=1e-6}", problem);
      expect_solved(problem, answer, 1e-6);
      EXPECT_LE(answer.counters.factorizations, 40) << engine << ' ' << step;
    }
  }
}

// The path of the interior point folds on the second step, and proximal_newton goes on from where it stops.
TEST(ContactIpmTest, GoesOnWhereItsPathFolds) {
  const auto set = open_set("scene/wall/bullet");
  for (std::int64_t step = 0; step < *set->count(); ++step) {
    const Problem problem = set->generate(1, step);
    const Answer answer = solve("contact_ipm{tolerance=1e-6}", problem);
    expect_solved(problem, answer, 1e-6);
    EXPECT_LE(answer.counters.factorizations, 250) << step;
  }
}

TEST(ContactIpmTest, TakesPolygonsOfAllNumbersOfEdges) {
  for (const char* edges : {"2", "4", "8", "12"}) {
    const auto set = open_set("made/tower{nc_min=20,nc_max=60,edges=" + std::string(edges) + "}");
    for (std::int64_t trial = 0; trial < 5; ++trial) {
      const Problem problem = set->generate(1, trial);
      expect_solved(problem, solve("contact_ipm", problem), 1e-8);
    }
  }
}

}  // namespace
}  // namespace lcpbench::contact_ipm_test
