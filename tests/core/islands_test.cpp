#include "core/islands.h"

#include <gtest/gtest.h>

namespace lcpbench {
namespace {

using Labels = std::vector<Index>;

/// Two separate point masses of two coordinates; the contacts push along single coordinates.
ContactProblem two_points() {
  ContactProblem problem;
  problem.v = Vector::Zero(4);
  problem.N = (Matrix(4, 3) << 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0).finished();  // the last contact moves nothing
  problem.D = (Matrix(4, 4) << 0, 0, 0, 0, 1, -1, 0, 0, 0, 0, 0, 0, 0, 0, 1, -1).finished();
  problem.edges = {2, 2, 0};
  problem.mu = Vector::Constant(3, 0.5);
  problem.inertia = BlockInertia{{Matrix::Identity(2, 2), Matrix::Identity(2, 2)}};
  return problem;
}

TEST(RowIslandsTest, ContactsShareAnIslandWithTheirFrictionAndCone) {
  const RowIslands islands = row_islands(two_points());
  EXPECT_EQ(islands.count, 3);
  EXPECT_EQ(islands.of_row, (Labels{0, 1, 2, 0, 0, 1, 1, 0, 1}));
}

TEST(RowIslandsTest, InertiaCouplesContacts) {
  ContactProblem problem = two_points();
  Matrix G = Matrix::Identity(4, 4);
  G(0, 3) = G(3, 0) = 0.25;
  problem.inertia = DenseInertia{G};
  const RowIslands islands = row_islands(problem);
  EXPECT_EQ(islands.count, 2);
  EXPECT_EQ(islands.of_row, (Labels{0, 0, 1, 0, 0, 0, 0, 0, 0}));
}

TEST(RowIslandsTest, BlocksOfAMatrixAreFoundInAnyOrderOfRows) {
  Matrix M = Matrix::Identity(5, 5);
  M(4, 0) = 1;  // one triangle suffices
  M(1, 3) = -1;
  EXPECT_EQ(row_islands(M).of_row, (Labels{0, 1, 2, 1, 0}));
  EXPECT_EQ(row_islands(M).count, 3);
}

TEST(RowIslandsTest, AFullRowOrColumnCouplesAll) {
  Matrix M = Matrix::Zero(3, 3);
  M.row(0).setOnes();
  EXPECT_EQ(row_islands(M).count, 1);
  EXPECT_EQ(row_islands(Matrix(M.transpose())).of_row, (Labels{0, 0, 0}));
}

TEST(RowIslandsTest, NoRowsAreNoIslands) { EXPECT_EQ(row_islands(Matrix(0, 0)).count, 0); }

}  // namespace
}  // namespace lcpbench
