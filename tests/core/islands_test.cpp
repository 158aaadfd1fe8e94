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

// Of the first block only all columns together join the rows, of the last one no columns do.
TEST(IslandNumbersTest, BlocksAreJoinedByAllTheirColumns) {
  Matrix chain = 4 * Matrix::Identity(4, 4);
  chain.diagonal(1).setOnes();
  chain.diagonal(-1).setOnes();
  Matrix crossed = Matrix::Identity(3, 3);
  crossed(0, 2) = crossed(2, 0) = 0.5;
  ContactProblem problem;
  problem.v = Vector::Zero(12);
  problem.N = Matrix::Zero(12, 5);
  for (const Index c : {0, 1, 2, 3})
    std::get<Matrix>(problem.N)(Labels{3, 5, 4, 9}[static_cast<std::size_t>(c)], c) = 1;
  problem.D = Matrix(12, 0);
  problem.edges.assign(5, 0);
  problem.mu = Vector::Zero(5);
  problem.inertia = BlockInertia{{chain, crossed, Matrix::Ones(3, 3), Matrix::Identity(2, 2)}};
  IslandNumbers numbers;
  numbers.find(problem);
  EXPECT_EQ(numbers.count, 4);
  EXPECT_EQ(numbers.of_contact, (Labels{0, 1, 2, 3, -1}));
  EXPECT_EQ(numbers.of_coordinate, (Labels{0, 0, 0, 0, 2, 1, 2, 3, 3, 3, -1, -1}));
  std::get<Matrix>(problem.N)(6, 4) = std::get<Matrix>(problem.N)(7, 4) = 1;  // a contact between bodies joins more
  numbers.find(problem);
  EXPECT_EQ(numbers.of_contact, (Labels{0, 1, 2, 2, 2}));
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
