#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "core/scene.h"
#include "generators/sets.h"
#include "native/contacts/contact_columns.h"
#include "study/evaluation/evaluation.h"
#include "tests/support/sphere_piles.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/textbook_lcps.h"
#include "tests/support/two_chains.h"

namespace lcpbench {
SolverDefinition lcpbench_solver_psor();
}

namespace lcpbench::psor_test {
namespace {

std::unique_ptr<Solver> psor(const Options& options = {}) { return lcpbench_solver_psor().make(options); }

Answer solve(Solver& solver, const SolveRequest& request = {}) {
  Answer answer;
  solver.solve(request, answer);
  return answer;
}

Answer solve(const Problem& problem, const Options& options = {}, const SolveRequest& request = {}) {
  const auto solver = psor(options);
  solver->load(problem);
  return solve(*solver, request);
}

/// A point of mass 2 that meets the floor z = 0 with velocity (3, 0, -1); friction along x and y.
ContactProblem point_on_floor(double mu) {
  ContactProblem contact;
  contact.v = testing::vector_of({3, 0, -1});
  contact.N = Matrix{{0.0}, {0.0}, {1.0}};
  contact.D = Matrix{{1.0, 0.0, -1.0, 0.0}, {0.0, 1.0, 0.0, -1.0}, {0.0, 0.0, 0.0, 0.0}};
  contact.edges = {4};
  contact.mu = testing::vector_of({mu});
  contact.inertia = DenseInertia{2 * Matrix::Identity(3, 3)};
  return contact;
}

/// Cubes of unit mass and edge on each other, which fall on the floor.
RigidScene falling_stack(int bodies, int edges) {
  RigidScene scene;
  for (int b = 0; b < bodies; ++b) {
    RigidBody body;
    body.inertia = Eigen::Matrix3d::Identity() / 6;
    body.position = {0, 0, b + 0.5};
    body.linear_velocity = {0.125, 0.0, -1.0};
    body.angular_velocity = {0.0, 0.25 * b, 0.0};
    scene.bodies.push_back(body);
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.5, 0.5}) {
        RigidContact contact;
        contact.body_a = b;
        contact.body_b = b - 1;
        if (b == 0) contact.body_b = RigidContact::kWorld;
        contact.point = {x, y, static_cast<double>(b)};
        contact.mu = edges > 0 ? 0.5 : 0.0;
        contact.edges = edges;
        scene.contacts.push_back(contact);
      }
    }
  }
  return scene;
}

TEST(PsorTest, ASlidingPointIsBrakedByTheFullConeAndAStickingOneStops) {
  // f_N = 2, friction 0.5 * 2 = 1 against x: v+ = (2.5, 0, 0), lambda bounds the slip of 2.5.
  const Options exact_steps{{"relaxation", "1"}};
  const Answer sliding = solve(Problem("sliding", point_on_floor(0.5)), exact_steps);
  ASSERT_EQ(sliding.claim, Claim::kSolved) << sliding.detail;
  EXPECT_LE((sliding.z - testing::vector_of({2, 0, 0, 1, 0, 2.5})).lpNorm<Eigen::Infinity>(), 1e-14);
  // Friction up to 8: the 6 that stop the point are inside the cone, nothing slips.
  const Answer sticking = solve(Problem("sticking", point_on_floor(4)), exact_steps);
  ASSERT_EQ(sticking.claim, Claim::kSolved) << sticking.detail;
  EXPECT_LE((sticking.z - testing::vector_of({2, 0, 0, 6, 0, 0})).lpNorm<Eigen::Infinity>(), 1e-14);
  // Without friction the slip stays, and lambda bounds it.
  const Answer smooth = solve(Problem("smooth", point_on_floor(0)), exact_steps);
  EXPECT_EQ(smooth.claim, Claim::kSolved) << smooth.detail;
  EXPECT_LE((smooth.z - testing::vector_of({2, 0, 0, 0, 0, 3})).lpNorm<Eigen::Infinity>(), 1e-14);
}

// The projection's threshold lies between two slips: a direction of little slip gets no friction at all.
TEST(PsorTest, FrictionGoesWhereTheSlipIsLargest) {
  ContactProblem contact = point_on_floor(0.5);
  contact.v(1) = 2.75;  // against x: 3 - 0.5 = 2.5 < 2.75 would leave y the faster; both end at 2.625
  const Answer answer = solve(Problem("oblique", contact));
  ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_LE((answer.z - testing::vector_of({2, 0, 0, 0.75, 0.25, 2.625})).lpNorm<Eigen::Infinity>(), 1e-7);
  EXPECT_TRUE(Evaluator(Problem("oblique", contact)).errors(answer).solved);
}

