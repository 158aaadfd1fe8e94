// `auto` from step to step, its memory and its limits.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/islands.h"
#include "core/timed_solve.h"
#include "generators/sets.h"
#include "tests/support/box_stacks.h"
#include "tests/native/auto_checks.h"
#include "tests/support/allocation_counter.h"

namespace lcpbench {
SolverDefinition lcpbench_solver_active_set();
}

namespace lcpbench::auto_steps_test {
namespace {

using testing::auto_solver;
using testing::contains;
using testing::expect_claimed;
using testing::expect_verified;
using testing::solve;
using testing::velocity_difference;
using testing::with_an_island_more;
using testing::box_stacks;
using testing::BoxStacks;
using testing::falling_velocity;

// --- steps ---

struct StepCounts {
  std::int64_t cold = 0, warm = 0;
};

/// Pivots over steps of stacks that stay at rest, from z = 0 and from the last answer. Every answer is verified.
StepCounts count_pivots(const BoxStacks& shape, int steps) {
  const Problem first("resting", box_stacks(shape));
  const auto cold = auto_solver();
  const auto warm = auto_solver();
  cold->load(first);
  warm->load(first);
  Answer last = solve(*warm);
  StepCounts counts;
  for (int step = 1; step <= steps; ++step) {
    ContactProblem contact = *first.contact();
    contact.v = falling_velocity(shape, step);
    cold->update(contact.v);
    warm->update(contact.v);
    const Vector start = last.z;
    last = solve(*warm, {.start = &start});
    const Answer anew = solve(*cold);
    const Problem now("step", contact);
    expect_verified(now, last, "warm, step " + std::to_string(step));
    expect_verified(now, anew, "cold, step " + std::to_string(step));
    counts.warm += last.counters.pivots;
    counts.cold += anew.counters.pivots;
  }
  return counts;
}

TEST(AutoStepsTest, FromTheLastAnswerARestingStepTakesLessThanHalfThePivots) {
  for (const int edges : {0, 4}) {
    for (const int height : {1, 3, 5}) {
      const StepCounts counts = count_pivots({.stacks = 3, .height = height, .edges = edges, .fresh = 0.2}, 20);
      EXPECT_GT(counts.cold, 0);
      EXPECT_LE(2 * counts.warm, counts.cold) << edges << " edges, height " << height;
      // What the step draws anew is as large as all that friction has to resist, which turns round at every contact.
      const StepCounts upset = count_pivots({.stacks = 3, .height = height, .edges = edges}, 10);
      EXPECT_LE(2 * upset.warm, upset.cold) << edges << " edges, height " << height;
    }
  }
}

// A path of contact_lemke may end in another solution, in which the stack moves.
TEST(AutoStepsTest, LargeIslandsThatFrictionMayHoldRest) {
  // 4 contacts and 6 coordinates for each box: sizes of 2,400 and 6,144.
  for (const int height : {10, 16}) {
    const BoxStacks shape{.stacks = 1, .height = height, .edges = 4, .fresh = 0.2};
    const auto solver = auto_solver();
    solver->load(Problem("resting", box_stacks(shape)));
    Answer last = solve(*solver);
    for (int step = 1; step <= 5; ++step) {
      ContactProblem contact = *Problem("resting", box_stacks(shape)).contact();
      contact.v = falling_velocity(shape, step);
      solver->update(contact.v);
      const std::string cold = solve(*solver).detail;
      EXPECT_TRUE(cold == "least_energy, double" || cold == "friction_ipm, double") << cold;
      const Vector start = last.z;
      last = solve(*solver, {.start = &start});
      expect_verified(Problem("step", contact), last, "step " + std::to_string(step));
      EXPECT_EQ(last.detail, "sticking_contacts, double") << "step " << step << " of " << height;
      const Vector u = post_impact_velocity(contact, last.z);
      EXPECT_LE(u.lpNorm<Eigen::Infinity>(), 1e-9 * contact.v.lpNorm<Eigen::Infinity>());
    }
  }
}

TEST(AutoStepsTest, AnUpdateIsAsGoodAsALoad) {
  const BoxStacks shape{.stacks = 4, .height = 3, .lifted = 2};
  const Problem first("stacks", box_stacks(shape));
  const auto solver = auto_solver();
  solver->load(first);
  solve(*solver);
  for (int step = 1; step <= 4; ++step) {
    ContactProblem contact = *first.contact();
    contact.v = falling_velocity({.stacks = 4, .height = 3, .lifted = step % 2 == 0 ? 2 : 4}, step);
    solver->update(contact.v);
    const Problem now("step", contact);
    const Answer updated = solve(*solver);
    expect_verified(now, updated, "step " + std::to_string(step));
    EXPECT_LE(velocity_difference(now, updated, solve(now)), 1e-12) << step;
  }
  for (const char* name : {"paper/monotone/exp2", "paper/copositive/exp5-1e5"}) {
    const auto set = open_set(name);
    const Problem problem = set->generate(5, 3);
    solver->load(problem);
    solve(*solver);
    ContactProblem next = *problem.contact();
    next.v *= -1;
    solver->update(next.v);
    const Answer updated = solve(*solver);
    const Answer fresh = solve(Problem("fresh", next));
    EXPECT_EQ(updated.z, fresh.z) << name;
    EXPECT_EQ(updated.counters.pivots, fresh.counters.pivots) << name;
    EXPECT_EQ(updated.detail, fresh.detail) << name;
  }
}

TEST(AutoStepsTest, AllocatesNothingInASolveThatNeedsNoSecondMethod) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "allocations cannot be counted in this build";
  const auto solver = auto_solver();
  std::vector<Problem> problems{Problem("stacks", box_stacks({.stacks = 5, .height = 3, .lifted = 3})),
                                Problem("smooth stacks", box_stacks({.stacks = 5, .height = 3, .edges = 0}))};
  for (const char* name : {"paper/monotone/exp5-1e10", "paper/copositive/exp5-1e10{redundancy=combination}"}) {
    for (std::int64_t trial = 0; trial < 20; ++trial) problems.push_back(open_set(name)->generate(8, trial));
  }
  int counted = 0;
  for (const Problem& problem : problems) {
    solver->load(problem);
    Answer answer;
    answer.reserve(problem);
    // Rest may be sought after an answer that slips: a second method, which is loaded then.
    if (problem.contact()->frictional()) solver->solve({}, answer);
    const auto allocations = testing::count_allocations([&] { solver->solve({}, answer); });
    EXPECT_EQ(answer.claim, Claim::kSolved);
    if (contains(answer.detail, "psor") || contains(answer.detail, "friction_ipm")) continue;
    EXPECT_EQ(allocations, 0) << problem.name();
    ++counted;
  }
  EXPECT_GE(counted, 25);
}

std::size_t bytes_taken_in_load(const Problem& problem) {
  const auto solver = auto_solver();
  testing::count_allocations([&] { solver->load(problem); });
  return testing::counted_bytes();
}

TEST(AutoStepsTest, ALoadTakesTheMemoryOfItsMethodOnceForAllSmallIslands) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "allocations cannot be counted in this build";
  for (const int edges : {0, 4}) {
    const auto stacks = [edges](int count) {
      return Problem("stacks", box_stacks({.stacks = count, .height = 2, .edges = edges}));
    };
    const std::size_t one = bytes_taken_in_load(stacks(1));
    EXPECT_LT(bytes_taken_in_load(stacks(21)) - bytes_taken_in_load(stacks(11)), 10 * one / 2) << edges << " edges";
  }
}

