#include "core/exact_inertia.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "core/prime_field.h"

namespace lcpbench::exact_inertia_test {
namespace {

Matrix matrix(std::initializer_list<std::initializer_list<double>> rows) {
  Matrix A(static_cast<Index>(rows.size()), static_cast<Index>(rows.begin()->size()));
  Index i = 0;
  for (const auto& row : rows) {
    Index j = 0;
    for (const double entry : row) A(i, j++) = entry;
    ++i;
  }
  return A;
}

ExactMatrix times(ExactMatrix A, const Dyadic& factor) {
  for (Dyadic& entry : A.entries) entry = entry * factor;
  return A;
}

bool equal(const ExactMatrix& A, const ExactMatrix& B) {
  return std::equal(A.entries.begin(), A.entries.end(), B.entries.begin(),
                    [](const Dyadic& a, const Dyadic& b) { return (a - b).is_zero(); });
}

bool symmetric(const ExactMatrix& A) {
  for (Index i = 0; i < A.rows; ++i) {
    for (Index j = 0; j < i; ++j) {
      if (!(A(i, j) - A(j, i)).is_zero()) return false;
    }
  }
  return true;
}

/// The four conditions of Moore and Penrose, without rounding. For a regular G they say that G* is the inverse.
void expect_pseudo_inverse(const ExactMatrix& G, const ExactResponse::Block& block) {
  ASSERT_EQ(block.denominator.sign(), 1);
  const ExactMatrix& S = block.numerator;
  const ExactMatrix GS = product(G, S);
  EXPECT_TRUE(equal(product(GS, G), times(G, block.denominator)));
  EXPECT_TRUE(equal(product(S, GS), times(S, block.denominator)));
  EXPECT_TRUE(symmetric(GS));
}

ExactMatrix exact_inertia(const FactoredInertia& factors) {
  const ExactMatrix X(factors.X);
  ExactMatrix weighted(factors.X.transpose());
  for (Index k = 0; k < weighted.rows; ++k) {
    for (Index i = 0; i < weighted.cols; ++i) weighted(k, i) = weighted(k, i) * Dyadic(factors.alpha(k));
  }
  return product(X, weighted);
}

TEST(DyadicTest, SumsProductsAndQuotientsKeepEveryBit) {
  const Dyadic one(1.0);
  const Dyadic tiny(0x1p-1074);
  EXPECT_EQ(((one + tiny) * (one - tiny) - one + tiny * tiny).sign(), 0);
  EXPECT_EQ((Dyadic(1e300) * Dyadic(1e300) - Dyadic(1e300) * Dyadic(1e300) - tiny).sign(), -1);
  EXPECT_TRUE(quotient(Dyadic(1.0), Dyadic(3.0)) == Quad{1} / Quad{3});
  EXPECT_TRUE(quotient(Dyadic(-0x1p1000) * Dyadic(0x1p1000), Dyadic(0x1p1000)) == -Quad{0x1p1000});
  const Quad third = Quad{1} / Quad{3};
  EXPECT_TRUE(quotient(Dyadic(third), one) == third);
}

TEST(PrimeFieldTest, TheFirstPrimesBelowTwoToTheSixtyTwo) {
  EXPECT_EQ(prime_field(0).prime(), (std::uint64_t{1} << 62) - 57);
  EXPECT_EQ(prime_field(1).prime(), (std::uint64_t{1} << 62) - 87);
  const PrimeField& field = prime_field(0);
  EXPECT_EQ(field.value(field.multiply(field.of(std::uint64_t{3}), field.inverse(field.of(std::uint64_t{3})))), 1u);
}

TEST(ExactInertiaTest, RankOfNearlyDependentFactors) {
  EXPECT_EQ(independent_columns(ExactMatrix(matrix({{1, 1}, {0, 1e-14}})))->size(), 2u);
  EXPECT_EQ(independent_columns(ExactMatrix(matrix({{1, 1}, {1, 1 + 0x1p-52}})))->size(), 2u);
  EXPECT_EQ(independent_columns(ExactMatrix(matrix({{1, 1}, {0, 0x1p-1074}})))->size(), 2u);
  EXPECT_EQ(*independent_columns(ExactMatrix(matrix({{-1, 1, 0}, {2, -1, 1}, {1, 0, 1}}))), (std::vector<Index>{0, 1}));
  EXPECT_TRUE(independent_columns(ExactMatrix(Matrix::Zero(3, 2)))->empty());
}

TEST(ExactMatrixTest, SolvesWithoutRounding) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> entry(-1, 1);
  std::uniform_int_distribution<int> exponent(-300, 300);
  for (Index n = 0; n <= 6; ++n) {
    SCOPED_TRACE(n);
    const ExactMatrix A(Matrix::NullaryExpr(n, n, [&] { return std::ldexp(entry(random), exponent(random)); }));
    std::vector<Dyadic> b;
    for (Index i = 0; i < n; ++i) b.emplace_back(entry(random));
    const auto x = solve_exactly(A, b);
    ASSERT_TRUE(x.has_value());
    ASSERT_EQ(x->denominator.sign(), 1);
    for (Index i = 0; i < n; ++i) {
      Dyadic missed = -(b[static_cast<std::size_t>(i)] * x->denominator);
      for (Index j = 0; j < n; ++j) missed += A(i, j) * x->numerators[static_cast<std::size_t>(j)];
      EXPECT_TRUE(missed.is_zero()) << i;
    }
  }
}

TEST(ExactMatrixTest, TellsSingularFromNearlySingular) {
  const std::vector<Dyadic> b{Dyadic(1.0), Dyadic(-1.0)};
  EXPECT_TRUE(solve_exactly(ExactMatrix(matrix({{1, 1}, {1, 1}})), b)->denominator.is_zero());
  EXPECT_TRUE(solve_exactly(ExactMatrix(matrix({{3, 1}, {0x1.8p-59, 0x1p-60}})), b)->denominator.is_zero());
  EXPECT_EQ(solve_exactly(ExactMatrix(matrix({{1, 1}, {1, 1 + 0x1p-52}})), b)->denominator.sign(), 1);
  const Matrix wide = matrix({{0x1p1000, 1}, {0x1p-1000, 0x1p1000}});
  Matrix many = Matrix::Identity(24, 24);
  for (Index k = 0; k < 24; k += 2) many.block(k, k, 2, 2) = wide;
  EXPECT_FALSE(solve_exactly(ExactMatrix(many), std::vector<Dyadic>(24, Dyadic(1.0))).has_value());
}

TEST(ExactInertiaTest, DefinitenessOfMatricesNearSingular) {
  EXPECT_TRUE(*is_positive_definite(ExactMatrix(matrix({{1, 1}, {1, 1 + 0x1p-52}}))));
  EXPECT_FALSE(*is_positive_definite(ExactMatrix(matrix({{1, 1}, {1, 1 - 0x1p-53}}))));
  EXPECT_FALSE(*is_positive_definite(ExactMatrix(matrix({{1, 1}, {1, 1}}))));
  EXPECT_FALSE(*is_positive_definite(ExactMatrix(matrix({{-1, 0}, {0, -1}}))));
  EXPECT_TRUE(*is_positive_definite(ExactMatrix(matrix({{0x1p-900, 0}, {0, 0x1p900}}))));
}

TEST(ExactInertiaTest, FactorsOfAnyRankHaveTheirPseudoInverse) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> entry(-1, 1);
  std::uniform_int_distribution<Index> size(1, 7);
  std::uniform_int_distribution<int> kind(0, 3);
  for (int trial = 0; trial < 200; ++trial) {
    SCOPED_TRACE(trial);
    FactoredInertia factors{Matrix(size(random), size(random)), Vector()};
    factors.X = Matrix::NullaryExpr(factors.X.rows(), factors.X.cols(), [&] { return entry(random); });
    factors.alpha = Vector::NullaryExpr(factors.X.cols(), [&] { return 1.5 + entry(random); });
    const Index last = factors.X.cols() - 1;
    switch (kind(random)) {
      case 0: factors.X.row(0) *= std::ldexp(1.0, -140); break;
      case 1: factors.X.col(last) = factors.X.col(0) * (1 + 0x1p-52); break;
      case 2: factors.X.row(factors.X.rows() - 1) = factors.X.row(0); break;
      default: break;
    }
    const auto response = ExactResponse::of(factors);
    ASSERT_TRUE(response);
    expect_pseudo_inverse(exact_inertia(factors), response->blocks().front());
  }
}

