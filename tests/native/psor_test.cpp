#include <cmath>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "core/scene.h"
#include "generators/sets.h"
#include "tests/support/box_stacks.h"
#include "tests/support/contacts.h"
#include "tests/support/solving.h"
#include "tests/support/sphere_piles.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench::psor_test {
namespace {

using testing::expect_solved;
using testing::solve;
using testing::vector_of;

/// A point of mass 2 that meets the floor z = 0 with velocity (3, y, -1); friction along x and y.
Problem point_on_floor(double mu, double y = 0) {
  return {"point", testing::point_on_floor(mu, 4, vector_of({3, y, -1}))};
}

// f_N = 2. Friction of 1 against x: v+ = (2.5, 0, 0), and lambda bounds the slip. Up to 8: the 6 that stop the point
// are inside the cone. None: the slip stays. Against x alone 2.5 < 2.75 would leave y the faster: both end at 2.625.
TEST(PsorTest, APointOnTheFloorIsBrakedAsTheConeAllows) {
  struct Case {
    double mu, y, tolerance;
    Vector z;
  };
  for (const Case& each :
       {Case{0.5, 0, 1e-14, vector_of({2, 0, 0, 1, 0, 2.5})}, Case{4, 0, 1e-14, vector_of({2, 0, 0, 6, 0, 0})},
        Case{0, 0, 1e-14, vector_of({2, 0, 0, 0, 0, 3})},
        Case{0.5, 2.75, 1e-7, vector_of({2, 0, 0, 0.75, 0.25, 2.625})}}) {
    const Problem problem = point_on_floor(each.mu, each.y);
    const Answer answer = solve("psor{relaxation=1}", problem);
    expect_solved(problem, answer);
    EXPECT_LE((answer.z - each.z).lpNorm<Eigen::Infinity>(), each.tolerance) << each.mu << " " << each.y;
  }
}

// What it claims is what the evaluation finds: its residual is the evaluation's, up to the rounding of double.
TEST(PsorTest, AClaimMeansItsToleranceOnRandomContacts) {
  int claimed = 0;
  for (const char* name : {"paper/monotone/exp1", "paper/monotone/exp2", "paper/copositive/exp1"}) {
    const auto set = open_set(name);
    for (std::int64_t trial = 0; trial < 40; ++trial) {
      const Problem problem = set->generate(910, trial);
      const Answer answer = solve("psor{tolerance=1e-6,max_iterations=300}", problem);
      ASSERT_TRUE(answer.claim == Claim::kSolved || answer.claim == Claim::kIterationLimit) << answer.detail;
      if (answer.claim != Claim::kSolved) continue;
      ++claimed;
      expect_solved(problem, answer, 1.01e-6);
    }
  }
  EXPECT_GE(claimed, 20);  // else the loop has tested nothing
}

// Immovable along the normal, by an entry of zero or by rounding: N'G*N is 0.1 + 0.2 - 0.3 squared.
TEST(PsorTest, AnUnpressableRowIsLeftAloneAndItsApproachIsNotCalledSolved) {
  const Vector x = vector_of({0.1, 0.2, 0.3});
  const Matrix immovable[] = {vector_of({1, 1, 0}).asDiagonal(), x * x.transpose()};
  for (const bool by_rounding : {false, true}) {
    ContactProblem contact = *point_on_floor(0).contact();
    contact.D = Matrix(3, 0);
    contact.edges = {0};
    contact.inertia = InverseInertia{immovable[by_rounding ? 1 : 0]};
    if (by_rounding) contact.N = Matrix{{1.0}, {1.0}, {-1.0}};
    if (by_rounding) contact.v = vector_of({-1, 0, 0});
    const Answer pressed = solve("psor", Problem("pressed", contact));
    EXPECT_EQ(pressed.claim, Claim::kIterationLimit) << by_rounding;
    EXPECT_EQ(pressed.z(0), 0) << by_rounding;
    contact.v *= -1;
    EXPECT_EQ(solve("psor", Problem("parting", contact)).claim, Claim::kSolved) << by_rounding;
  }
}

TEST(PsorTest, StartingFromTheAnswerTakesOneSweep) {
  for (const int edges : {0, 4}) {
    const Problem problem("stack", testing::box_stacks({.height = 4, .edges = edges}));
    const auto solver = make_solver(parse_spec("psor{max_iterations=100000}"));
    solver->load(problem);
    const Answer cold = solve(*solver);
    expect_solved(problem, cold);
    EXPECT_GT(cold.counters.iterations, 10);
    EXPECT_LE(solve(*solver, {.start = &cold.z}).counters.iterations, 1);
    Vector senseless = cold.z;
    senseless(0) = std::nan("");
    EXPECT_EQ(solve(*solver, {.start = &senseless}).z, cold.z);
  }
}

// The model problem of the theory: the error of Gauss-Seidel falls by cos^2(pi / (n + 1)) = 0.978 per sweep, that of
// the best over-relaxation, 2 / (1 + sin(pi / (n + 1))) = 1.74, by 0.74 [Young 1954]. Conjugate directions need about
// the root of the sweeps.
TEST(PsorTest, SavesSweepsAsTheoryHasIt) {
  const Problem problem("model", Lcp{testing::tridiagonal(20, 2, -1), -testing::ones(20)});
  const Answer plain = solve("psor{relaxation=1,parts=none}", problem);
  const Answer relaxed = solve("psor{relaxation=1.74,parts=none}", problem);
  const Answer conjugate = solve("psor{relaxation=1}", problem);
  for (const Answer* answer : {&plain, &relaxed, &conjugate}) expect_solved(problem, *answer);
  EXPECT_NEAR(static_cast<double>(plain.counters.iterations), std::log(1e-8) / std::log(0.978), 150);
  EXPECT_LT(8 * relaxed.counters.iterations, plain.counters.iterations);  // 13 in the limit
  EXPECT_LT(5 * conjugate.counters.iterations, plain.counters.iterations);
}

// With much friction a handful of sliding contacts keeps the sweeps from settling.
TEST(PsorTest, ExactPartsSolvePilesAboutWhichTheSweepsWander) {
  const Problem pile("pile", testing::sphere_pile({.columns = 6, .mu = 1.5, .seed = 3}));
  EXPECT_EQ(solve("psor{parts=none}", pile).claim, Claim::kIterationLimit);
  const Answer exact = solve("psor", pile);
  expect_solved(pile, exact, 1.01e-8);
  EXPECT_LE(exact.counters.iterations, 10000);  // the work of the parts is counted as sweeps
  // One that solved something else before: parts leave nothing behind.
  const auto solver = make_solver(parse_spec("psor"));
  solver->load(Problem("other", testing::sphere_pile({.columns = 5, .layers = 6, .mu = 2, .seed = 7})));
  solve(*solver);
  solver->load(pile);
  for (int repeat = 0; repeat < 2; ++repeat) EXPECT_EQ(solve(*solver).z, exact.z);
}

}  // namespace
}  // namespace lcpbench::psor_test
