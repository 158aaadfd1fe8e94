#include "core/quad.h"

#include <cmath>
#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

#include "core/quad_inertia.h"
#include "core/quad_matrix.h"

namespace lcpbench::quad_test {
namespace {

// splitmix64, so that the tests draw the same numbers everywhere.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : state_(seed) {}
  double uniform() {
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t x = state_;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    x ^= x >> 31;
    return static_cast<double>(x >> 44) * 0x1p-19 - 1.0;  // multiples of 2^-19 in [-1, 1)
  }
  Matrix matrix(Index rows, Index cols) {
    Matrix A(rows, cols);
    for (Index j = 0; j < cols; ++j) {
      for (Index i = 0; i < rows; ++i) A(i, j) = uniform();
    }
    return A;
  }

 private:
  std::uint64_t state_;
};

double largest(const QuadVector& x) {
  double result = 0;
  for (const Quad value : x) result = std::max(result, std::abs(to_double(value)));
  return result;
}

QuadVector minus(QuadVector a, const QuadVector& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

TEST(QuadTest, HasAtLeast113SignificantBits) {
  const Quad next = Quad{1} + Quad{2 * kQuadUnitRoundoff};
  EXPECT_TRUE(next > 1);
  EXPECT_EQ(to_double((next - 1) * 0x1p112), 1.0);
}

TEST(QuadTest, SquareRootIsAccurateOverTheWholeRange) {
  for (const double exponent : {-1000.0, -300.0, -2.0, 0.0, 1.0, 300.0, 1000.0}) {
    const Quad x = Quad{3} * std::exp2(exponent);
    EXPECT_LT(std::abs(to_double((sqrt(x) * sqrt(x) - x) / x)), 4 * 2 * kQuadUnitRoundoff) << exponent;
    const Quad far = x * 0x1p1000 * 0x1p1000 * 0x1p1000;  // beyond the range of double
    EXPECT_LT(std::abs(to_double((sqrt(far) * sqrt(far) - far) / far)), 4 * 2 * kQuadUnitRoundoff) << exponent;
  }
  EXPECT_EQ(to_double(sqrt(Quad{0})), 0.0);
  EXPECT_EQ(to_double(sqrt(Quad{-1})), 0.0);
  EXPECT_TRUE(std::isnan(to_double(sqrt(Quad{std::numeric_limits<double>::quiet_NaN()}))));
}

TEST(QuadTest, IsFiniteSeesNanAndBothInfinities) {
  EXPECT_TRUE(is_finite(Quad{1e308} * 1e308));
  EXPECT_FALSE(is_finite(Quad{std::numeric_limits<double>::quiet_NaN()}));
  EXPECT_FALSE(is_finite(Quad{std::numeric_limits<double>::infinity()}));
  EXPECT_FALSE(is_finite(Quad{-std::numeric_limits<double>::infinity()}));
}

TEST(QuadMatrixTest, CholeskySolvesTheHilbertMatrixFarBelowDoubleRounding) {
  constexpr std::size_t n = 10;  // condition number 1.6e13
  QuadMatrix hilbert(n, n);
  QuadVector x(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      hilbert(i, j) = Quad{1} / static_cast<double>(i + j + 1);
      x[i] += hilbert(i, j);
    }
  }
  QuadCholesky factor;
  ASSERT_TRUE(factor.factor(hilbert));
  factor.solve(x.data());
  for (const Quad value : x) EXPECT_LT(std::abs(to_double(value - 1)), 1e-19);
}

TEST(QuadMatrixTest, PositiveDefinitenessIsProvenOnlyWhereItHolds) {
  Matrix A(2, 2);
  A << 1, 1, 1, 1 + 0x1p-52;
  EXPECT_TRUE(proven_positive_definite(QuadMatrix(A), 0));
  A(1, 1) = 1;  // singular
  EXPECT_FALSE(proven_positive_definite(QuadMatrix(A), 0));
  A(1, 1) = 1 - 0x1p-53;
  EXPECT_FALSE(proven_positive_definite(QuadMatrix(A), 0));
  A << 0x1p-1000, 0, 0, 0x1p1000;  // units that differ are no obstacle
  EXPECT_TRUE(proven_positive_definite(QuadMatrix(A), 0));
  A << 1, 0.5, 0.25, 1;  // not symmetric
  EXPECT_FALSE(proven_positive_definite(QuadMatrix(A), 0));
  A << std::numeric_limits<double>::quiet_NaN(), 0, 0, 1;
  EXPECT_FALSE(proven_positive_definite(QuadMatrix(A), 0));
}

// The four Penrose conditions in the form that G and G* symmetric leave: G G* G = G, G* G G* = G*, on every unit
// vector.
void expect_pseudo_inverse(const QuadInertia& inertia, double tolerance) {
  for (std::size_t i = 0; i < inertia.dimension(); ++i) {
    QuadVector unit(inertia.dimension(), 0);
    unit[i] = 1;
    const QuadVector Ge = inertia.apply(unit);
    QuadVector x = Ge;
    inertia.solve(x);
    EXPECT_LT(largest(minus(inertia.apply(x), Ge)), tolerance);
    QuadVector y = unit;
    inertia.solve(y);
    QuadVector z = inertia.apply(y);
    EXPECT_LT(largest(inertia.outside_range(z)), tolerance);
    inertia.solve(z);
    EXPECT_LT(largest(minus(z, y)), tolerance);
  }
}

TEST(QuadInertiaTest, DenseInertiaIsInverted) {
  Draw draw(1);
  const Matrix B = draw.matrix(6, 6);
  const QuadInertia inertia{DenseInertia{Matrix(B * B.transpose() + 0.25 * Matrix::Identity(6, 6))}};
  expect_pseudo_inverse(inertia, 1e-30);
  EXPECT_TRUE(inertia.proven_positive_definite());
}

TEST(QuadInertiaTest, FewFactorsGiveThePseudoInverse) {
  Draw draw(2);
  for (const Index rank : {1, 3, 5}) {
    const QuadInertia inertia{FactoredInertia{draw.matrix(6, rank), Vector::LinSpaced(rank, 0.5, 2)}};
    expect_pseudo_inverse(inertia, 1e-28);
    EXPECT_FALSE(inertia.proven_positive_definite());
  }
}

TEST(QuadInertiaTest, DependentFactorsAreRecognised) {
  Draw draw(3);
  Matrix X(6, 8);  // more factors than rows, of rank 4
  X.leftCols(4) = draw.matrix(6, 4);
  for (Index j = 4; j < 8; ++j) X.col(j) = X.col(j - 4) + 2 * X.col((j - 3) % 4);
  const QuadInertia inertia{FactoredInertia{X, Vector::Ones(8)}};
  ASSERT_TRUE(inertia.well_defined());
  expect_pseudo_inverse(inertia, 1e-28);
  EXPECT_FALSE(inertia.proven_positive_definite());
}

TEST(QuadInertiaTest, NearlyDependentFactorsStayIndependent) {
  Matrix X(2, 2);
  X << 1, 1, 0, 0x1p-30;  // cond(G) about 2^60
  const QuadInertia inertia{FactoredInertia{X, Vector::Ones(2)}};
  EXPECT_TRUE(inertia.proven_positive_definite());
  QuadVector x{0, 1};
  inertia.solve(x);  // G = [2 e; e e^2], G^-1 e_2 = (-1/e, 2/e^2)
  EXPECT_LT(std::abs(to_double(x[0] * 0x1p-30 + 1)), 1e-14);
  EXPECT_LT(std::abs(to_double(x[1] * 0x1p-61 - 1)), 1e-14);
}

/// Factors that are 2^-60 apart are two; of 2^-95 nothing tells whether they are one but for rounding. Of 2^-110 the
/// units of the second coordinate decide.
TEST(QuadInertiaTest, WithoutAVisibleGapTheRankIsUnresolved) {
  const auto apart = [](double distance) {
    Matrix X(3, 2);
    X << 1, 1, 0, distance, 0, 0;
    return QuadInertia(FactoredInertia{X, Vector::Ones(2)});
  };
  EXPECT_TRUE(apart(0x1p-95).unresolved());
  EXPECT_FALSE(apart(0x1p-95).well_defined());
  const QuadInertia square(FactoredInertia{Matrix{{1, 0}, {1, 0x1p-70}}, Vector::Ones(2)});
  EXPECT_TRUE(square.unresolved());
  EXPECT_FALSE(square.proven_positive_definite());
  EXPECT_TRUE(apart(0x1p-110).unresolved());
  EXPECT_TRUE(QuadInertia(DenseInertia{Matrix{{1, 0, 1}, {0, 0x1p-110, 0}, {1, 0, 1}}}).unresolved());
  const QuadInertia two = apart(0x1p-60);
  ASSERT_TRUE(two.well_defined());
  EXPECT_EQ(to_double(two.outside_range({0, 1, 0})[1]), 0);
  QuadVector x{1, 0, 0};
  two.solve(x);  // G = [2 e; e e^2] in the first two coordinates
  EXPECT_NEAR(to_double(x[0]), 1, 0x1p-40);
  EXPECT_NEAR(to_double(x[1] * 0x1p-60), -1, 0x1p-40);
  const QuadInertia one = apart(0);
  ASSERT_TRUE(one.well_defined());
  QuadVector y{1, 0, 0};
  one.solve(y);
  EXPECT_NEAR(to_double(y[0]), 0.5, 1e-15);
}

/// Also where exact integers would be too long.
TEST(QuadInertiaTest, TheRankOfManyFactorsHasAGap) {
  Matrix X = Matrix::Identity(65, 65);
  X.col(7) = X.col(3) + X.col(5);
  const QuadInertia inertia(FactoredInertia{X, Vector::Ones(65)});
  ASSERT_TRUE(inertia.well_defined());
  QuadVector outside(65, 0);
  outside[7] = 1;
  EXPECT_TRUE(inertia.outside_range(outside)[7] == 1);
  QuadVector x(65, 1);
  inertia.solve(x);  // x_3 and x_5 by [2 1; 1 2], the rest as they are
  EXPECT_LT(std::abs(to_double(x[3] - Quad{1} / 3)), 1e-30);
  EXPECT_TRUE(x[7] == 0);
  EXPECT_LT(std::abs(to_double(x[9] - 1)), 1e-30);
}

TEST(QuadInertiaTest, NegativeWeightsProveNothing) {
  const QuadInertia inertia(FactoredInertia{Matrix::Identity(2, 2), Vector{{1, -1}}});
  EXPECT_FALSE(inertia.well_defined());
  EXPECT_FALSE(inertia.proven_positive_definite());
}

/// Factors without weight add nothing to the range.
TEST(QuadInertiaTest, FactorsWithoutWeightAreNone) {
  const QuadInertia inertia(FactoredInertia{Matrix::Identity(3, 3), Vector{{1, 0, 4}}});
  ASSERT_TRUE(inertia.well_defined());
  EXPECT_FALSE(inertia.proven_positive_definite());
  QuadVector x{1, 2, 3};
  inertia.solve(x);
  EXPECT_LT(largest(minus(x, {1, 0, Quad{3} / 4})), 1e-33);
}

TEST(QuadInertiaTest, SingularDenseInertiaIsPseudoInverted) {
  Matrix G(3, 3);
  G << 2, 2, 0, 2, 2, 0, 0, 0, 3;
  const QuadInertia inertia{DenseInertia{G}};
  ASSERT_TRUE(inertia.well_defined());
  EXPECT_FALSE(inertia.proven_positive_definite());
  QuadVector x{1, 1, 6};
  inertia.solve(x);
  EXPECT_LT(largest(minus(x, {Quad{1} / 4, Quad{1} / 4, 2})), 1e-33);
}

TEST(QuadInertiaTest, BlocksAreTheDenseMatrixTheySpell) {
  Draw draw(4);
  BlockInertia bodies;
  for (int b = 0; b < 3; ++b) {
    const Matrix B = draw.matrix(3, 3);
    bodies.blocks.push_back(Matrix(B * B.transpose() + 0.5 * Matrix::Identity(3, 3)));
  }
  const QuadInertia blocks(bodies);
  const QuadInertia dense(DenseInertia{dense_inertia(bodies)});
  QuadVector x(9, 0);
  x[4] = 1;
  QuadVector sparse = x;
  QuadVector whole = x;
  std::vector<std::size_t> pattern{4};
  blocks.solve(sparse, pattern);
  dense.solve(whole);
  EXPECT_LT(largest(minus(sparse, whole)), 1e-31);
  EXPECT_EQ(pattern, (std::vector<std::size_t>{3, 4, 5}));
}

TEST(QuadInertiaTest, WhatIsNoInertiaIsRefused) {
  Matrix indefinite(2, 2);
  indefinite << 1, 0, 0, -1;
  EXPECT_FALSE(QuadInertia(DenseInertia{indefinite}).well_defined());
  Matrix nan = Matrix::Identity(2, 2);
  nan(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(QuadInertia(DenseInertia{nan}).well_defined());
  EXPECT_FALSE(QuadInertia(InverseInertia{nan}).well_defined());
  EXPECT_FALSE(QuadInertia(FactoredInertia{Matrix::Identity(2, 2), Vector::Constant(2, -1)}).well_defined());
}

/// G = 0 with no factor at all: nothing moves.
TEST(QuadInertiaTest, NoFactorsMoveNothing) {
  const QuadInertia inertia(FactoredInertia{Matrix(3, 0), Vector(0)});
  ASSERT_TRUE(inertia.well_defined());
  const QuadVector x{1, 2, 3};
  QuadVector y = x;
  inertia.solve(y);
  for (const Quad& value : y) EXPECT_TRUE(value == 0);
}

}  // namespace
}  // namespace lcpbench::quad_test