// What it claims is what the evaluation finds: its residual is the evaluation's, up to the rounding of double.
TEST(PsorTest, AClaimMeansItsToleranceOnRandomContacts) {
  int claimed = 0;
  for (const char* name : {"paper/monotone/exp1", "paper/monotone/exp2", "paper/copositive/exp1"}) {
    const auto set = open_set(name);
    for (std::int64_t trial = 0; trial < 40; ++trial) {
      const Problem problem = set->generate(910, trial);
      const Answer answer = solve(problem, {{"tolerance", "1e-6"}, {"max_iterations", "300"}});
      ASSERT_TRUE(answer.claim == Claim::kSolved || answer.claim == Claim::kIterationLimit) << answer.detail;
      if (answer.claim != Claim::kSolved) continue;
      ++claimed;
      EXPECT_LE(Evaluator(problem).errors(answer).velocity_residual_relative, 1.01e-6) << name << " " << trial;
    }
  }
  EXPECT_GE(claimed, 20);  // else the loop has tested nothing
}

TEST(PsorTest, TooFewSweepsAreNoSolution) {
  const Answer answer = solve(Problem("stack", falling_stack(6, 4)), {{"max_iterations", "2"}});
  EXPECT_EQ(answer.claim, Claim::kIterationLimit);
  EXPECT_EQ(answer.counters.iterations, 2);
}

TEST(PsorTest, AnUnpressableRowIsLeftAloneAndItsApproachIsNotCalledSolved) {
  ContactProblem contact = point_on_floor(0);
  contact.D = Matrix(3, 0);
  contact.edges = {0};
  contact.inertia = InverseInertia{Vector{{1.0, 1.0, 0.0}}.asDiagonal()};  // immovable along the normal
  const Answer pressed = solve(Problem("pressed", contact));
  EXPECT_EQ(pressed.claim, Claim::kIterationLimit);
  EXPECT_EQ(pressed.z(0), 0);
  contact.v(2) = 1;
  EXPECT_EQ(solve(Problem("parting", contact)).claim, Claim::kSolved);
}

// G* = x x' with N'x = 0.1 + 0.2 - 0.3: nothing but rounding, yet an impulse of 1e17 would seem to stop the approach.
TEST(PsorTest, RoundingOfAZeroDiagonalIsNotDividedBy) {
  const Vector x{{0.1, 0.2, 0.3}};
  ContactProblem contact = point_on_floor(0);
  contact.D = Matrix(3, 0);
  contact.edges = {0};
  contact.N = Matrix{{1.0}, {1.0}, {-1.0}};
  contact.v = testing::vector_of({-1, 0, 0});
  contact.inertia = InverseInertia{x * x.transpose()};
  const Answer answer = solve(Problem("orthogonal", contact));
  EXPECT_EQ(answer.z(0), 0);
  EXPECT_EQ(answer.claim, Claim::kIterationLimit);
}

TEST(PsorTest, StartingFromTheAnswerTakesOneSweep) {
  for (const int edges : {0, 4}) {
    const Problem problem("stack", falling_stack(4, edges));
    const auto solver = psor({{"max_iterations", "100000"}});
    solver->load(problem);
    const Answer cold = solve(*solver);
    ASSERT_EQ(cold.claim, Claim::kSolved) << cold.detail;
    const Answer warm = solve(*solver, {.start = &cold.z});
    EXPECT_EQ(warm.claim, Claim::kSolved) << warm.detail;
    EXPECT_GT(cold.counters.iterations, 10);
    EXPECT_LE(warm.counters.iterations, 1);
    Vector senseless = cold.z;
    senseless(0) = std::nan("");
    EXPECT_EQ(solve(*solver, {.start = &senseless}).z, cold.z);
  }
}

TEST(PsorTest, StartsFromTheAnswerOfIslandsThatDifferInScale) {
  const Problem problem = testing::two_chains(1e10, 1e-4, testing::Storage::kSparse);
  const auto solver = psor();
  solver->load(problem);
  const Answer cold = solve(*solver);
  ASSERT_EQ(cold.claim, Claim::kSolved) << cold.detail;
  EXPECT_GT(cold.counters.iterations, 100);
  EXPECT_LE(solve(*solver, {.start = &cold.z}).counters.iterations, 1);
}

TEST(PsorTest, StartsFromNothingWhereTheStartIsBeyondDoubleInTheUnitsOfAnIsland) {
  const Problem problem = testing::two_chains(1e10, 1e-4, testing::Storage::kSparse);
  const auto solver = psor();
  solver->load(problem);
  const Answer cold = solve(*solver);
  const Vector start = Vector::Constant(problem.size(), 1e300);
  const Answer answer = solve(*solver, {.start = &start});
  EXPECT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_EQ(answer.z, cold.z);
}

