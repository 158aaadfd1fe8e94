// `auto` on captured scenes, piles and walls.
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/timed_solve.h"
#include "generators/scenes/scenes.h"
#include "generators/sets.h"
#include "tests/native/auto_checks.h"
#include "tests/support/box_stacks.h"
#include "tests/support/brick_wall.h"
#include "tests/support/sphere_piles.h"

namespace lcpbench::auto_scenes_test {
namespace {

using testing::auto_solver;
using testing::expect_solved;
using testing::solve;

/// Many times the processor time that the slowest step takes, and less than a method takes that does not suit it.
#ifdef __SANITIZE_ADDRESS__
constexpr double kMostCpu_s = 60;  // sanitizers make a solve 20 times slower
#else
constexpr double kMostCpu_s = 5;
#endif
/// By the wall clock, where other programs may hold the processors.
constexpr double kTimeLimit = 12 * kMostCpu_s;

// The friction rows too: each lambda is large enough for the slip whatever rounding does. Whether no method was called.
bool expect_exact_where_nothing_is_pressed(const ContactProblem& contact, const Answer& answer, const Errors& errors,
                                           const std::string& what) {
  const bool presses = answer.z.head(contact.nc() + cols(contact.D)).any();
  if (presses || answer.detail.find("at rest") == std::string::npos) return false;
  EXPECT_EQ(errors.natural_residual, 0) << what << ": " << answer.detail;
  return true;
}

// Walls, stacks, wedges, piles, card houses, robots: whatever a method gives up on, another one solves.
TEST(AutoScenesTest, SolvesEveryCollectedStepByRestWhereThatIsASolution) {
  const auto solver = auto_solver();
  std::size_t steps = 0, without_impulses = 0;
  for (const std::string& name : expand_sets("scene/*")) {
    const auto set = open_set(name);
    for (std::int64_t trial = 0; trial < set->count().value_or(0); ++trial) {
      const Problem problem = set->generate(1, trial);
      Answer answer;
      solver->load(problem);
      const double begin_s = thread_cpu_clock_s();
      solver->solve({.time_limit_s = kTimeLimit}, answer);
      EXPECT_LT(thread_cpu_clock_s() - begin_s, kMostCpu_s) << name << " " << trial << ": " << answer.detail;
      EXPECT_EQ(answer.claim, Claim::kSolved) << name << " " << trial << ": " << answer.detail;
      const std::string what = name + " " + std::to_string(trial);
      const Errors errors = Evaluator(problem).errors(answer);
      EXPECT_TRUE(errors.solved) << what << ": " << answer.detail;
      testing::expect_rest_where_it_is_a_solution(*problem.contact(), answer, what);
      if (expect_exact_where_nothing_is_pressed(*problem.contact(), answer, errors, what)) ++without_impulses;
      ++steps;
    }
  }
  std::size_t collected = 0;
  for (const CollectedScene& scene : collected_scenes()) collected += open_collected(scene)->count();
  EXPECT_EQ(steps, collected);
  EXPECT_GT(without_impulses, 0U);
}

constexpr SolveRequest kAMinute{.time_limit_s = 60};

// One object for all, each of them twice, in either order, and one object for each.
TEST(AutoScenesTest, AnAnswerDoesNotDependOnTheProblemBefore) {
  const std::vector<Problem> problems{Problem("without friction", testing::sphere_pile({.columns = 14, .layers = 17})),
                                      Problem("much friction", testing::sphere_pile({.columns = 6, .mu = 1.2})),
                                      Problem("stack", testing::box_stacks({.height = 40, .mu = 0.1})),
                                      Problem("wall", testing::frictional_brick_wall(4, 6, 0.5))};
  for (const char* error : {"0", "1e-4"}) {
    const auto shared = auto_solver({{"error", error}});
    for (std::size_t k = 0; k < 2 * problems.size(); ++k) {
      const Problem& problem = problems[k < problems.size() ? k : 2 * problems.size() - 1 - k];
      const Answer expected = solve(problem, {{"error", error}});
      for (int time = 0; time < 2; ++time) {
        shared->load(problem);
        EXPECT_EQ(solve(*shared).z, expected.z) << problem.name() << " " << error << ": " << expected.detail;
      }
    }
  }
}

// With mu above 1 no setting of psor's plain sweeps settles on all of them, friction_ipm solves none, and contact_lemke
// takes no island of this size.
TEST(AutoScenesTest, PilesWithMuchFrictionAreSolvedAtEachError) {
  for (const std::uint64_t seed : {1U, 3U}) {
    for (const double mu : {1.2, 2.0}) {
      const Problem pile("pile", testing::sphere_pile({.columns = 6, .mu = mu, .seed = seed}));
      for (const char* error : {"1e-2", "1e-6", "1e-9"}) {
        const Answer answer = solve(pile, {{"error", error}}, kAMinute);
        ASSERT_EQ(answer.claim, Claim::kSolved) << seed << " " << mu << " " << error << " " << answer.detail;
        EXPECT_LE(Evaluator(pile).errors(answer).velocity_residual_relative, 1.01 * std::stod(error));
      }
    }
  }
}

TEST(AutoScenesTest, AStatedErrorIsMet) {
  const Problem scenes[] = {Problem("pile", testing::sphere_pile({})),
                            Problem("pile with friction", testing::sphere_pile({.columns = 5, .mu = 0.5})),
                            Problem("wall", testing::brick_wall(8, 8)),
                            Problem("wall with friction", testing::frictional_brick_wall(6, 8, 0.5))};
  for (const Problem& scene : scenes) {
    for (const char* error : {"1e-9", "1e-6", "1e-4", "1e-2"}) {
      const Answer answer = solve(scene, {{"error", error}}, kAMinute);
      ASSERT_EQ(answer.claim, Claim::kSolved) << scene.name() << " " << error << " " << answer.detail;
      EXPECT_LE(Evaluator(scene).errors(answer).velocity_residual_relative, 1.01 * std::stod(error)) << scene.name();
    }
  }
}

// An error that no method reaches in double takes none out of use.
TEST(AutoScenesTest, AnErrorBelow1em12CountsAs1em12) {
  const Problem wall("wall with friction", testing::frictional_brick_wall(6, 8, 0.5));
  const Answer answer = solve(wall, {{"error", "1e-300"}});
  ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_EQ(answer.z, solve(wall, {{"error", "1e-12"}}).z) << answer.detail;
}

}  // namespace
}  // namespace lcpbench::auto_scenes_test
