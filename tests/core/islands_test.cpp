#include "core/islands.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace lcpbench::islands_test {
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

/// Bodies of 3 and 3 coordinates with inertia of three kinds; contacts of one body or two with many zeros.
ContactProblem random_bodies(std::mt19937& random) {
  const auto below = [&](int count) { return static_cast<Index>(random() % static_cast<unsigned>(count)); };
  const Index bodies = 1 + below(5);
  const Index nc = 1 + below(6);
  ContactProblem problem;
  problem.v = Vector::Zero(6 * bodies);
  BlockInertia inertia;
  for (Index b = 0; b < 2 * bodies; ++b) {
    Matrix block = 4 * Matrix::Identity(3, 3);
    const Index kind = below(3);
    if (kind == 1) block.array() += 1;
    if (kind == 2) block(0, 2) = block(2, 0) = 1;
    inertia.blocks.push_back(block);
  }
  problem.inertia = inertia;
  problem.edges.assign(static_cast<std::size_t>(nc), 4);
  problem.mu = Vector::Ones(nc);
  Matrix N = Matrix::Zero(6 * bodies, nc);
  Matrix D = Matrix::Zero(6 * bodies, 4 * nc);
  for (Index c = 0; c < nc; ++c) {
    for (const Index body : {below(static_cast<int>(bodies)), below(static_cast<int>(bodies))}) {
      for (Index i = 6 * body; i < 6 * body + 6; ++i) {
        N(i, c) = below(4) == 0 ? 1 : 0;
        for (Index t = 0; t < 2; ++t) {
          D(i, 4 * c + t) = below(12) == 0 ? 1 : 0;
          D(i, 4 * c + 2 + t) = -D(i, 4 * c + t);
        }
      }
    }
  }
  problem.N = N;
  problem.D = D;
  return problem;
}

/// The matrix with its nonzero entries and some of its zeros.
SparseMatrix with_stored_zeros(const Matrix& matrix, std::mt19937& random) {
  SparseMatrix sparse(matrix.rows(), matrix.cols());
  for (Index j = 0; j < matrix.cols(); ++j) {
    for (Index i = 0; i < matrix.rows(); ++i) {
      if (matrix(i, j) != 0 || random() % 2 == 0) sparse.insert(i, j) = matrix(i, j);
    }
  }
  return sparse;
}

TEST(IslandNumbersTest, StorageAndStoredZerosDoNotCount) {
  std::mt19937 random(1);
  IslandNumbers expected, numbers;
  Index most = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    ContactProblem problem = random_bodies(random);
    expected.find(problem);
    most = std::max(most, expected.count);
    SparseMatrix N = with_stored_zeros(std::get<Matrix>(problem.N), random);
    SparseMatrix D = with_stored_zeros(std::get<Matrix>(problem.D), random);
    for (const bool compressed : {false, true}) {
      if (compressed) N.makeCompressed();
      if (compressed) D.makeCompressed();
      ASSERT_EQ(N.isCompressed(), compressed);
      problem.N = N;
      problem.D = D;
      numbers.find(problem);
      ASSERT_EQ(numbers.count, expected.count) << trial;
      ASSERT_EQ(numbers.of_contact, expected.of_contact) << trial;
      ASSERT_EQ(numbers.of_coordinate, expected.of_coordinate) << trial;
    }
  }
  EXPECT_GE(most, 4);
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
}  // namespace lcpbench::islands_test