/// Problems of several islands that differ in what their parts have: offsets, softness, friction, and how J and the
/// inertia are given.
std::vector<Problem> unlike_stacks() {
  const ContactProblem rigid = *Problem("stacks", box_stacks({.stacks = 4, .height = 2, .slide = 2})).contact();
  ContactProblem offset = rigid, soft = rigid, dense = rigid, slippery = rigid;
  offset.b = Vector::LinSpaced(rigid.nc(), -0.05, 0.05);
  soft.compliance_n = Vector::Constant(rigid.nc(), 1e-3);
  soft.compliance_t = Vector::Constant(rigid.nc(), 2e-3);
  soft.offset_t = Vector::LinSpaced(2 * rigid.nc(), -0.01, 0.01);
  dense.inertia = DenseInertia{dense_inertia(rigid.inertia)};
  dense.N = to_dense(rigid.N);
  dense.D = to_dense(rigid.D);
  slippery.mu.head(rigid.nc() / 2).setZero();
  return {Problem("rigid", rigid), Problem("offset", offset),     Problem("soft", soft),
          Problem("dense", dense), Problem("slippery", slippery), Problem("few", box_stacks({.stacks = 2}))};
}

// The parts of the last problem are written over: nothing of it may be left, and nothing that a solver still reads may
// change.
TEST(AutoStepsTest, LoadsIntoTheMemoryOfUnlikeProblems) {
  const auto solver = auto_solver();
  const std::vector<Problem> problems = unlike_stacks();
  for (std::size_t k = 0; k < 3 * problems.size(); ++k) {
    for (const std::size_t next : {k, 5 * k + 1, 5 * k + 1}) {
      const Problem& problem = problems[next % problems.size()];
      solver->load(problem);
      const Answer kept = solve(*solver);
      const Answer fresh = solve(problem);
      EXPECT_EQ(kept.claim, fresh.claim) << problem.name();
      EXPECT_EQ(kept.z, fresh.z) << problem.name();
      EXPECT_EQ(kept.velocity, fresh.velocity) << problem.name();
    }
  }
}

