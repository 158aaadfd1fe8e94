// The bounds that active_set puts on the condition of G, scaled to unit diagonal: its own test of an answer rests on
// them.
#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "core/types.h"

#define LCPBENCH_LEVEL active_set_bounds_test
#include "native/active_set/whitening.h"

namespace lcpbench::active_set_bounds_test {
namespace {

using Whitening = active_set::LCPBENCH_LEVEL::Whitening;

constexpr double kUnitRoundoff = 0x1p-53;

Matrix scaled_to_unit_diagonal(const Matrix& G) {
  const Vector scale = G.diagonal().cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * G * scale.asDiagonal();
}

/// @param N  must stay
bool load(const Matrix& G, const Matrix& N, Whitening& whitening) {
  const Vector v = Vector::Zero(G.rows());
  const active_set::Input input{.ngc = G.rows(), .nc = N.cols(), .v = v.data(), .N = N.data(), .matrix = G.data()};
  whitening.reserve(G.rows(), N.cols(), Whitening::root_factors(input));
  return whitening.load(input);
}

Matrix random_matrix(std::uint64_t seed, Index rows, Index cols) {
  Matrix matrix(rows, cols);
  std::uint64_t state = seed;
  for (double& entry : matrix.reshaped()) {  // [Knuth, MMIX]
    state = state * 6364136223846793005u + 1442695040888963407u;
    entry = static_cast<double>(state >> 11) * 0x1p-52 - 1;
  }
  return matrix;
}

/// A few for each order, of condition numbers up to about 1e12.
std::vector<Matrix> inertias() {
  std::vector<Matrix> all;
  for (const Index n : {1, 2, 3, 7, 8, 9, 15, 16, 17, 31}) {
    const Matrix X = random_matrix(static_cast<std::uint64_t>(n), n, n);
    all.push_back(X * X.transpose() + 1e-10 * Matrix::Identity(n, n));
    const Vector masses = Vector::LinSpaced(n, -6, 6).unaryExpr([](double x) { return std::pow(10, x); });
    all.push_back(masses.asDiagonal() * (X * X.transpose() + Matrix::Identity(n, n)) * masses.asDiagonal());
    Matrix kahan = Matrix::Identity(n, n);
    for (Index i = 0; i < n; ++i) {
      const double size = std::pow(0.8, static_cast<double>(i));
      kahan(i, i) = size;
      kahan.row(i).tail(n - i - 1).setConstant(-0.6 * size);
    }
    if (n < 17) all.push_back(kahan.transpose() * kahan);
    const Matrix positive = X.cwiseAbs();  // its pivots do not fall, and its inverse changes signs
    all.push_back(positive * positive.transpose() + 1e-6 * Matrix::Identity(n, n));
  }
  return all;
}

TEST(ActiveSetBoundsTest, HoldBeforeAndAfterTheyAreSharpened) {
  for (const Matrix& G : inertias()) {
    const Matrix N = Matrix::Ones(G.rows(), 1);
    Whitening whitening;
    ASSERT_TRUE(load(G, N, whitening));
    const Eigen::SelfAdjointEigenSolver<Matrix> eigen(scaled_to_unit_diagonal(G), Eigen::EigenvaluesOnly);
    const double inverse_norm = 1 / eigen.eigenvalues()(0);
    const double trace = eigen.eigenvalues().cwiseInverse().sum();
    const double first = whitening.condition();
    const double first_lost = whitening.lost();
    EXPECT_GE(first, trace) << G;
    whitening.sharpen_condition();
    EXPECT_GE(whitening.condition(), inverse_norm) << G;
    EXPECT_LE(whitening.condition(), 1.3 * trace) << G;
    EXPECT_LE(whitening.condition(), first);
    EXPECT_LE(whitening.lost(), first_lost);
    EXPECT_GE(whitening.lost(), static_cast<double>(G.rows() + 1) * kUnitRoundoff * inverse_norm) << G;
  }
}

TEST(ActiveSetBoundsTest, OfManyBodiesAreThoseOfOneTimesTheirNumber) {
  const Matrix X = random_matrix(5, 6, 6);
  const Matrix body = X * X.transpose() + Matrix::Identity(6, 6);
  const auto bounds = [&](Index bodies) {
    Matrix G = Matrix::Zero(6 * bodies, 6 * bodies);
    for (Index b = 0; b < bodies; ++b) G.block(6 * b, 6 * b, 6, 6) = body;
    const Matrix N = Matrix::Ones(G.rows(), 1);
    Whitening whitening;
    EXPECT_TRUE(load(G, N, whitening));
    const double first = whitening.condition();
    whitening.sharpen_condition();
    return Vector{{first, whitening.condition()}};
  };
  EXPECT_LE((bounds(50) / 50 - bounds(1)).norm(), 1e-9 * bounds(1).norm());
}

TEST(ActiveSetBoundsTest, OfADiagonalInertiaDoNotDependOnTheMasses) {
  const Index n = 12;
  const Vector masses = Vector::LinSpaced(n, -12, 12).unaryExpr([](double x) { return std::pow(10, x); });
  const Matrix N = Matrix::Ones(n, 1);
  Whitening whitening;
  ASSERT_TRUE(load(masses.asDiagonal(), N, whitening));
  EXPECT_NEAR(whitening.condition(), 1.2 * static_cast<double>(n), 1e-9);
}

}  // namespace
}  // namespace lcpbench::active_set_bounds_test
