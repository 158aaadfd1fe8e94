// Each adapter on problems whose answers have no symmetry to hide behind: a wrong sign, stride, half, transpose or unit
// shows. Every library runs in its worker, as in a study. Missing libraries are skipped by name.
#include <limits>

#include <gtest/gtest.h>

#include "tests/adapters/library_runs.h"
#include "tests/support/contacts.h"

namespace lcpbench::adapter_conventions_test {
namespace {

using testing::frictionless;

// z = (1, 0, 2), w = (0, 3, 0) by construction; M symmetric positive definite, no two entries alike.
Problem symmetric_problem() {
  Lcp lcp;
  lcp.M = Matrix{{5.0, 1.0, 2.0}, {1.0, 6.0, -1.0}, {2.0, -1.0, 7.0}};
  lcp.q = Vector{{0.0, 3.0, 0.0}} - lcp.M * Vector{{1.0, 0.0, 2.0}};
  return Problem("symmetric", lcp);
}

// The same (q, M), of contacts without friction.
Problem as_contacts(const Problem& problem) {
  const Lcp& lcp = problem.lcp();
  const Matrix identity = Matrix::Identity(lcp.size(), lcp.size());
  return Problem(problem.name(), frictionless(lcp.q, identity, InverseInertia{lcp.M}));
}

// The same answer; M is positive definite but far from symmetric: with its transpose the answer is another.
Problem nonsymmetric_problem() {
  Lcp lcp;
  lcp.M = Matrix{{5.0, 4.0, -2.0}, {-3.0, 6.0, 1.0}, {2.5, -2.0, 7.0}};
  lcp.q = Vector{{0.0, 3.0, 0.0}} - lcp.M * Vector{{1.0, 0.0, 2.0}};
  return Problem("nonsymmetric", lcp);
}

// A turning box on three points that are not in line with its centre: M is regular and has no symmetry.
Problem falling_box() {
  RigidScene scene;
  RigidBody body;
  body.mass = 2.0;
  body.inertia = Eigen::Vector3d(0.5, 4.0, 8.0).asDiagonal();
  body.position = {0.25, 0.5, 1.0};
  body.linear_velocity = {0.0, 0.0, -3.0};
  body.angular_velocity = {0.5, -1.0, 0.25};
  scene.bodies = {body};
  scene.contacts.push_back({.body_a = 0, .point = {1.25, 0.25, 0.0}});
  scene.contacts.push_back({.body_a = 0, .point = {-1.25, 0.75, 0.0}});
  scene.contacts.push_back({.body_a = 0, .point = {0.5, 1.5, 0.0}});
  return Problem("falling box", scene);
}

// Two bodies, one on the other, on the ground: a contact between bodies has two sides with opposite signs.
Problem stack_of_two() {
  RigidScene scene;
  RigidBody lower;
  lower.mass = 1.0;
  lower.position = {0.0, 0.0, 1.0};
  lower.linear_velocity = {0.0, 0.0, -1.0};
  RigidBody upper = lower;
  upper.mass = 3.0;
  upper.position = {0.0, 0.0, 3.0};
  upper.linear_velocity = {0.0, 0.0, -2.0};
  scene.bodies = {lower, upper};
  scene.contacts.push_back({.body_a = 0, .point = {0.0, 0.0, 0.0}});
  scene.contacts.push_back({.body_a = 1, .body_b = 0, .point = {0.0, 0.0, 2.0}});
  return Problem("stack of two", scene);
}

// Direct methods end at a vertex: a few roundings. Ipopt stops at its tol of 1e-10 on quantities of size one.
constexpr double kDirect = 1e-13;
constexpr double kInteriorPoint = 1e-7;

// Iterations end where the next changes little: their tolerances are below this on quantities of size one.
constexpr double kIterative = 1e-6;

TEST(AdapterConventionsTest, SymmetricProblemsComeBackUnpermuted) {
  const Vector z{{1.0, 0.0, 2.0}};
  expect_solution("dart_dantzig", as_contacts(symmetric_problem()), z, kDirect);
  expect_solution("dart_lemke", symmetric_problem(), z, kDirect);
  expect_solution("dart_pgs{max_iterations=200,relative_tolerance=0}", as_contacts(symmetric_problem()), z, kDirect);
  expect_solution("bullet_pgs{iterations=200}", symmetric_problem(), z, kDirect);
  expect_solution("siconos_lemke", symmetric_problem(), z, kDirect);
  expect_solution("simbody_pgs{tolerance=1e-12}", symmetric_problem(), z, kIterative);
  expect_solution("siconos_newton_fb", symmetric_problem(), z, kIterative);
  expect_solution("siconos_pgs{tolerance=1e-10}", symmetric_problem(), z, kIterative);
  expect_solution("bullet_dantzig", symmetric_problem(), z, kDirect);
  expect_solution("bullet_lemke", symmetric_problem(), z, kDirect);
  expect_solution("ipopt_qp", symmetric_problem(), z, kInteriorPoint);
  expect_solution("ipopt_mpcc", symmetric_problem(), z, kInteriorPoint);
}

// z_0 is between its bounds, z_1 at its upper one with w_1 = -3, and z_2 is free.
TEST(AdapterConventionsTest, BoundsReachTheBoxedSolvers) {
  const Vector z{{1.0, 2.0, 3.0}};
  Lcp lcp{symmetric_problem().lcp().M, Vector(), LcpBounds::nonnegative(3)};
  lcp.q = Vector{{0.0, -3.0, 0.0}} - lcp.M * z;
  lcp.bounds.lower.tail(2).setConstant(-std::numeric_limits<double>::infinity());
  lcp.bounds.upper = Vector{{4.0, 2.0, std::numeric_limits<double>::infinity()}};
  for (const char* solver : {"bullet_dantzig", "dart_dantzig", "bullet_pgs{iterations=200}",
                             "dart_pgs{max_iterations=200,relative_tolerance=0}", "siconos_lemke", "dart_lemke"}) {
    expect_solution(solver, Problem("boxed", lcp), z, kDirect);
  }
  lcp.bounds.upper(1) = -2;  // ODE's pivoting begins at zero: elsewhere DART would abort, and Bullet be wrong
  for (const char* solver : {"bullet_dantzig", "dart_dantzig"}) {
    if (missing(solver)) continue;
    EXPECT_EQ(run(solver, Problem("away from zero", lcp)).answer.claim, Claim::kUnsupported) << solver;
  }
}

// The friction of row 1 is at its lower limit, half of z_0.
TEST(AdapterConventionsTest, LimitsOfFrictionReachTheBoxedSolvers) {
  const Vector z{{2.0, -1.0, 3.0}};
  Lcp lcp{symmetric_problem().lcp().M, Vector(), LcpBounds::nonnegative(3)};
  lcp.q = Vector{{0.0, 4.0, 0.0}} - lcp.M * z;
  lcp.bounds.lower(1) = -std::numeric_limits<double>::infinity();
  lcp.bounds.friction_of[1] = 0;
  lcp.bounds.mu(1) = 0.5;
  for (const char* solver : {"bullet_pgs{iterations=200}", "dart_pgs{max_iterations=200,relative_tolerance=0}",
                             "siconos_lemke", "dart_lemke"}) {
    expect_solution(solver, Problem("friction", lcp), z, kDirect);
  }
}

TEST(AdapterConventionsTest, NonsymmetricMatricesAreNotTransposed) {
  const Vector z{{1.0, 0.0, 2.0}};
  expect_solution("dart_lemke", nonsymmetric_problem(), z, kDirect);
  expect_solution("siconos_lemke", nonsymmetric_problem(), z, kDirect);
  expect_solution("siconos_newton_fb", nonsymmetric_problem(), z, kIterative);
  expect_solution("bullet_lemke", nonsymmetric_problem(), z, kDirect);
  expect_solution("ipopt_mpcc", nonsymmetric_problem(), z, kInteriorPoint);
}

TEST(AdapterConventionsTest, SolversOfSymmetricProblemsRefuseOthers) {
  for (const char* solver : {"bullet_dantzig", "dart_dantzig", "dart_pgs", "bullet_pgs", "siconos_pgs", "simbody_pgs",
                             "simbody_plus", "ipopt_qp"}) {
    if (missing(solver)) continue;
    EXPECT_EQ(run(solver, nonsymmetric_problem()).answer.claim, Claim::kUnsupported) << solver;
  }
}

TEST(AdapterConventionsTest, LimitsOfIterationsReachTheLibrary) {
  for (const char* solver :
       {"siconos_pgs{max_iterations=1}", "siconos_newton_fb{max_iterations=1}", "siconos_lemke{max_iterations=1}"}) {
    if (missing(solver)) continue;
    EXPECT_NE(run(solver, symmetric_problem()).answer.claim, Claim::kSolved) << solver;
  }
}

// M = -1, q = -1: z = -(w + 1) has no solution.
TEST(AdapterConventionsTest, DartsLemkeSaysWhyItEnded) {
  if (missing("dart_lemke")) return;
  const Problem ray("ray", Lcp{Matrix{{-1.0}}, Vector{{-1.0}}});
  const Answer answer = run("dart_lemke", ray).answer;
  EXPECT_EQ(answer.claim, Claim::kUnsolvable);
  EXPECT_EQ(answer.detail, "Lemke returned 2: a ray");
  // Its own test compares w and z with 1e-4, whatever the units: an answer right to sixteen digits fails it.
  const Problem large("large", Lcp{Matrix{{49.0}}, Vector{{-1e15}}});
  EXPECT_EQ(run("dart_lemke", large).answer.claim, Claim::kNumericalFailure);
}

TEST(AdapterConventionsTest, SolversOfWorldsReturnTheStacksImpulses) {
  // Both bodies come to rest: the upper contact carries 3 * 2 = 6 N s, the ground 1 * 1 + 6 = 7 N s.
  expect_solution("ode_quickstep{iterations=2000}", stack_of_two(), Vector{{7.0, 6.0}}, 1e-12);
  expect_solution("bullet_si{iterations=2000}", stack_of_two(), Vector{{7.0, 6.0}}, 1e-12);
  expect_solution("bullet_nncg{iterations=2000}", stack_of_two(), Vector{{7.0, 6.0}}, 1e-11);
}

TEST(AdapterConventionsTest, QuickStepSolvesTheSameProblemAsTheMatrixSolvers) {
  const std::string quickstep = "ode_quickstep{iterations=5000}";
  if (missing(quickstep)) return;
  const Problem box = falling_box();
  Evaluator evaluator(box);
  const Answer from_ode = run(quickstep, box).answer;
  const Answer from_lemke = run("lemke", box).answer;
  EXPECT_LE(evaluator.errors(from_ode).velocity_residual_relative, 1e-10);
  EXPECT_LE(evaluator.errors(from_lemke).velocity_residual_relative, 1e-14);
  // Three contacts on one body: M is regular, z unique. The box has to press somewhere and not everywhere alike.
  EXPECT_GT(from_lemke.z.maxCoeff(), 0.1);
  EXPECT_LE((from_ode.z - from_lemke.z).lpNorm<Eigen::Infinity>(), 1e-9);
}

TEST(AdapterConventionsTest, OffsetsOfASceneReachTheLibraries) {
  RigidScene scene = *falling_box().scene();
  scene.contacts[0].b = 0.5;
  scene.contacts[1].b = -0.25;
  scene.contacts[2].b = 0.125;
  const Problem box("box with offsets", scene);
  if (missing("lemke")) return;
  const Vector z = run("lemke", box).answer.z;
  EXPECT_GT((z - run("lemke", falling_box()).answer.z).lpNorm<Eigen::Infinity>(), 0.1);
  EXPECT_TRUE(Evaluator(box).errors(run("lemke", box).answer).solved);
  expect_solution("ode_quickstep{iterations=5000}", box, z, 1e-9);
  expect_solution("ode_step", box, z, 1e-12);
  expect_solution("bullet_si{iterations=5000}", box, z, 1e-9);
  expect_solution("bullet_nncg{iterations=5000}", box, z, 1e-9);
  expect_solution("dart_lemke", box, z, 1e-12);
  expect_solution("velocity_ipm_cholmod", box, z, 1e-12);
  expect_solution("bullet_dantzig", box, z, kIterative);
}

TEST(AdapterConventionsTest, RepeatedSolvesStartFromTheSameState) {
  for (const char* engine : {"ode_quickstep{iterations=7}", "bullet_si{iterations=7}", "bullet_nncg{iterations=7}"}) {
    if (missing(engine)) continue;
    const auto solver = open_solver(parse_spec(engine));
    TimedAnswer once;
    TimedAnswer repeated;
    solver->run(falling_box(), {}, once);
    solver->run(falling_box(), {.repeat_until_s = 1e-3, .max_repeats = 10}, repeated);
    solver->run(falling_box(), {}, repeated);
    EXPECT_EQ(once.answer.z, repeated.answer.z) << engine;
  }
}

TEST(AdapterConventionsTest, EmptyProblemsAreFine) {
  const Problem empty("empty", Lcp{Matrix(0, 0), Vector(0)});
  for (const char* solver :
       {"bullet_dantzig", "bullet_lemke", "bullet_pgs", "dart_lemke", "siconos_lemke", "siconos_newton_fb",
        "siconos_pgs", "simbody_pgs", "simbody_plus", "ipopt_qp", "ipopt_mpcc"}) {
    if (missing(solver)) continue;
    EXPECT_EQ(run(solver, empty).answer.claim, Claim::kSolved) << solver;
  }
  for (const char* solver : {"dart_dantzig", "dart_pgs", "siconos_fc3d"}) {
    if (missing(solver)) continue;
    EXPECT_EQ(run(solver, as_contacts(empty)).answer.claim, Claim::kSolved) << solver;
  }
}

}  // namespace
}  // namespace lcpbench::adapter_conventions_test
