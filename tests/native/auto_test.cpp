// `auto`: its parts, whatever an update makes of them, step to step, its memory and its limits.
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "generators/sets.h"
#include "tests/native/auto_checks.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/box_stacks.h"
#include "tests/support/brick_wall.h"
#include "tests/support/contacts.h"

namespace lcpbench::auto_test {
namespace {

using testing::auto_solver;
using testing::box_stacks;
using testing::BoxStacks;
using testing::contains;
using testing::expect_honest;
using testing::expect_verified;
using testing::falling_velocity;
using testing::frictionless;
using testing::in_dense_matrices;
using testing::solve;
using testing::solve_whole;
using testing::vec;
using testing::velocity_difference;

// --- islands ---

/// Coordinates {0, 2}, {1, 3} and {4}; contacts on the first, the second, both coordinates of the second, the third,
/// and one without any entry.
ContactProblem three_islands() {
  Matrix N = Matrix::Zero(5, 5);
  N(0, 0) = 1;
  N(1, 1) = 2;
  N(1, 2) = 1;
  N(3, 2) = 1;
  N(4, 3) = 1;
  Matrix G = 2 * Matrix::Identity(5, 5);
  G(0, 2) = G(2, 0) = 1;
  G(1, 3) = G(3, 1) = -0.5;
  return frictionless(vec({-1, -2, 0.5, -1, -3}), N, DenseInertia{G});
}

std::vector<ContactProblem> in_every_form(const ContactProblem& contact) {
  const Matrix G = dense_inertia(contact.inertia);
  ContactProblem factored = contact, inverse = contact, sparse = contact, block = contact;
  factored.inertia = FactoredInertia{Matrix(G.llt().matrixL()), Vector::Ones(G.rows())};
  inverse.inertia = InverseInertia{inverse_inertia(contact.inertia)};
  block.inertia = BlockInertia{{G}};
  sparse.N = SparseMatrix(std::get<Matrix>(contact.N).sparseView());
  sparse.D = SparseMatrix(5, 0);
  return {contact, factored, inverse, block, sparse};
}

TEST(AutoTest, SolvesIslandsInEveryFormOfInertia) {
  for (const ContactProblem& contact : in_every_form(three_islands())) {
    const Problem problem("islands", contact);
    const Answer answer = solve(problem);
    expect_verified(problem, answer, "islands");
    EXPECT_TRUE(contains(answer.detail, "3 islands; active_set 3; double")) << answer.detail;
    const Answer whole = solve_whole(problem);
    expect_verified(problem, whole, "whole");
    EXPECT_LE(velocity_difference(problem, answer, whole), 1e-14);
    ASSERT_EQ(answer.velocity.size(), 5);
    EXPECT_LE((answer.velocity - post_impact_velocity(contact, answer.z)).lpNorm<Eigen::Infinity>(), 1e-14);
  }
}

class AutoOnStacks : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Islands, AutoOnStacks, ::testing::Values(2, 3, 7, 20, 60, 200));

// Without friction the velocity is unique: whole and parts must agree on it.
TEST_P(AutoOnStacks, FindsTheVelocityOfTheWholeWithoutFriction) {
  const Problem problem("stacks", box_stacks({.stacks = GetParam(), .height = 2, .edges = 0, .lifted = 3}));
  const Answer parts = solve(problem);
  expect_verified(problem, parts, "parts");
  const Index lifted = GetParam() / 3;
  EXPECT_TRUE(contains(parts.detail, std::to_string(GetParam()) + " islands")) << parts.detail;
  if (lifted > 0) {
    EXPECT_TRUE(contains(parts.detail, std::to_string(lifted) + " at rest")) << parts.detail;
  }
  const Answer whole = solve_whole(problem);
  expect_verified(problem, whole, "whole");
  EXPECT_LE(velocity_difference(problem, parts, whole), 1e-12);
}

TEST_P(AutoOnStacks, FindsAVerifiedVelocityWithFriction) {
  const Problem problem("stacks", box_stacks({.stacks = GetParam(), .height = 2, .lifted = 3}));
  const Answer parts = solve(problem);
  expect_verified(problem, parts, "parts");
  if (GetParam() > 20) return;  // the whole is beyond dense matrices
  const Answer whole = solve_whole(problem);
  expect_verified(problem, whole, "whole");
  EXPECT_LE(velocity_difference(problem, parts, whole), 1e-12);
}

// --- what is left out ---

/// A stack of cubes, of which all from `first` on fly up, each faster than the one below it. None: first = height.
ContactProblem flying_from(int first, int height, int edges) {
  ContactProblem contact = contact_problem(box_stacks({.stacks = 1, .height = height, .edges = edges}));
  for (int b = first; b < height; ++b) contact.v(6 * b + 2) = 0.25 * (b - first + 1);
  return contact;
}

TEST(AutoTest, AnUpdateMakesAnythingPressAndRest) {
  for (const auto& [height, edges] : {std::pair(24, 0), std::pair(24, 4), std::pair(40, 0)}) {
    const int half = height / 2;
    const auto solver = auto_solver();
    solver->load(Problem("all fly", flying_from(0, height, edges)));
    EXPECT_TRUE(contains(solve(*solver).detail, "1 at rest")) << edges;
    for (const int first : {half, 3 * half / 2, 0, half, half + 1, height, half / 2, half}) {
      const ContactProblem contact = flying_from(first, height, edges);
      const Problem now("from " + std::to_string(first) + " of " + std::to_string(height), contact);
      solver->update(contact.v);
      const Answer answer = solve(*solver);
      expect_verified(now, answer, now.name());
      EXPECT_EQ(contains(answer.detail, "1 at rest"), first == 0) << answer.detail;
      EXPECT_LE(velocity_difference(now, answer, solve_whole(now)), 1e-12) << now.name();
    }
  }
}

// --- the study's problems ---

class AutoOnSets : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(FullRank, AutoOnSets, ::testing::ValuesIn(testing::full_rank_sets()), testing::paper_set_name);

TEST_P(AutoOnSets, SolvesEveryProblem) {
  const auto set = open_set(GetParam());
  const auto solver = auto_solver();
  for (std::int64_t trial = 0; trial < 25; ++trial) {
    const Problem problem = set->generate(8101, trial);
    solver->load(problem);
    testing::expect_solved(problem, solve(*solver));
  }
}

// An answer that is used again has no proof left from the problem before.
TEST(AutoTest, ProvesNothingAboutTheNextProblem) {
  ContactProblem contact = three_islands();
  const Problem solvable("solvable", contact);
  contact.b = Vector::Zero(contact.nc());
  contact.b(4) = -1;  // of the contact that nothing moves
  const auto solver = auto_solver();
  Answer answer;
  solver->load(Problem("unsolvable", contact));
  solver->solve({}, answer);
  ASSERT_EQ(answer.claim, Claim::kUnsolvable);
  EXPECT_EQ(static_cast<const Vector&>(answer.farkas), Vector(Vector::Unit(contact.nc(), 4)));
  solver->load(solvable);
  solver->solve({}, answer);
  EXPECT_EQ(answer.claim, Claim::kSolved);
  EXPECT_EQ(answer.farkas.size(), 0);
}

// A negative offset, as of a restitution, used to ask for the error of the verdict.
TEST(AutoTest, AStatedErrorIsEnoughWhereAnOffsetIsNegative) {
  const Problem wall("wall", testing::frictional_brick_wall(6, 8, 0.5));
  ContactProblem contact = *wall.contact();
  contact.b = Vector::Zero(contact.nc());
  contact.b(0) = -1e-3;
  const Problem problem("bounces", contact);
  const Answer answer = solve("auto{error=1e-2}", problem);
  EXPECT_EQ(answer.claim, Claim::kSolved);
  const double residual = Evaluator(problem).errors(answer).velocity_residual_relative;
  EXPECT_LE(residual, 1e-2);
  EXPECT_GT(residual, 1e-4);
}

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

TEST(AutoTest, FromTheLastAnswerARestingStepTakesLessThanHalfThePivots) {
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

std::size_t bytes_taken_in_load(const Problem& problem) {
  const auto solver = auto_solver();
  testing::count_allocations([&] { solver->load(problem); });
  return testing::counted_bytes();
}

TEST(AutoTest, ALoadTakesTheMemoryOfItsMethodOnceForAllSmallIslands) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "allocations cannot be counted in this build";
  for (const int edges : {0, 4}) {
    const auto stacks = [edges](int count) {
      return Problem("stacks", box_stacks({.stacks = count, .height = 2, .edges = edges}));
    };
    const std::size_t one = bytes_taken_in_load(stacks(1));
    // Without friction an island's own data are 0.63 of what a load of one island takes.
    EXPECT_LT(bytes_taken_in_load(stacks(21)) - bytes_taken_in_load(stacks(11)), 7.5 * static_cast<double>(one))
        << edges << " edges";
  }
}

/// Problems of several islands that differ in what their parts have: offsets, softness, friction, and how J and the
/// inertia are given.
std::vector<Problem> unlike_stacks() {
  const ContactProblem rigid = *Problem("stacks", box_stacks({.stacks = 4, .height = 2, .slide = 2})).contact();
  ContactProblem offset = rigid, soft = rigid, slippery = rigid;
  offset.b = Vector::LinSpaced(rigid.nc(), -0.05, 0.05);
  soft.compliance_n = Vector::Constant(rigid.nc(), 1e-3);
  soft.compliance_t = Vector::Constant(rigid.nc(), 2e-3);
  soft.offset_t = Vector::LinSpaced(2 * rigid.nc(), -0.01, 0.01);
  slippery.mu.head(rigid.nc() / 2).setZero();
  return {Problem("rigid", rigid),       Problem("offset", offset),
          Problem("soft", soft),         Problem("dense", in_dense_matrices(rigid)),
          Problem("slippery", slippery), Problem("few", box_stacks({.stacks = 2}))};
}

// The parts of the last problem are written over: nothing of it may be left, and nothing that a solver still reads may
// change.
TEST(AutoTest, LoadsIntoTheMemoryOfUnlikeProblems) {
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

TEST(AutoTest, ALoadOfTheNextStepAllocatesTwiceForAnIslandAtMost) {
  const Problem problem("stacks", box_stacks({.stacks = 8, .height = 2}));
  const auto solver = auto_solver();
  for (int step = 0; step < 3; ++step) {
    solver->load(problem);
    solve(*solver);
  }
  EXPECT_LE(testing::count_allocations([&] { solver->load(problem); }), 2 * 8);
}

/// A stack whose inertia couples all its coordinates: one island that is the whole problem. Every other cube is
/// heavier.
Problem large_and_dense(double ratio, double slide) {
  RigidScene scene = box_stacks({.stacks = 1, .height = 12, .jitter = 1});
  for (std::size_t b = 0; b < scene.bodies.size(); b += 2) {
    scene.bodies[b].mass *= ratio;
    scene.bodies[b].inertia *= ratio;
  }
  ContactProblem contact = contact_problem(scene);
  Matrix G = dense_inertia(contact.inertia);
  G.array() += 0.01;
  contact.inertia = DenseInertia{G};
  for (Index x = 0; x < contact.ngc(); x += 6) contact.v(x) += slide;
  return Problem("large and dense", contact);
}

// None of four methods is done in its first turn. With more work, in a later round, one of them is.
TEST(AutoTest, MethodsHaveLaterTurnsWithMoreWork) {
  const Problem problem = open_set("made/packing{nc_max=60}")->generate(1, 1);
  const Answer answer = solve(problem);
  EXPECT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_TRUE(Evaluator(problem).errors(answer).solved);
  EXPECT_TRUE(contains(answer.detail, "contact_lemke, friction_ipm, psor, contact_ipm")) << answer.detail;
}

// Where the time limit ends a solve, the best iterate is handed out, and claimed where it passes the test.
TEST(AutoTest, AnswersWithItsBestIterateWhereTheTimeIsUp) {
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

}  // namespace
}  // namespace lcpbench::auto_test