TEST(ExactInertiaTest, GivenInertia) {
  for (const Matrix& G : {matrix({{1, 1}, {1, 1 + 0x1p-52}}), matrix({{2, 0, 0}, {0, 3, -3}, {0, -3, 3}}),
                          matrix({{1, 1, 1}, {1, 1, 1}, {1, 1, 2}})}) {
    const auto response = ExactResponse::of(DenseInertia{G});
    ASSERT_TRUE(response);
    expect_pseudo_inverse(ExactMatrix(G), response->blocks().front());
  }
  EXPECT_FALSE(ExactResponse::of(DenseInertia{matrix({{1, 1}, {1, 1 - 0x1p-53}})}));  // indefinite by rounding
  EXPECT_FALSE(ExactResponse::of(DenseInertia{Matrix::Identity(65, 65)}));
}

TEST(ExactInertiaTest, InverseInertiaIsThatOfTheData) {
  const auto light = inverse_inertia(FactoredInertia{matrix({{1, 1}, {0, 1e-14}}), Vector::Ones(2)});
  EXPECT_NEAR(light(1, 1) / 2e28, 1, 1e-12);
  EXPECT_NEAR(light(0, 1) / -1e14, 1, 1e-12);
  const FactoredInertia dependent{matrix({{-1, 1, 0}, {2, -1, 1}, {1, 0, 1}}), Vector::Ones(3)};
  const Matrix G = dense_inertia(dependent);
  const Matrix inverse = inverse_inertia(dependent);
  EXPECT_LE((G * inverse * G - G).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_LE(inverse.cwiseAbs().maxCoeff(), 1);
  const Matrix ill = matrix({{1, 1}, {1, 1 + 0x1p-50}});
  EXPECT_NEAR(inverse_inertia(DenseInertia{ill})(0, 0) / 0x1p50, 1, 1e-12);
}

TEST(ExactInertiaTest, VelocityOfDependentFactors) {
  ContactProblem problem;
  problem.v = Vector::Zero(3);
  problem.v(0) = -1;
  problem.N = matrix({{1}, {0}, {0}});
  problem.D = Matrix::Zero(3, 4);
  problem.edges = {4};
  problem.mu = Vector::Zero(1);
  problem.inertia = FactoredInertia{matrix({{-1, 1, 0}, {2, -1, 1}, {1, 0, 1}}), Vector::Ones(3)};
  Vector z = Vector::Zero(6);
  const ExactContacts exact(problem, *ExactResponse::of(problem.inertia));
  z(0) = to_double(1 / exact.diagonal(0));
  EXPECT_LE(exact.velocity_residual(z), 1e-15);
  const Vector velocity = post_impact_velocity(problem, z);
  EXPECT_NEAR(velocity(0), 0, 1e-14);
  EXPECT_LE(velocity.cwiseAbs().maxCoeff(), 1);
}

}  // namespace
}  // namespace lcpbench::exact_inertia_test
