#include "native/friction_ipm/friction_ipm.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "generators/sets.h"
#include "tests/support/brick_wall.h"
#include "tests/support/solving.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench::friction_ipm_test {
namespace {

Answer solve(const Problem& problem, const Options& options = {}, const SolveRequest& request = {}) {
  return testing::solve(Spec{"friction_ipm", options}, problem, request);
}

/// A particle of unit mass that meets the ground at 1 m/s downwards and slides at `speed` along x; four edges along the
/// axes.
ContactProblem sliding_particle(double speed, double mu) {
  ContactProblem contact;
  contact.v = testing::vector_of({speed, 0, -1});
  contact.N = Matrix(Vector::Unit(3, 2));
  Matrix D(3, 4);
  D << 1, 0, -1, 0,  //
      0, 1, 0, -1,   //
      0, 0, 0, 0;
  contact.D = D;
  contact.edges = {4};
  contact.mu = testing::vector_of({mu});
  contact.inertia = DenseInertia{Matrix::Identity(3, 3)};
  return contact;
}

// f_N = 1 stops the fall; friction takes mu of the speed, and no more than all of it.
TEST(FrictionIpmTest, SlidesSticksAndSlipsWithoutFriction) {
  for (const double mu : {0.0, 0.25, 0.75}) {
    for (const double speed : {0.5, -0.5, 0.0}) {
      const Problem problem("particle", sliding_particle(speed, mu));
      const Answer answer = solve(problem);
      ASSERT_EQ(answer.claim, Claim::kSolved) << "mu " << mu << ", speed " << speed << ": " << answer.detail;
      const double left = std::copysign(std::max(std::abs(speed) - mu, 0.0), speed);
      EXPECT_NEAR(answer.z(0), 1, 1e-8) << "mu " << mu << ", speed " << speed;
      const Vector u = post_impact_velocity(*problem.contact(), answer.z);
      EXPECT_NEAR(u(0), left, 1e-8) << "mu " << mu << ", speed " << speed;
      EXPECT_NEAR(u(2), 0, 1e-8) << "mu " << mu << ", speed " << speed;
      EXPECT_LE(Evaluator(problem).errors(answer).velocity_residual_relative, 1e-8);
    }
  }
}

// The convex relaxation lifts what slides: without the slip bounds the particle would leave the ground at mu |slip|.
TEST(FrictionIpmTest, DoesNotStopAtTheConvexRelaxation) {
  const Problem problem("particle", sliding_particle(4, 0.5));
  const Answer answer = solve(problem);
  ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_NE(answer.detail, "1 convex problem");
  const Vector u = post_impact_velocity(*problem.contact(), answer.z);
  EXPECT_NEAR(u(0), 3.5, 1e-8);
  EXPECT_NEAR(u(2), 0, 1e-8);
}

TEST(FrictionIpmTest, IsVelocityIpmWithoutFriction) {
  const Problem wall("wall", testing::brick_wall(6, 8));
  const Answer answer = solve(wall);
  ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_EQ(answer.detail, "1 convex problem");
  const Answer reference = testing::solve("velocity_ipm", wall);
  const ContactProblem& contact = *wall.contact();
  const Vector difference = post_impact_velocity(contact, answer.z) - post_impact_velocity(contact, reference.z);
  EXPECT_LE(difference.lpNorm<Eigen::Infinity>(), 1e-12 * contact.v.lpNorm<Eigen::Infinity>());
}

TEST(FrictionIpmTest, SparseAndDenseAlgebraMeetOnAWall) {
  const ContactProblem wall = contact_problem(testing::frictional_brick_wall(3, 4, 0.5));
  ContactProblem given_densely = wall;
  given_densely.N = to_dense(wall.N);
  given_densely.D = to_dense(wall.D);
  const Answer sparse = solve(Problem("wall", wall));
  const Answer dense = solve(Problem("wall", given_densely));
  ASSERT_EQ(sparse.claim, Claim::kSolved) << sparse.detail;
  ASSERT_EQ(dense.claim, Claim::kSolved) << dense.detail;
  const Vector difference = post_impact_velocity(wall, sparse.z) - post_impact_velocity(wall, dense.z);
  EXPECT_LE(difference.lpNorm<Eigen::Infinity>(), 1e-7 * wall.v.lpNorm<Eigen::Infinity>());
}

// More than a thousand contacts with friction that stick, slide and open: 6,000 rows of M, of which none is formed.
TEST(FrictionIpmTest, SolvesAThousandFrictionalContacts) {
  const Problem wall("wall", testing::frictional_brick_wall(12, 13, 0.5));
  ASSERT_GE(wall.contact()->nc(), 1000);
  const Answer answer = solve(wall);
  ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  const Errors errors = Evaluator(wall).errors(answer);
  EXPECT_TRUE(errors.solved);
  EXPECT_LE(errors.velocity_residual_relative, 1e-8);
  EXPECT_GE(errors.min_z, 0);
  const ContactLayout layout = contact_layout(*wall.contact());
  const auto f_N = answer.z.head(layout.nc);
  const auto lambda = answer.z.tail(layout.cones);
  const double pressed = 1e-6 * f_N.maxCoeff();
  const double sliding = 1e-6 * wall.contact()->v.lpNorm<Eigen::Infinity>();
  EXPECT_GE((f_N.array() < pressed).count(), 10) << "nothing opens";
  EXPECT_GE((f_N.array() > pressed && lambda.array() > sliding).count(), 10) << "nothing slides";
  EXPECT_GE((f_N.array() > pressed && lambda.array() < sliding).count(), 10) << "nothing sticks";
}

// Where the convex problems are solved to the tolerance only, rounding decides which round passes: here 26 to 45 rounds
// of up to 1046 steps instead of 21 of 381.
TEST(FrictionIpmTest, EndsWhenTheFixedPointIsReached) {
  const Answer answer = solve(Problem("wall", testing::frictional_brick_wall(12, 14, 0.5)));
  ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_LE(answer.counters.iterations, 450);
}

// On a step of each, the rounds come no nearer than 3e-5 and 4e-5: within what the test of the answer proves.
TEST(FrictionIpmTest, ClaimsWhatItsTestProves) {
  for (const char* name : {"scene/card-house/bullet", "scene/wall/bullet"}) {
    const auto set = open_set(name);
    for (std::int64_t trial = 0; trial < *set->count(); ++trial) {
      const Problem problem = set->generate(1, trial);
      const Answer answer = solve(problem);
      EXPECT_EQ(answer.claim, Claim::kSolved) << name << ", trial " << trial << ": " << answer.detail;
      EXPECT_TRUE(Evaluator(problem).errors(answer).solved) << name << ", trial " << trial;
    }
  }
}

// The tolerance allows more than the test of an answer does.
TEST(FrictionIpmTest, GoesOnWhereItsAnswerFailsTheTest) {
  const Problem sticks = open_set("made/sticks{nc_max=1000}")->generate(20261305, 4);
  const Answer answer = solve(sticks, {{"tolerance", "1e-3"}});
  EXPECT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_LT(Evaluator(sticks).errors(answer).velocity_residual_relative, 1e-4);
}

// Thin bodies: a bound on M_jj by the single coordinates was fourteen times as large as M_jj, and the impulses that
// first come within the tolerance failed the test of the answer.
TEST(FrictionIpmTest, SmallImpulsesOnThinBodiesPassTheTest) {
  const Problem sticks = open_set("made/sticks{nc_max=1000}")->generate(20261408, 2);
  const Answer answer = solve(sticks, {{"tolerance", "1e-4"}});
  EXPECT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_GT(Evaluator(sticks).errors(answer).velocity_residual_relative, 4e-5);  // 5.5e-5: it did not go on
}

TEST(FrictionIpmTest, TheFirstConvexProblemIsSolvedAloneUnlessItIsRefuted) {
  const auto solver = make_friction_ipm();
  Answer answer;
  int asked = 0;
  const auto never = [&asked](const Vector&) { return ++asked < 0; };
  const Problem sticks("sticks", sliding_particle(0.1, 0.25)), slides("slides", sliding_particle(1, 0.25));
  solver->load(sticks);  // friction holds it: the convex problem is the whole
  EXPECT_TRUE(solver->solve_convex({}, never, answer));
  EXPECT_EQ(answer.claim, Claim::kSolved);
  solver->load(slides);  // the convex problem would let it part
  EXPECT_TRUE(solver->solve_convex({}, never, answer));
  EXPECT_EQ(answer.claim, Claim::kIterationLimit);
  EXPECT_EQ(asked, 2);
  EXPECT_FALSE(solver->solve_convex({}, [](const Vector&) { return true; }, answer));
}

}  // namespace
}  // namespace lcpbench::friction_ipm_test
