#include "core/contact_problem.h"

#include <limits>

#include <gtest/gtest.h>

#include "core/problem.h"
#include "core/scene.h"

namespace lcpbench::contact_problem_test {
namespace {

// A particle of mass 4 (its square root is exact, so all of M is) on two contacts: the first with friction along +-x,
// the second without.
ContactProblem two_contacts() {
  ContactProblem problem;
  problem.v = Vector{{3.0, -4.0}};
  problem.N = Matrix{{0.0, 1.0}, {1.0, 0.0}};
  problem.D = Matrix{{1.0, -1.0}, {0.0, 0.0}};
  problem.edges = {2, 0};
  problem.mu = Vector{{0.5, 0.0}};
  problem.inertia = DenseInertia{Matrix{{4.0, 0.0}, {0.0, 4.0}}};
  return problem;
}

TEST(ContactProblemTest, LcpHasTheAnitescuPotraBlocks) {
  const Lcp lcp = form_lcp(two_contacts());
  const Matrix expected{{0.25, 0.0, 0.0, 0.0, 0.0},
                        {0.0, 0.25, 0.25, -0.25, 0.0},
                        {0.0, 0.25, 0.25, -0.25, 1.0},
                        {0.0, -0.25, -0.25, 0.25, 1.0},
                        {0.5, 0.0, -1.0, -1.0, 0.0}};
  EXPECT_EQ(lcp.M, expected);
  EXPECT_EQ(lcp.q, (Vector{{-4.0, 3.0, 3.0, -3.0, 0.0}}));
}

TEST(ContactProblemTest, LayoutGivesAFrictionlessContactNeitherColumnsNorLambda) {
  const ContactLayout layout = contact_layout(two_contacts());
  EXPECT_EQ(layout.size(), 5);
  EXPECT_EQ(layout.friction_offset(), 2);
  EXPECT_EQ(layout.lambda_offset(), 4);
  EXPECT_EQ(layout.lambda, (std::vector<Index>{0, -1}));
  EXPECT_EQ(layout.friction_begin, (std::vector<Index>{0, 2, 2}));
  EXPECT_EQ(lcp_size(two_contacts()), 5);
}

TEST(ContactProblemTest, PostImpactVelocityAddsTheImpulses) {
  const Vector z{{8.0, 1.0, 0.0, 4.0, 0.0}};
  EXPECT_EQ(post_impact_velocity(two_contacts(), z), (Vector{{2.25, -2.0}}));
}

// The least double times 3/4 is no double, but a body of 2^-26 kg shows it: beside an impulse of ordinary size, too.
TEST(ContactProblemTest, PostImpactVelocityLosesNothingToUnderflow) {
  ContactProblem problem;
  problem.v = Vector{{0.0, 1.0}};
  problem.N = Matrix{{0.75, 0.0}, {0.0, 1.0}};
  problem.D = Matrix(2, 0);
  problem.edges = {0, 0};
  problem.mu = Vector::Zero(2);
  problem.inertia = DenseInertia{Matrix{{0x1p-26, 0.0}, {0.0, 1.0}}};
  EXPECT_EQ(post_impact_velocity(problem, Vector{{0x1p-1074, 2.0}}), (Vector{{0x3p-1050, 3.0}}));
}

TEST(ContactProblemTest, EveryFormOfInertiaGivesTheSameInverse) {
  const Matrix G{{2.0, 0.0, 0.0}, {0.0, 4.0, 2.0}, {0.0, 2.0, 2.0}};
  const Matrix inverse{{0.5, 0.0, 0.0}, {0.0, 0.5, -0.5}, {0.0, -0.5, 1.0}};
  const Matrix X{{1.0, 0.0, 0.0}, {0.0, 1.0, 1.0}, {0.0, 0.0, 1.0}};
  const double tolerance = 1e-15;  // a few roundings of numbers of size one
  EXPECT_TRUE(inverse_inertia(DenseInertia{G}).isApprox(inverse, tolerance));
  EXPECT_TRUE(
      inverse_inertia(BlockInertia{{G.topLeftCorner(1, 1), G.bottomRightCorner(2, 2)}}).isApprox(inverse, tolerance));
  EXPECT_TRUE(inverse_inertia(FactoredInertia{X, Vector{{2.0, 2.0, 2.0}}}).isApprox(inverse, tolerance));
  EXPECT_TRUE(inverse_inertia(InverseInertia{inverse}).isApprox(inverse, tolerance));
}

TEST(ContactProblemTest, ReducedRankInertiaGetsItsPseudoInverse) {
  const Matrix X{{1.0}, {2.0}, {2.0}};
  const Matrix expected = X * X.transpose() / (4.0 * 81.0);  // (4 x x')* = x x' / (4 |x|^4)
  EXPECT_TRUE(inverse_inertia(FactoredInertia{X, Vector{{4.0}}}).isApprox(expected, 1e-14));
}

TEST(JacobianTest, NumbersOfAnUncompressedMatrixAreAllLookedAt) {
  SparseMatrix sparse(3, 2);
  sparse.reserve(Eigen::VectorXi::Constant(2, 3));  // room between the columns, which holds no entries
  sparse.insert(0, 0) = 1.0;
  sparse.insert(2, 1) = 2.0;
  ASSERT_FALSE(sparse.isCompressed());
  EXPECT_TRUE(all_finite(Jacobian(sparse)));
  sparse.coeffRef(2, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(all_finite(Jacobian(sparse)));
  EXPECT_FALSE(all_finite(Jacobian(Matrix(sparse))));
}

TEST(SceneTest, ContactRowsAreWrenchesOnBothBodies) {
  RigidScene scene;
  scene.bodies.resize(2);
  scene.bodies[0].mass = 4.0;
  scene.bodies[0].position = {0, 0, 1};
  scene.bodies[0].linear_velocity = {0, 0, -1};
  scene.bodies[1].position = {0, 0, 3};
  scene.contacts.push_back({.body_a = 0, .point = {1, 0, 0}, .normal = {0, 0, 1}, .mu = 0.5, .edges = 4});
  scene.contacts.push_back({.body_a = 1, .body_b = 0, .point = {0, 1, 2}, .normal = {0, 0, 1}});
  const ContactProblem problem = contact_problem(scene);
  ASSERT_EQ(problem.ngc(), 12);
  const Matrix N = to_dense(problem.N);
  EXPECT_EQ(Vector(N.col(0)), (Vector{{0, 0, 1, 0, -1, 0, 0, 0, 0, 0, 0, 0}}));
  EXPECT_EQ(Vector(N.col(1)), (Vector{{0, 0, -1, -1, 0, 0, 0, 0, 1, 1, 0, 0}}));
  const Matrix D = to_dense(problem.D);
  ASSERT_EQ(D.cols(), 4);
  EXPECT_EQ(Vector(D.col(0).head(6)), (Vector{{1, 0, 0, 0, -1, 0}}));
  EXPECT_EQ(Vector(D.col(1).head(6)), (Vector{{0, 1, 0, 1, 0, 1}}));
  EXPECT_EQ(Vector(D.col(2)), Vector(-D.col(0)));
  EXPECT_EQ(Vector(D.col(3)), Vector(-D.col(1)));
  EXPECT_EQ(inverse_inertia(problem.inertia).diagonal(), (Vector{{.25, .25, .25, 1, 1, 1, 1, 1, 1, 1, 1, 1}}));
}

}  // namespace
}  // namespace lcpbench::contact_problem_test