// Nothing couples the two, so that each is solved as if it were alone.
TEST(PsorTest, BlocksOfABareLcpAreSolvedEachInItsScale) {
  const Matrix chain = testing::tridiagonal(20, 2, -1);
  Matrix M = Matrix::Zero(22, 22);
  M.topLeftCorner(20, 20) = chain;
  M.bottomRightCorner(2, 2) = testing::tridiagonal(2, 3, -1);
  Vector q = -testing::ones(22);
  q.tail(2) *= 1e10 / 3;
  const Problem problem("blocks", Lcp{M, q});
  const Answer answer = solve(problem);
  ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_TRUE(Evaluator(problem).errors(answer).solved);
}

TEST(PsorTest, ANewVelocityGivesTheAnswerOfANewProblem) {
  ContactProblem contact = contact_problem(falling_stack(3, 4));
  const auto updated = psor();
  updated->load(Problem("first", contact));
  contact.v *= -0.5;
  contact.v(2) -= 2;
  updated->update(contact.v);
  const Answer fresh = solve(Problem("second", contact));
  const Answer answer = solve(*updated);
  EXPECT_EQ(answer.claim, fresh.claim);
  EXPECT_EQ(answer.z, fresh.z);
  contact.v(0) = std::nan("");
  updated->update(contact.v);
  EXPECT_EQ(solve(*updated).claim, Claim::kUnsupported);
}

// Bodies' blocks and one dense matrix are two storages of the same contacts.
TEST(PsorTest, SparseContactsAreTheSameAsDenseOnes) {
  const ContactProblem sparse = contact_problem(falling_stack(3, 4));
  ContactProblem dense = sparse;
  dense.N = to_dense(sparse.N);
  dense.D = to_dense(sparse.D);
  dense.inertia = DenseInertia{dense_inertia(sparse.inertia)};
  const Options options{{"max_iterations", "50"}};
  const Answer a = solve(Problem("sparse", sparse), options);
  const Answer b = solve(Problem("dense", dense), options);
  EXPECT_EQ(a.counters.iterations, b.counters.iterations);
  // 50 sweeps of about 100 operations each on impulses of size one, no amplification in sight.
  EXPECT_LE((a.z - b.z).lpNorm<Eigen::Infinity>(), 1e-12);
}

// The model problem of the theory: the error of Gauss-Seidel falls by cos^2(pi / (n + 1)) = 0.978 per sweep, that of
// the best over-relaxation, 2 / (1 + sin(pi / (n + 1))) = 1.74, by 0.74. [Young 1954]
TEST(PsorTest, OverRelaxationSavesSweepsAsTheoryHasIt) {
  const Lcp lcp{testing::tridiagonal(20, 2, -1), -testing::ones(20)};
  const Problem problem("model", lcp);
  const Answer plain = solve(problem, {{"relaxation", "1"}});
  const Answer relaxed = solve(problem, {{"relaxation", "1.74"}});
  for (const Answer* answer : {&plain, &relaxed}) {
    ASSERT_EQ(answer->claim, Claim::kSolved) << answer->detail;
    EXPECT_LE(testing::relative_residual(lcp, answer->z), 1.01e-8);
  }
  EXPECT_NEAR(static_cast<double>(plain.counters.iterations), std::log(1e-8) / std::log(0.978), 150);
  EXPECT_LT(8 * relaxed.counters.iterations, plain.counters.iterations);  // 13 in the limit
}

// Conjugate directions need about the root of the sweeps: of the model problem, and of a stack, with friction and
// without.
TEST(PsorTest, ConjugateStepsSaveSweepsAndEndInTheSameVelocity) {
  const Options accelerated{{"acceleration", "exact"}, {"relaxation", "1"}};
  const Problem model("model", Lcp{testing::tridiagonal(20, 2, -1), -testing::ones(20)});
  const Answer plain_model = solve(model, {{"relaxation", "1"}});
  const Answer fast_model = solve(model, accelerated);
  ASSERT_EQ(fast_model.claim, Claim::kSolved) << fast_model.detail;
  EXPECT_LT(5 * fast_model.counters.iterations, plain_model.counters.iterations);
  for (const int edges : {0, 4}) {
    const ContactProblem contact = contact_problem(falling_stack(8, edges));
    const Problem problem("stack", contact);
    const Answer plain = solve(problem, {{"relaxation", "1"}, {"max_iterations", "100000"}});
    const Answer fast = solve(problem, accelerated);
    ASSERT_EQ(plain.claim, Claim::kSolved) << plain.detail;
    ASSERT_EQ(fast.claim, Claim::kSolved) << fast.detail;
    EXPECT_LT(3 * fast.counters.iterations, plain.counters.iterations) << edges;
    const Vector difference = post_impact_velocity(contact, fast.z) - post_impact_velocity(contact, plain.z);
    EXPECT_LE(difference.lpNorm<Eigen::Infinity>(), 1e-5) << edges;
  }
}