TEST(AutoStepsTest, ALoadOfTheNextStepAllocatesTwiceForAnIslandAtMost) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "allocations cannot be counted in this build";
  const Problem problem("stacks", box_stacks({.stacks = 8, .height = 2}));
  const auto solver = auto_solver();
  for (int step = 0; step < 3; ++step) {
    solver->load(problem);
    solve(*solver);
  }
  EXPECT_LE(testing::count_allocations([&] { solver->load(problem); }), 2 * 8);
}

// The impulses of the last step hold as they are: no method is loaded, and the velocity is zero to the last bit.
TEST(AutoStepsTest, SmallIslandsThatRestedRestAgain) {
  const Problem problem("stacks", box_stacks({.stacks = 6, .height = 2, .edges = 4, .fresh = 0}));
  const auto solver = auto_solver();
  solver->load(problem);
  Answer last = solve(*solver);
  EXPECT_GT(last.counters.pivots, 0);
  for (int step = 0; step < 3; ++step) {
    const Vector start = last.z;
    solver->update(problem);
    last = solve(*solver, {.start = &start});
    expect_verified(problem, last, "step " + std::to_string(step));
    EXPECT_EQ(last.counters.pivots, 0) << step;
    EXPECT_EQ(last.velocity.size(), problem.contact()->ngc());
    EXPECT_FALSE(last.velocity.any()) << step;
  }
}

/// Of what no method but another may get through: every other cube is heavier.
RigidScene uneven_stack(int height, int edges, double ratio) {
  RigidScene scene = box_stacks({.stacks = 1, .height = height, .edges = edges, .jitter = 1});
  for (std::size_t b = 0; b < scene.bodies.size(); b += 2) {
    scene.bodies[b].mass *= ratio;
    scene.bodies[b].inertia *= ratio;
  }
  return scene;
}
// --- limits and refusals ---

TEST(AutoStepsTest, ObeysItsLimits) {
  const std::vector<Problem> problems{Problem("stacks", box_stacks({.stacks = 3, .height = 2})),
                                      open_set("paper/copositive/exp1")->generate(61, 3),
                                      open_set("paper/monotone/exp1")->generate(61, 2)};
  for (const Problem& problem : problems) {
    EXPECT_EQ(solve(problem, {}, {.time_limit_s = 0}).claim, Claim::kTimeLimit) << problem.name();
  }
}

/// A stack whose inertia couples all its coordinates: one island that is the whole problem.
Problem large_and_dense(double ratio, double slide) {
  ContactProblem contact = *Problem("stack", uneven_stack(12, 4, ratio)).contact();
  Matrix G = dense_inertia(contact.inertia);
  G.array() += 0.01;
  contact.inertia = DenseInertia{G};
  for (Index x = 0; x < contact.ngc(); x += 6) contact.v(x) += slide;
  return Problem("large and dense", contact);
}

