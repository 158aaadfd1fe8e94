#include "study/evaluation/fastest_contact.h"

#include <gtest/gtest.h>

namespace lcpbench::fastest_contact_test {
namespace {

/// A particle that falls on a floor at 1 m/s, with a pyramid of four edges.
ContactProblem falling_particle() {
  ContactProblem problem;
  problem.v = Vector{{0.0, 0.0, -1.0}};
  problem.N = Matrix{{0}, {0}, {1}};
  problem.D = Matrix{{1, 0, -1, 0}, {0, 1, 0, -1}, {0, 0, 0, 0}};
  problem.edges = {4};
  problem.mu = Vector::Constant(1, 0.5);
  problem.inertia = DenseInertia{Matrix::Identity(3, 3)};
  return problem;
}

TEST(FastestContactTest, SpeedCountsAlongNormalAndTangents) {
  const ContactProblem problem = falling_particle();
  EXPECT_EQ(fastest_contact(problem, problem.v).m_per_s, 1);
  EXPECT_EQ(fastest_contact(problem, Vector{{2.0, -3.0, -1.0}}).m_per_s, 3);
  EXPECT_EQ(fastest_contact(problem, Vector{{2.0, -3.0, -1.0}}).contact, 0);
  EXPECT_EQ(fastest_contact(problem, Vector::Zero(3)).contact, -1);
}

/// The verdict lets a residual grow with every offset, so the difference that counts must, too.
TEST(FastestContactTest, LeastDifferenceGrowsWithEachKindOfOffset) {
  ContactProblem problem = falling_particle();
  EXPECT_DOUBLE_EQ(least_difference(problem), 1e-3);
  problem.b = Vector::Constant(1, -2.0);
  EXPECT_DOUBLE_EQ(least_difference(problem), 2e-3);
  problem.offset_t = Vector{{0.0, -5.0}};  // the floor is a belt
  EXPECT_DOUBLE_EQ(least_difference(problem), 5e-3);
}

}  // namespace
}  // namespace lcpbench::fastest_contact_test
