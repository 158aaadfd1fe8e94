#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "generators/scenes/scenes.h"
#include "generators/sets.h"
#include "study/evaluation/evaluation.h"
#include "study/evaluation/fastest_contact.h"
#include "study/measure/least_energy_velocity.h"

namespace lcpbench {
SolverDefinition lcpbench_solver_auto();

namespace {

using testing::least_energy_velocity;

#ifdef __SANITIZE_ADDRESS__
constexpr double kTimeLimit = 60;  // sanitizers make a solve 20 times slower, and CI's processors may be shared
#else
/// Many times what the slowest step takes, and less than a method takes that does not suit it.
constexpr double kTimeLimit = 5;
#endif

void expect_rest_where_it_is_a_solution(const ContactProblem& contact, const Answer& answer, const std::string& what) {
  const double before = fastest_contact(contact, contact.v).m_per_s;
  const Vector rest = least_energy_velocity(contact);
  if (rest.size() == 0 || fastest_contact(contact, rest).m_per_s > 1e-9 * before) return;
  const double after = fastest_contact(contact, post_impact_velocity(contact, answer.z)).m_per_s;
  EXPECT_LE(after, 1e-8 * before) << what << ": " << answer.detail;
}

// Walls, stacks, wedges, piles, card houses, robots: whatever a method gives up on, another one solves.
TEST(AutoScenesTest, SolvesEveryCollectedStepByRestWhereThatIsASolution) {
  const auto solver = lcpbench_solver_auto().make({});
  std::size_t steps = 0;
  for (const std::string& name : expand_sets("scene/*")) {
    const auto set = open_set(name);
    for (std::int64_t trial = 0; trial < set->count().value_or(0); ++trial) {
      const Problem problem = set->generate(1, trial);
      Answer answer;
      solver->load(problem);
      solver->solve({.time_limit_s = kTimeLimit}, answer);
      EXPECT_EQ(answer.claim, Claim::kSolved) << name << " " << trial << ": " << answer.detail;
      EXPECT_TRUE(Evaluator(problem).errors(answer).solved) << name << " " << trial << ": " << answer.detail;
      expect_rest_where_it_is_a_solution(*problem.contact(), answer, name + " " + std::to_string(trial));
      ++steps;
    }
  }
  std::size_t collected = 0;
  for (const CollectedScene& scene : collected_scenes()) collected += open_collected(scene)->count();
  EXPECT_EQ(steps, collected);
  EXPECT_GT(steps, 0U);
}

}  // namespace
}  // namespace lcpbench
