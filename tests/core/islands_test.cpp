#include "core/islands.h"

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

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

// The load of rows 0 and 2 moves nothing itself; row 3 moves nothing, and nothing depends on it.
TEST(RowIslandsTest, RowsOfFrictionShareTheIslandOfTheirLoad) {
  ContactProblem problem = two_points();
  problem.rows.R = (Matrix(4, 4) << 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0).finished();
  problem.rows.bounds = LcpBounds::nonnegative(4);
  problem.rows.bounds.friction_of = {1, -1, 1, -1};
  const RowIslands islands = row_islands(problem);
  EXPECT_EQ(islands.count, 3);
  EXPECT_EQ(islands.of_row, (Labels{0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2}));
  const std::vector<Island> list = find_islands(problem);
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list.front().rows, (Labels{0, 1, 2}));
  problem.rows.R = Matrix::Zero(4, 4);
  EXPECT_EQ(row_islands(problem).of_row, (Labels{0, 1, 2, 0, 0, 1, 1, 0, 1, 3, 3, 3, 4}));
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

/// The least member of what the columns' nonzero rows join, of each row of A and then of each column.
Labels joined(const Matrix& A) {
  Labels of(static_cast<std::size_t>(A.rows() + A.cols()));
  std::iota(of.begin(), of.end(), Index{0});
  for (Index j = 0; j < A.cols(); ++j) {
    for (Index i = 0; i < A.rows(); ++i) {
      if (A(i, j) == 0) continue;
      const Index a = of[static_cast<std::size_t>(i)], b = of[static_cast<std::size_t>(A.rows() + j)];
      std::replace(of.begin(), of.end(), std::max(a, b), std::min(a, b));
    }
  }
  return of;
}

/// That two labellings put the same pairs together. -1: alone.
bool are_the_same(const Labels& found, const Labels& expected) {
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const bool together = found[i] >= 0 && found[i] == found[j];
      if (found[i] >= 0 && found[j] >= 0 && together != (expected[i] == expected[j])) return false;
    }
  }
  return true;
}

// Against a search on the dense matrices. How J is stored does not count, nor do stored zeros.
TEST(IslandNumbersTest, AreWhatNothingCouples) {
  std::mt19937 random(1);
  IslandNumbers numbers;
  Index most = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    ContactProblem problem = random_bodies(random);
    const Index nc = problem.nc();
    Matrix pushes(problem.ngc(), nc);  // what each contact can push, beside what the inertia couples
    for (Index c = 0; c < nc; ++c) {
      pushes.col(c) = std::get<Matrix>(problem.N).col(c).cwiseAbs() +
                      std::get<Matrix>(problem.D).middleCols(4 * c, 4).cwiseAbs().rowwise().sum();
    }
    Matrix all(problem.ngc(), nc + problem.ngc());
    all << pushes, dense_inertia(problem.inertia);
    const Labels expected = joined(all);
    const auto begin = expected.begin();
    const Labels of_coordinate(begin, begin + problem.ngc());
    const Labels of_contact(begin + problem.ngc(), begin + problem.ngc() + nc);
    SparseMatrix N = with_stored_zeros(std::get<Matrix>(problem.N), random);
    SparseMatrix D = with_stored_zeros(std::get<Matrix>(problem.D), random);
    for (const char* storage : {"dense", "sparse", "compressed"}) {
      if (storage[0] == 'c') N.makeCompressed();
      if (storage[0] == 'c') D.makeCompressed();
      if (storage[0] != 'd') problem.N = N;
      if (storage[0] != 'd') problem.D = D;
      numbers.find(problem);
      ASSERT_TRUE(are_the_same(numbers.of_contact, of_contact)) << trial << " " << storage;
      ASSERT_TRUE(are_the_same(numbers.of_coordinate, of_coordinate)) << trial << " " << storage;
      Index islands = 0;
      for (Index c = 0; c < nc; ++c) {
        const auto k = static_cast<std::size_t>(c);
        ASSERT_EQ(numbers.of_contact[k] >= 0, !pushes.col(c).isZero(0)) << trial << " " << storage;
        islands = std::max(islands, numbers.of_contact[k] + 1);
        for (Index i = 0; i < problem.ngc(); ++i) {
          if (pushes(i, c) == 0) continue;
          ASSERT_EQ(numbers.of_coordinate[static_cast<std::size_t>(i)], numbers.of_contact[k]) << trial << " " << storage;
        }
      }
      ASSERT_EQ(numbers.count, islands) << trial << " " << storage;
    }
    most = std::max(most, numbers.count);
  }
  EXPECT_GE(most, 4);
}

TEST(RowIslandsTest, BlocksOfAMatrixAreFoundInAnyOrderOfRows) {
  Matrix M = Matrix::Identity(5, 5);
  M(4, 0) = 1;  // one triangle suffices
  M(1, 3) = -1;
  EXPECT_EQ(row_islands(M).of_row, (Labels{0, 1, 2, 1, 0}));
  EXPECT_EQ(row_islands(M).count, 3);
  M.row(0).setOnes();
  EXPECT_EQ(row_islands(Matrix(M.transpose())).count, 1);
  EXPECT_EQ(row_islands(Matrix(0, 0)).count, 0);
}

}  // namespace
}  // namespace lcpbench::islands_test
