#include <atomic>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "generators/sets.h"
#include "native/auto/lanes.h"
#include "study/measure/box_stacks.h"

namespace lcpbench {
SolverDefinition lcpbench_solver_auto();

namespace {

using testing::box_stacks;

std::unique_ptr<Solver> auto_solver(const Options& options = {}) { return lcpbench_solver_auto().make(options); }

Answer solve(Solver& solver, const SolveRequest& request = {}) {
  Answer answer;
  solver.solve(request, answer);
  return answer;
}

std::string summary(const Answer& answer) {
  return std::string(to_string(answer.claim)) + ", " + answer.detail + ", " + std::to_string(answer.counters.pivots) +
         " pivots, " + std::to_string(answer.counters.iterations) + " iterations";
}

void expect_same(const Answer& answer, const Answer& expected, const std::string& what) {
  EXPECT_EQ(summary(answer), summary(expected)) << what;
  EXPECT_EQ(static_cast<const Vector&>(answer.z), expected.z) << what;
  EXPECT_EQ(static_cast<const Vector&>(answer.velocity), expected.velocity) << what;
  EXPECT_EQ(static_cast<const Vector&>(answer.farkas), expected.farkas) << what;
}

/// Islands of several sizes and methods, at rest and not.
std::vector<Problem> problems_of_many_islands() {
  std::vector<Problem> problems;
  for (const int edges : {0, 4}) {
    for (const int height : {1, 2, 3, 5}) {
      problems.emplace_back("stacks", box_stacks({.stacks = 12, .height = height, .edges = edges, .lifted = height}));
    }
  }
  problems.push_back(open_set("scene/humanoids-22/mujoco")->generate(1, 1));
  return problems;
}

TEST(AutoThreadsTest, TheAnswerIsTheSameForAnyNumber) {
  for (const Problem& problem : problems_of_many_islands()) {
    for (const char* limit : {"0", "200"}) {
      const auto alone = auto_solver({{"max_pivots", limit}});
      alone->load(problem);
      Answer expected = solve(*alone);
      for (const char* threads : {"2", "3", "4"}) {
        const std::string what = problem.name() + ", threads=" + threads + ", max_pivots=" + limit;
        const auto together = auto_solver({{"threads", threads}, {"max_pivots", limit}});
        together->load(Problem("few", box_stacks({.stacks = 2, .edges = 0})));
        together->load(problem);
        Answer answer = solve(*together);
        expect_same(answer, expected, what);
        alone->load(problem);
        Answer last = solve(*alone);
        for (const double factor : {0.75, -0.5, 1.25}) {
          const Vector v = factor * problem.contact()->v;
          const Vector start = answer.z;
          const Vector start_alone = last.z;
          together->update(v);
          alone->update(v);
          answer = solve(*together, {.start = &start});
          last = solve(*alone, {.start = &start_alone});
          expect_same(answer, last, what + ", after an update");
        }
      }
    }
  }
}

// G of two of the islands is singular, and their contacts approach: the first of them in the problem is the one told
// of.
TEST(AutoThreadsTest, TheFirstIslandThatFailsIsTold) {
  ContactProblem contact;
  constexpr Index kIslands = 128;
  contact.v = Vector::Constant(kIslands, -1);
  contact.N = Matrix(Matrix::Identity(kIslands, kIslands));
  contact.D = Matrix(kIslands, 0);
  contact.edges.assign(kIslands, 0);
  contact.mu = Vector::Zero(kIslands);
  Matrix Ginv = Matrix::Identity(kIslands, kIslands);
  for (const Index singular : {Index{70}, Index{101}}) {
    Ginv(singular, singular) = 1;
    Ginv(singular, singular - 1) = Ginv(singular - 1, singular) = -1;
  }
  contact.inertia = InverseInertia{Ginv};
  for (const Index singular : {Index{70}, Index{101}}) {  // moves with its neighbour only, against it
    std::get<Matrix>(contact.N)(singular - 1, singular) = 1;
    std::get<Matrix>(contact.N).col(singular - 1) = std::get<Matrix>(contact.N).col(singular);
  }
  const Problem problem("singular", contact);
  const auto alone = auto_solver();
  alone->load(problem);
  const Answer expected = solve(*alone);
  EXPECT_EQ(expected.claim, Claim::kUnsolvable);
  for (const char* threads : {"2", "4"}) {
    const auto together = auto_solver({{"threads", threads}});
    together->load(problem);
    for (int repeat = 0; repeat < 5; ++repeat) expect_same(solve(*together), expected, threads);
  }
}

TEST(AutoThreadsTest, TheTimeLimitHoldsOverAllLanes) {
  const auto solver = auto_solver({{"threads", "3"}});
  solver->load(Problem("stacks", box_stacks({.stacks = 20, .height = 3})));
  EXPECT_EQ(solve(*solver, {.time_limit_s = 0}).claim, Claim::kTimeLimit);
  EXPECT_EQ(solve(*solver, {.time_limit_s = 1e-9}).claim, Claim::kTimeLimit);
  EXPECT_EQ(solve(*solver, {.time_limit_s = 60}).claim, Claim::kSolved);
}

TEST(AutoThreadsTest, WhatALaneThrowsArrives) {
  std::atomic<int> done = 0;
  EXPECT_THROW(run_lanes(3,
                         [&](std::size_t lane) {
                           ++done;
                           if (lane == 1) throw std::bad_alloc();
                           if (lane == 2) throw std::logic_error("the second");
                         }),
               std::bad_alloc);
  EXPECT_EQ(done, 3);
  const std::thread::id here = std::this_thread::get_id();
  run_lanes(1, [&](std::size_t) { EXPECT_EQ(std::this_thread::get_id(), here); });
  run_lanes(0, [&](std::size_t) { ADD_FAILURE(); });
}

}  // namespace
}  // namespace lcpbench