// Where the time limit ends a solve, the best iterate is handed out, and claimed where it passes the test.
TEST(AutoStepsTest, AnswersWithItsBestIterateWhereTheTimeIsUp) {
  for (const auto& [ratio, slide] : {std::pair{1.0, 0.0}, {1.0, 5.0}, {1e8, 0.0}, {1e8, 5.0}}) {
    const Problem problem = large_and_dense(ratio, slide);
    int failures = 0;
    for (double limit_s = 1e-6; limit_s < 0.03; limit_s *= 1.25) {
      const Answer answer = solve(problem, {}, {.time_limit_s = limit_s});
      const Errors errors = Evaluator(problem).errors(answer);
      EXPECT_EQ(answer.z.size(), problem.size()) << limit_s;
      EXPECT_TRUE(answer.claim != Claim::kSolved || errors.solved) << limit_s;
      if (answer.claim == Claim::kSolved) continue;
      ++failures;
      EXPECT_EQ(answer.claim, Claim::kTimeLimit) << limit_s;
      EXPECT_EQ(answer.counters, Counters{}) << limit_s;  // no method ended, and told its work: not 0
      EXPECT_EQ(answer.velocity.size(), 0) << limit_s;
      double told = 1;  // z = 0, where nothing was found; else two digits
      std::sscanf(answer.detail.c_str(), "best residual %lf", &told);
      EXPECT_LE(errors.velocity_residual_relative, 1.05 * told) << limit_s << ": " << answer.detail;
    }
    EXPECT_GT(failures, 0);
  }
}

// Contacts of islands at rest have the slip as their lambda, whatever becomes of the other islands.
TEST(AutoStepsTest, AFailedIslandLeavesTheOthersTheirAnswers) {
  const Problem problem("stacks", box_stacks({.stacks = 2, .height = 12, .edges = 4, .lifted = 2, .slide = 5}));
  const ContactProblem& contact = *problem.contact();
  const Answer answer = solve(problem, {}, {.time_limit_s = 1e-9});
  ASSERT_EQ(answer.claim, Claim::kTimeLimit) << answer.detail;
  const ContactLayout layout = contact_layout(contact);
  double fastest = 0;
  for (const Island& island : find_islands(contact)) {
    const bool rests = std::all_of(island.contacts.begin(), island.contacts.end(),
                                   [&](Index c) { return !(dot_column(contact.N, c, contact.v) < 0); });
    if (!rests) continue;
    for (const Index c : island.contacts) {
      const auto k = static_cast<std::size_t>(c);
      double slip = 0;
      for (Index t = layout.friction_begin[k]; t < layout.friction_begin[k + 1]; ++t) {
        slip = std::max(slip, std::abs(dot_column(contact.D, t, contact.v)));
      }
      EXPECT_GE(answer.z(layout.lambda_offset() + layout.lambda[k]), slip * (1 - 1e-12)) << c;  // of the sum's rounding
      fastest = std::max(fastest, slip);
    }
  }
  EXPECT_GT(fastest, 3);  // on the ground, at 5 m/s
}

// Two velocities of 1e400 m/s, one the other way: their sum is no number in double, and no contact at rest.
ContactProblem overflowing() {
  ContactProblem contact;
  contact.v = Vector{{1e200, 2e200}};
  contact.N = Matrix{{0, 1e200}, {0, -1e200}};
  contact.D = Matrix(2, 0);
  contact.edges.assign(2, 0);
  contact.mu = Vector::Zero(2);
  contact.inertia = DenseInertia{Matrix::Identity(2, 2)};
  return contact;
}

TEST(AutoStepsTest, TakesNothingThatOverflowsForRest) {
  ContactProblem contact = overflowing();
  ASSERT_GT(solve(Problem("overflow", contact)).z.sum(), 0);
  for (const bool bodies : {false, true}) {
    if (bodies) contact.inertia = BlockInertia{{Matrix::Identity(1, 1), Matrix::Identity(1, 1)}};
    for (const char* name : {"velocity_ipm{finish=false}", "friction_ipm", "proximal_newton", "psor",
                             "quickstep_sor"}) {
      const auto solver = make_solver(parse_spec(name));
      solver->load(Problem("overflow", contact));
      Answer answer;
      solver->solve({}, answer);
      EXPECT_NE(answer.claim, Claim::kSolved) << name << (bodies ? ", bodies" : "");
    }
  }
}

TEST(AutoStepsTest, RefusesWhatIsNoNumber) {
  const auto solver = auto_solver();
  const Problem problem("stacks", box_stacks({.stacks = 2}));
  solver->load(problem);
  Vector v = problem.contact()->v;
  v(3) = std::nan("");
  solver->update(v);
  EXPECT_EQ(solve(*solver).claim, Claim::kUnsupported);
  ContactProblem infinite = *problem.contact();
  infinite.mu(0) = INFINITY;
  EXPECT_EQ(solve(Problem("infinite", infinite)).claim, Claim::kUnsupported);
}

}  // namespace
}  // namespace lcpbench::auto_steps_test
