// The answers of engines to captured steps, as the solver `engine`.
#include <cmath>

#include <gtest/gtest.h>

#include "core/io/problem_io.h"
#include "core/registry.h"
#include "generators/sets.h"
#include "study/evaluation/evaluation.h"
#include "study/run/open_solver.h"

namespace lcpbench::engine_solver_test {
namespace {

Answer answer_of(const Problem& problem) {
  const auto solver = make_solver({"engine", {}});
  solver->load(problem);
  Answer answer;
  solver->solve({}, answer);
  return answer;
}

TEST(EngineSolverTest, GivesTheImpulsesOfTheFile) {
  const Problem problem = open_set("scene/stack/ode")->generate(1, 3);
  ASSERT_NE(problem.engine_impulses(), nullptr);
  const Answer answer = answer_of(problem);
  EXPECT_EQ(answer.claim, Claim::kSolved);
  ASSERT_EQ(answer.z.size(), problem.size());
  EXPECT_EQ(answer.z.head(problem.engine_impulses()->size()), *problem.engine_impulses());
  const Vector w = problem.lcp().M * answer.z + problem.lcp().q;
  const ContactLayout layout = contact_layout(*problem.contact());
  EXPECT_GE(w.segment(layout.nc, layout.friction).minCoeff(), -1e-12) << "lambda completes the impulses";
}

/// Nobody measured the engine: reading its answer would be faster than any solver.
TEST(EngineSolverTest, HasNoTime) {
  TimedAnswer timed;
  open_solver({"engine", {}})->run(open_set("scene/stack/ode")->generate(1, 3), {}, timed);
  EXPECT_EQ(timed.answer.claim, Claim::kSolved);
  EXPECT_TRUE(std::isnan(timed.times.setup_cpu_s));
  EXPECT_TRUE(std::isnan(timed.times.solve_cpu_s));
}

TEST(EngineSolverTest, RefusesWhatNoEngineAnswered) {
  const auto refused = [](const Problem& problem) {
    const Answer answer = answer_of(problem);
    EXPECT_EQ(answer.claim, Claim::kUnsupported);
    EXPECT_EQ(answer.detail, "needs a captured step with the impulses of its engine");
  };
  refused(open_set("rigid/exp1")->generate(1, 0));
  refused(open_set("scene/hand/dart")->generate(1, 0));
}

/// The engine's answer is no part of the problem: neither its hash nor its file have it.
TEST(EngineSolverTest, TheProblemIsTheSameWithoutTheAnswer) {
  const Problem problem = open_set("scene/slope/bullet")->generate(1, 2);
  const Problem read = parse_problem_json(problem_json(problem), "text");
  EXPECT_EQ(read.engine_impulses(), nullptr);
  EXPECT_EQ(problem_hash(read), problem_hash(problem));
}

/// Engines are judged as solvers are: ODE solves balls that bounce, and not a heavy load on light boxes.
TEST(EngineSolverTest, IsJudged) {
  const auto solved = [](const char* set) {
    int count = 0;
    for (std::int64_t trial = 0; trial < open_set(set)->count(); ++trial) {
      const Problem problem = open_set(set)->generate(1, trial);
      count += Evaluator(problem).errors(answer_of(problem)).solved ? 1 : 0;
    }
    return count;
  };
  EXPECT_LT(solved("scene/mass-ratio-1e6/ode"), 4) << "of 8";
  EXPECT_GT(solved("scene/bouncing-balls/ode"), 0);
}

}  // namespace
}  // namespace lcpbench::engine_solver_test
