#define LCPBENCH_LEVEL ordered_lu_test

#include "native/lemke/ordered_lu.h"

#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/types.h"
#include "native/lemke/least_squares.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench {
namespace {

using Lu = lemke::ordered_lu_test::OrderedLu;

/// B x = b as LAPACK's DGETF2 and DGETRS solve it: rows are exchanged, the rest is updated at each pivot.
Vector solve_as_lapack(Matrix B, Vector b) {
  const Index n = B.rows();
  for (Index k = 0; k < n; ++k) {
    Index pivot = k;
    for (Index i = k + 1; i < n; ++i) {
      if (std::abs(B(i, k)) > std::abs(B(pivot, k))) pivot = i;
    }
    for (Index j = 0; j < n; ++j) std::swap(B(k, j), B(pivot, j));
    std::swap(b(k), b(pivot));
    const double reciprocal = 1 / B(k, k);
    for (Index i = k + 1; i < n; ++i) B(i, k) *= reciprocal;
    for (Index j = k + 1; j < n; ++j) {
      for (Index i = k + 1; i < n; ++i) B(i, j) -= B(i, k) * B(k, j);
    }
  }
  for (Index k = 0; k < n; ++k) {
    for (Index i = k + 1; i < n; ++i) b(i) -= b(k) * B(i, k);
  }
  for (Index k = n - 1; k >= 0; --k) {
    b(k) /= B(k, k);
    for (Index i = 0; i < k; ++i) b(i) -= b(k) * B(i, k);
  }
  return b;
}

/// A basis with unit columns and with columns whose entries tie for the pivot.
Vector column_of(testing::Uniform& uniform, Index n) {
  const double kind = uniform.vector(1)(0);
  if (kind < 0) return Vector::Unit(n, static_cast<Index>(-kind * static_cast<double>(n)) % n);
  Vector column = uniform.vector(n);
  if (kind > 0.5) column = (4 * column).array().round();
  return column;
}

/// Eliminates all columns from the first changed one on; false when one has no pivot.
bool eliminate(Lu& lu, const Matrix& B) {
  for (Index j = lu.done(); j < B.cols(); ++j) {
    const Vector column = B.col(j);
    Index row = -1;
    const bool unit = column.cwiseAbs().sum() == 1 && column.maxCoeff(&row) == 1;
    if (unit && lu.add_unit(row)) continue;
    std::vector<double> padded(static_cast<std::size_t>(B.rows()) + 16, 0.0);
    std::copy(column.begin(), column.end(), padded.begin());
    if (!lu.add(padded.data())) return false;
  }
  return true;
}

Vector solve(Lu& lu, const Vector& side) {
  std::vector<double> padded(static_cast<std::size_t>(side.size()) + 16, 0.0);
  std::copy(side.begin(), side.end(), padded.begin());
  lu.solve(padded.data());
  return Eigen::Map<const Vector>(padded.data(), side.size());
}

TEST(OrderedLuTest, HasTheBitsOfLapacksElimination) {
  testing::Uniform uniform(5);
  int regular = 0, singular = 0;
  for (const Index n : {1, 2, 3, 8, 17, 40}) {
    Lu lu;
    lu.load(n);
    Matrix B(n, n);
    for (Index j = 0; j < n; ++j) B.col(j) = uniform.vector(n);
    for (int change = 0; change < 200; ++change) {
      const Index place = static_cast<Index>((uniform.vector(1)(0) + 1) / 2 * static_cast<double>(n)) % n;
      B.col(place) = column_of(uniform, n);
      if (place < lu.done()) lu.forget(place);
      if (!eliminate(lu, B)) {
        ++singular;
        EXPECT_LT(lu.done(), n);
        continue;
      }
      ++regular;
      const Vector side = column_of(uniform, n);
      const Vector expected = solve_as_lapack(B, side);
      EXPECT_TRUE(solve(lu, side) == expected) << n << ", change " << change;
    }
  }
  EXPECT_GT(regular, 200);
  EXPECT_GT(singular, 50);
}

TEST(OrderedLuTest, PivotsWithoutAReciprocalAreDivisors) {
  Lu lu;
  lu.load(2);
  const Matrix B = testing::matrix_of(2, {0x1p-1040, 0, 0x1p-1041, 1});
  ASSERT_TRUE(eliminate(lu, B));
  EXPECT_EQ(solve(lu, testing::vector_of({0x1p-1040, 0.75})), testing::vector_of({1, 0.75 - 0x1p-1041}));
}

/// The shortest least-squares solution of bases with unit columns, against that of the whole matrix.
TEST(LeastSquaresTest, IsThatOfTheWholeBasis) {
  testing::Uniform uniform(7);
  for (const Index n : {2, 5, 12, 30}) {
    for (const Index rank : {Index{0}, n / 3, n / 2}) {
      // Unit columns at the even places, in rows from the last one up; `rank` other columns, and sums of them.
      Matrix B(n, n);
      const auto unit_row = [n](std::ptrdiff_t c) { return c % 2 == 0 ? n - 1 - c / 2 : -1; };
      const Matrix factors = uniform.matrix(n, rank);
      for (Index c = 0; c < n; ++c) {
        B.col(c) = unit_row(c) >= 0 ? Vector(Vector::Unit(n, unit_row(c))) : Vector(factors * uniform.vector(rank));
      }
      const Vector side = uniform.vector(n);
      Vector x(n);
      ASSERT_TRUE(lemke::ordered_lu_test::LeastSquares::solve(
          n, unit_row, [&](std::ptrdiff_t r, std::ptrdiff_t c) { return B(r, c); },
          [&](std::ptrdiff_t r) { return side(r); }, x.data()));
      const Vector expected = B.completeOrthogonalDecomposition().solve(side);
      EXPECT_LE((x - expected).norm(), 1e-11 * (1 + expected.norm())) << n << ", rank " << rank;
    }
  }
}

TEST(LeastSquaresTest, RefusesWhatIsNotFinite) {
  Vector x(1);
  const auto none = [](std::ptrdiff_t) { return std::ptrdiff_t{-1}; };
  EXPECT_FALSE(lemke::ordered_lu_test::LeastSquares::solve(
      1, none, [](std::ptrdiff_t, std::ptrdiff_t) { return std::nan(""); }, [](std::ptrdiff_t) { return 1.0; },
      x.data()));
}

}  // namespace
}  // namespace lcpbench