// With much friction a handful of sliding contacts keeps the sweeps from settling.
TEST(PsorTest, ExactPartsSolvePilesAboutWhichTheSweepsWander) {
  const Problem pile("pile", testing::sphere_pile({.columns = 6, .mu = 1.5, .seed = 3}));
  for (const char* relaxation : {"1", "1.3"}) {
    EXPECT_EQ(solve(pile, {{"relaxation", relaxation}}).claim, Claim::kIterationLimit) << relaxation;
    const Answer exact = solve(pile, {{"acceleration", "exact"}, {"relaxation", relaxation}});
    ASSERT_EQ(exact.claim, Claim::kSolved) << relaxation << " " << exact.detail;
    EXPECT_LE(exact.counters.iterations, 10000) << relaxation;  // the work of the parts is counted as sweeps
    EXPECT_LE(Evaluator(pile).errors(exact).velocity_residual_relative, 1.01e-8) << relaxation;
  }
  // The same object again, and one that solved something else before: parts leave nothing behind.
  const auto solver = psor({{"acceleration", "exact"}});
  solver->load(Problem("other", testing::sphere_pile({.columns = 5, .layers = 6, .mu = 2, .seed = 7})));
  solve(*solver);
  solver->load(Problem("smooth", testing::sphere_pile({})));
  EXPECT_EQ(solve(*solver).claim, Claim::kSolved);
  solver->load(pile);
  const Answer first = solve(*solver);
  EXPECT_EQ(solve(*solver).z, first.z);
  EXPECT_EQ(solve(pile, {{"acceleration", "exact"}}).z, first.z);
}

TEST(PsorTest, ExactPartsLeaveAdmissibleImpulsesAtALimit) {
  const ContactProblem contact = contact_problem(testing::sphere_pile({.columns = 5, .mu = 1.5, .seed = 4}));
  const Answer answer = solve(Problem("pile", contact),
                              {{"acceleration", "exact"}, {"relaxation", "1"}, {"max_iterations", "1000"}});
  ASSERT_EQ(answer.claim, Claim::kIterationLimit);
  const Index nc = contact.nc();
  EXPECT_GE(answer.z.head(nc).minCoeff(), 0);
  for (Index i = 0; i < nc; ++i) {
    EXPECT_LE(answer.z.segment(nc + 4 * i, 4).sum(), 1.5 * answer.z(i) * (1 + 1e-12)) << i;  // a few roundings
  }
}

// contact_lemke takes 3,000 impulses: a part of contacts with 16 edges has fewer contacts than one of contacts with
// four.
TEST(PsorTest, ExactPartsAreNoLargerThanContactLemkeTakes) {
  const Problem cradle = open_set("made/cradle{nc_max=400}")->generate(424242, 2);
  ASSERT_GT(cradle.size(), 3000);
  const Answer answer = solve(cradle, {{"acceleration", "exact"}, {"relaxation", "1"}});
  Answer nothing;
  nothing.z = Vector::Zero(cradle.size());
  EXPECT_LT(Evaluator(cradle).errors(answer).velocity_residual_relative,
            Evaluator(cradle).errors(nothing).velocity_residual_relative)
      << answer.detail;
}

TEST(PsorTest, FrictionAllocatesNothingEither) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "allocations cannot be counted in this build";
  const Problem problems[] = {open_set("paper/copositive/exp1")->generate(911, 3),
                              Problem("stack", falling_stack(8, 4)),
                              Problem("pile", testing::sphere_pile({.mu = 0.5}))};
  const auto solver = psor({{"max_iterations", "80"}});
  for (const Problem& problem : problems) {
    solver->load(problem);
    Answer answer = solve(*solver);
    const Vector start = answer.z;
    EXPECT_EQ(testing::count_allocations([&] { solver->solve({.start = &start}, answer); }), 0) << problem.name();
  }
}

TEST(PsorTest, GuaranteesNoConvergenceWithAcceleration) {
  EXPECT_STREQ(psor()->capabilities().guarantees, lcpbench_solver_psor().capabilities.guarantees);
  const std::string guarantees = psor({{"acceleration", "exact"}})->capabilities().guarantees;
  EXPECT_TRUE(guarantees.starts_with("none")) << guarantees;
}

// quickstep_sor asks for the rows of directions of its own.
TEST(ContactColumns, AreThoseOfDWhateverTheEdges) {
  ContactProblem contact = contact_problem(falling_stack(3, 4));
  const Index friction = cols(contact.D);
  contact.D = Matrix(Matrix::Ones(contact.ngc(), friction / 2));
  const ContactColumns columns = contact_columns(contact);
  EXPECT_EQ(columns.J.cols(), contact.nc() + friction / 2);
  EXPECT_EQ(columns.diagonal.size(), contact.nc() + friction / 2);
}

}  // namespace
}  // namespace lcpbench::psor_test
