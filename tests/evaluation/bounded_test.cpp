// The arithmetic in which the evaluation looks first: its bounds hold, and what they leave open is decided in 113 bits.
#include "study/evaluation/bounded.h"

#include <Eigen/QR>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "study/evaluation/bounded_factors.h"
#include "study/evaluation/bounded_inertia.h"
#include "core/quad_inertia.h"
#include "tests/support/evaluation_cases.h"

namespace lcpbench::bounded_test {
namespace {

Quad exactly(const Bounded& x) { return Quad{x.high} + x.low; }

void expect_enclosed(const Bounded& x, Quad truth, Quad slack = 0) {
  EXPECT_LE(to_double(abs(exactly(x) - truth) - slack), 2 * x.error) << x.high << " + " << x.low << " +- " << x.error;
}

TEST(BoundedTest, EncloseWhatTheOperationsMean) {
  Draw draw(1);
  for (int trial = 0; trial < 2000; ++trial) {
    const double scale = std::exp2(40 * draw.uniform());
    const Bounded a = Bounded(draw.uniform()) * 1.1 + scale * draw.uniform() * 0x1p-60;
    const Bounded b = Bounded(draw.uniform() * scale) / 3.0 + 0x1p-70;
    const Quad x = exactly(a), y = exactly(b);
    // 113 bits round by less than 2^-110 of what they add up
    const Quad slack = (abs(x) + abs(y) + abs(x * y)) * 0x1p-110;
    const Bounded exact_a(a.high, a.low, 0), exact_b(b.high, b.low, 0);
    expect_enclosed(exact_a + exact_b, x + y, slack);
    expect_enclosed(exact_a * exact_b, x * y, slack);
    if (x != 0 && y != 0) expect_enclosed(exact_a / exact_b, x / y, abs(x / y) * 0x1p-110);
    if (x != 0) expect_enclosed(sqrt(abs(exact_a)), sqrt(abs(x)), sqrt(abs(x)) * 0x1p-110);
    expect_enclosed((exact_a - exact_b) * exact_b - exact_a * exact_b, -y * y, 4 * slack * (1 + abs(y)));
    BoundedSum sum(exact_a);
    sum.add(a.high, exact_b);
    sum.add(-b.high, exact_a);
    expect_enclosed(sum.value(), x + a.high * y - b.high * x, 4 * slack * (1 + abs(y)));
  }
}

TEST(BoundedTest, DecideNothingBeyondTheRangeOfADouble) {
  const Bounded large = 0x1p1000, small = 0x1p-540;
  EXPECT_FALSE(is_finite(large * large));
  EXPECT_FALSE(surely_less(large, large * large));
  EXPECT_THROW(settled(large * large), Doubt);
  const Bounded lost = small * (small * 1.1);
  expect_enclosed(lost, Quad{0x1p-540} * (Quad{0x1p-540} * 1.1));
  EXPECT_THROW(settled(lost), Doubt);
  EXPECT_FALSE(surely_less(0.0, Bounded(NAN)) || surely_less(Bounded(NAN), 0.0));
  EXPECT_THROW(settled(larger(Bounded(NAN), 1.0)), Doubt);
  EXPECT_EQ(settled(quotient(1.0, 0.0)), kInf);
  EXPECT_THROW(settled(quotient(Bounded(0, 0, 1e-30), 0.0)), Doubt);
  EXPECT_EQ(settled(quotient(0.0, 0.0)), 0);
}

TEST(BoundedTest, SolveWithTheInertiaWithinTheBound) {
  Draw draw(2);
  for (int trial = 0; trial < 40; ++trial) {
    const Index n = 1 + trial % 9;
    Matrix G = draw.matrix(n, n);
    G = G * G.transpose() + Matrix::Identity(n, n) * std::exp2(-trial / 2.0);
    G = Matrix(G.selfadjointView<Eigen::Lower>());
    const Vector units = draw.vector(n).unaryExpr([](double u) { return std::exp2(std::floor(30 * u)); });
    G = Matrix(units.asDiagonal() * G * units.asDiagonal());
    const BoundedInertia inertia{Inertia(DenseInertia{G})};
    ASSERT_TRUE(inertia.well_defined()) << trial;
    const QuadInertia reference{Inertia(DenseInertia{G})};
    const Vector b = draw.vector(n);
    BoundedVector x(b.begin(), b.end());
    BoundedVector of_inexact = x;
    QuadVector y(b.begin(), b.end());
    QuadVector of_changed = y;
    for (std::size_t i = 0; i < x.size(); ++i) {
      of_inexact[i].error = 0x1p-40 * std::abs(x[i].high);
      of_changed[i] *= draw.uniform() < 0 ? 1 - 0x1p-39 : 1 + 0x1p-39;
    }
    inertia.solve(x);
    inertia.solve(of_inexact);
    reference.solve(y);
    reference.solve(of_changed);
    for (std::size_t i = 0; i < x.size(); ++i) {
      expect_enclosed(x[i], y[i], abs(y[i]) * 0x1p-60);
      expect_enclosed(of_inexact[i], of_changed[i]);
      EXPECT_LE(x[i].error, 1e-12 * std::abs(x[i].high) + 1e-22 / units(static_cast<Index>(i)));
    }
  }
}

// A chain as a robot's inertia is one: a branch of its tree is coupled to no other. The bound is no looser than a
// hundred roundings of 106 bits times the condition, so that the residuals of accurate answers need no 113 bits.
TEST(BoundedTest, BoundTheErrorOfAChainTightly) {
  Draw draw(3);
  for (const Index n : {4, 9, 27}) {
    Matrix L = Matrix::Identity(n, n);
    for (Index i = 1; i < n; ++i) {
      for (Index j = (i - 1) / 2;; j = (j - 1) / 2) {  // its ancestors
        L(i, j) = draw.uniform() / 2;
        if (j == 0) break;
      }
    }
    const Matrix lower = L.transpose() * L;
    const Matrix G = Matrix(lower.selfadjointView<Eigen::Lower>());
    const BoundedInertia inertia{Inertia(DenseInertia{G})};
    ASSERT_TRUE(inertia.well_defined()) << n;
    const QuadInertia reference{Inertia(DenseInertia{G})};
    const Vector b = draw.vector(n);
    BoundedVector x(b.begin(), b.end());
    QuadVector y(b.begin(), b.end());
    inertia.solve(x);
    reference.solve(y);
    const double condition = G.norm() * G.inverse().norm();
    double largest = 0;
    for (const Bounded& value : x) largest = std::max(largest, std::abs(value.high));
    for (std::size_t i = 0; i < x.size(); ++i) {
      expect_enclosed(x[i], y[i], abs(y[i]) * 0x1p-105);
      EXPECT_LE(x[i].error, 100 * 0x1p-106 * condition * largest) << n << ' ' << i;
    }
  }
}

// The comparison matrix of its factors would leave a million times as much open.
TEST(BoundedTest, BoundTheErrorOfADenseIllConditionedInertia) {
  Draw draw(5);
  const Index n = 14;
  const Matrix orthogonal = Eigen::HouseholderQR<Matrix>(draw.matrix(n, n)).householderQ();
  const Vector spectrum = Vector::LinSpaced(n, 0, -8).unaryExpr([](double e) { return std::pow(10, e); });
  Matrix G = orthogonal * spectrum.asDiagonal() * orthogonal.transpose();
  G = Matrix(G.selfadjointView<Eigen::Lower>());
  const BoundedInertia inertia{Inertia(DenseInertia{G})};
  ASSERT_TRUE(inertia.well_defined());
  const QuadInertia reference{Inertia(DenseInertia{G})};
  const Vector b = draw.vector(n);
  BoundedVector x(b.begin(), b.end());
  QuadVector y(b.begin(), b.end());
  inertia.solve(x);
  reference.solve(y);
  double largest = 0;
  for (const Bounded& value : x) largest = std::max(largest, std::abs(value.high));
  for (std::size_t i = 0; i < x.size(); ++i) {
    expect_enclosed(x[i], y[i], abs(y[i]) * 0x1p-80);
    EXPECT_LE(x[i].error, 100 * 0x1p-106 * 1e8 * largest) << i;
  }
}

// The comparison matrix of the factors proves less than there is, and nothing that is not.
TEST(BoundedTest, FactorsProveOnlyWhatIsDefinite) {
  BoundedFactors factors;
  const std::vector<double> indefinite{1, 1 + 0x1p-52, 1 + 0x1p-52, 1}, singular{1, 1, 1, 1};
  const std::vector<double> near{1, 1 - 0x1p-30, 1 - 0x1p-30, 1};
  EXPECT_FALSE(factors.add(indefinite, 2, 0x1p-60));
  EXPECT_FALSE(factors.add(singular, 2, 0x1p-60));
  EXPECT_FALSE(factors.add(near, 2, 0x1p-29));  // its least eigenvalue is 2^-30
  EXPECT_EQ(factors.count(), 0U);
  ASSERT_TRUE(factors.add(near, 2, 0x1p-32));
  EXPECT_GE(factors.bound_of_ones(0)[0], 0x1p30);  // of each row: (1 + g) / (1 - g^2) for the coupling g
  EXPECT_LE(factors.bound_of_ones(0)[0], 0x1.01p30);
  std::vector<double> b{1, 0};
  factors.bound(0, b);
  EXPECT_GE(b[0], 0x1p29);
}

// Symmetric, nearly of rank one, with diagonal entries from 1 to 4. Multiples of 2^-48, so that sums are exact in Quad.
Matrix nearly_singular(Draw& draw, Index n, int exponent) {
  const Matrix factor = draw.matrix(n, 2 * n);
  return Matrix::Ones(n, n) + std::exp2(-exponent) * factor * factor.transpose();
}

// What the bounds of BoundedInertia rest on. An accurate solution leaves less than the bound, and hardly one nothing.
TEST(BoundedTest, FactorsLeaveNoMoreThanTheResidualThatTheyPromise) {
  Draw draw(6);
  for (const int exponent : {2, 14, 26}) {
    for (const Index n : {2, 5, 13}) {
      const Matrix A = nearly_singular(draw, n, exponent);
      BoundedFactors factors;
      ASSERT_TRUE(factors.add({A.data(), static_cast<std::size_t>(A.size())}, static_cast<std::size_t>(n), 0x1p-36));
      const Vector b = draw.vector(n);
      std::vector<double> x(b.begin(), b.end());
      factors.solve(0, x);
      double size = 0;
      for (const double value : x) size += std::abs(value);
      Quad largest = 0;
      for (Index i = 0; i < n; ++i) {
        Quad left = b(i);
        for (Index j = 0; j < n; ++j) left -= Quad{A(i, j)} * x[static_cast<std::size_t>(j)];
        largest = larger(largest, abs(left));
      }
      EXPECT_GT(to_double(largest), 0) << exponent << ' ' << n;
      EXPECT_LE(to_double(largest), factors.residual(0) * size) << exponent << ' ' << n;
    }
  }
}

// The solution is a vector of small integers, known without any reference. After one correction an ill-conditioned
// matrix leaves far more than the rounding of the residual.
TEST(BoundedTest, EncloseTheSolutionOfNearlySingularInertias) {
  Draw draw(7);
  for (const int exponent : {2, 14, 26}) {
    for (const Index n : {2, 5, 13}) {
      const Matrix G = nearly_singular(draw, n, exponent);
      const BoundedInertia inertia{Inertia(DenseInertia{G})};
      ASSERT_TRUE(inertia.well_defined()) << exponent << ' ' << n;
      const Vector solution = draw.vector(n).unaryExpr([](double u) { return std::floor(8 * u); });
      for (const double error : {0.0, 0x1p-900}) {
        BoundedVector x;
        for (Index i = 0; i < n; ++i) {
          Quad b = 0;
          for (Index j = 0; j < n; ++j) b += Quad{G(i, j)} * solution(j);
          const double high = to_double(b), low = to_double(b - high);
          ASSERT_TRUE(b == Quad{high} + low);
          x.push_back({high, low, error});
        }
        inertia.solve(x);
        for (std::size_t i = 0; i < x.size(); ++i) {
          expect_enclosed(x[i], solution(static_cast<Index>(i)));
          EXPECT_LE(x[i].error, 0x1p-40) << exponent << ' ' << n;
        }
      }
    }
  }
}

// A body turned by a rounding: its products of inertia are 2^-53 of its moments.
TEST(BoundedTest, SmallCoordinatesBesideLargeOnesAreAsAccurate) {
  Matrix G = Matrix::Identity(3, 3) * 1.1;
  G(0, 1) = G(1, 0) = 0x1.1p-53;
  G(1, 2) = G(2, 1) = -0x1.3p-54;
  const BoundedInertia inertia{Inertia(DenseInertia{G})};
  const QuadInertia reference{Inertia(DenseInertia{G})};
  const Vector b = vec({1.3, 0x1p-50, 0x1.5p-90});
  BoundedVector x(b.begin(), b.end());
  QuadVector y(b.begin(), b.end());
  inertia.solve(x);
  reference.solve(y);
  for (std::size_t i = 0; i < x.size(); ++i) {
    expect_enclosed(x[i], y[i], abs(y[i]) * 0x1p-60);
    EXPECT_LE(x[i].error, 0x1p-55 * std::abs(x[i].high)) << i;
  }
}

// Rounded to a multiple of the least double, 2^-1074, the square of the entry is 2^-1074.
TEST(BoundedTest, TheLeastEnergyIsABoundAlsoWhereSquaresUnderflow) {
  const double inertia = 0x1p-599;
  const BoundedInertia single{Inertia(DenseInertia{Matrix::Constant(1, 1, inertia)})};
  const std::size_t row = 0;
  const double entry = 0x1.8p-538;
  EXPECT_LE(single.least_energy({&row, 1}, &entry), entry / inertia * entry);
  const double larger = 0x1.8p-100;
  EXPECT_GE(single.least_energy({&row, 1}, &larger), (1 - 1e-6) * (larger / inertia * larger));
}

TEST(BoundedTest, LeaveInertiaInDoubtToQuad) {
  const auto well_defined = [](Matrix G) { return BoundedInertia(DenseInertia{std::move(G)}).well_defined(); };
  Matrix G = Matrix::Identity(2, 2);
  EXPECT_TRUE(well_defined(G));
  G(0, 1) = G(1, 0) = 1 - 0x1p-50;
  EXPECT_FALSE(well_defined(G));  // all but singular
  G(0, 1) = G(1, 0) = 2;
  EXPECT_FALSE(well_defined(G));  // indefinite
  G(0, 1) = 0.5, G(1, 0) = 0.25;
  EXPECT_FALSE(well_defined(G));
  EXPECT_FALSE(well_defined(Matrix::Constant(1, 1, kNan)));
  EXPECT_FALSE(BoundedInertia(FactoredInertia{Matrix::Identity(2, 2), Vector::Ones(2)}).well_defined());
}

TEST(BoundedTest, MeasuresBeyondTheRangeOfADoubleAreThoseOf113Bits) {
  const ContactProblem light{vec({-1, 1}),    (Matrix(2, 2) << 1, 1, 0, 1).finished(),        Matrix(2, 0), {0, 0},
                             Vector::Zero(2), DenseInertia{Matrix::Identity(2, 2) * 0x1p-590}};
  for (const double factor : {0x1p-590, 0x1p450, 0x1p1000}) {
    const Vector z = vec({factor, 0x1p-1060 * factor});
    const Errors found = Evaluator(Problem("light", light)).errors(answer(z));
    const Errors in_quad = Evaluator(Problem("light", light), Precision::kQuad).errors(answer(z));
    for (const Metric& metric : kMetrics) {
      const double a = found.*metric.value, b = in_quad.*metric.value;
      EXPECT_TRUE(a == b || (std::isnan(a) && std::isnan(b)) || std::abs(a - b) <= 1e-15 * std::abs(b))
          << metric.name << ' ' << factor << ": " << a << ", " << b;
    }
  }
}

// With fused multiply-adds and without the same bits.
TEST(BoundedTest, EveryLevelOfTheProcessorGivesTheSameSums) {
  Draw draw(4);
  const BoundedDot dot = bounded_dot_of_level();
  std::vector<double> a;
  std::vector<std::size_t> rows;
  BoundedVector x;
  for (std::size_t k = 0; k < 30; ++k) {
    a.push_back(draw.uniform() * std::exp2(20 * draw.uniform()));
    rows.push_back(k);
    x.push_back(Bounded(draw.uniform()) / 3.0);
    BoundedSum sum;
    for (std::size_t e = 0; e < a.size(); ++e) sum.add(a[e], x[e]);
    const Bounded found = dot(a.data(), rows.data(), a.size(), x.data());
    EXPECT_TRUE(found.high == sum.value().high && found.low == sum.value().low && found.error == sum.value().error);
  }
}

// Pairs of opposite products, in any order, leave a number between 2^-60 and 2^-300 of them: far below the last bits of
// a Bounded or of 113 bits.
TEST(BoundedTest, ASumWithoutRoundingFindsWhatCancellationLeaves) {
  Draw draw(9);
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<double> a;
    std::vector<std::size_t> rows;
    BoundedVector x;
    const auto add = [&](double factor, double value) {
      a.push_back(factor);
      rows.push_back(rows.size());
      x.push_back(value);
    };
    const int pairs = 1 + trial % 12;
    for (int pair = 0; pair < pairs; ++pair) {
      const double factor = draw.uniform() / 3, value = draw.uniform() * std::exp2(30 * draw.uniform()) / 7;
      add(factor, value);
      add(-factor, value);
    }
    const double rest = trial % 3 == 0 ? 0 : draw.uniform() * std::exp2(-60 - trial % 240);
    add(1, rest);
    for (std::size_t k = rows.size() - 1; k > 0; --k) std::swap(rows[k], rows[draw.bits() % (k + 1)]);
    std::vector<double> factors;
    for (const std::size_t row : rows) factors.push_back(a[row]);
    const std::optional<Bounded> found = exact_dot(factors.data(), rows.data(), rows.size(), x.data());
    ASSERT_TRUE(found) << trial;
    EXPECT_TRUE(surely_equal(*found, rest)) << trial << ": " << found->high << ", not " << rest;
  }
}

// Sums of products that do not cancel lie in their bound, too; numbers with errors, and such as may lose bits, are none
// of which the sum is known.
TEST(BoundedTest, ASumWithoutRoundingIsRoundedOnce) {
  Draw draw(10);
  std::vector<double> a;
  std::vector<std::size_t> rows;
  BoundedVector x;
  Quad sum = 0;
  for (std::size_t k = 0; k < 40; ++k) {
    a.push_back(draw.uniform() / 3);
    rows.push_back(k);
    x.push_back({draw.uniform(), 0x1p-60 * draw.uniform(), 0});
    sum += a.back() * exactly(x.back());
    const std::optional<Bounded> found = exact_dot(a.data(), rows.data(), a.size(), x.data());
    ASSERT_TRUE(found);
    expect_enclosed(*found, sum, Quad{0x1p-105});
    EXPECT_LE(found->error, 0x1p-100);
  }
  x[7].error = 0x1p-200;
  EXPECT_FALSE(exact_dot(a.data(), rows.data(), a.size(), x.data()));
  x[7] = 0x1p-1000;
  EXPECT_FALSE(exact_dot(a.data(), rows.data(), a.size(), x.data()));
  x[7] = kInf;
  EXPECT_FALSE(exact_dot(a.data(), rows.data(), a.size(), x.data()));
}

// The three parts (2^53 + 10^6), 2^-30 and 2^-34 of a sum have gaps between them; none is left out.
TEST(BoundedTest, ASumWithoutRoundingKeepsItsSmallParts) {
  const std::array<double, 2> ones{1, 1};
  const std::array<std::size_t, 2> rows{0, 1};
  const BoundedVector x{{-(0x1p80 - 0x1p53), 0x1p-34, 0}, {0x1p80, 1e6 + 0x1p-30, 0}};
  const std::optional<Bounded> found = exact_dot(ones.data(), rows.data(), rows.size(), x.data());
  ASSERT_TRUE(found);
  EXPECT_EQ(found->high, 0x1p53 + 1e6);
  EXPECT_EQ(found->low, 0x1p-30 + 0x1p-34);
  EXPECT_EQ(found->error, 0);
}

// rho is 1e-4, half a unit in its last place, and 2^-124 more or less: rounded to double it is 1e-4 or the number after
// it, which only a hundred and ten bits tell apart.
TEST(BoundedTest, WhatTheBoundLeavesOpenIsDecidedIn113Bits) {
  for (const double side : {-1.0, 1.0}) {
    Matrix N = Matrix::Zero(4, 2);
    N(0, 0) = 4;
    N.col(1).setOnes();
    const Vector v = vec({-1, -4e-4, -0x1p-65, -side * 0x1p-122});
    const Problem problem(
        "forged", ContactProblem{v, N, Matrix(4, 0), {0, 0}, Vector::Zero(2), DenseInertia{Matrix::Identity(4, 4)}});
    const Errors found = Evaluator(problem).errors(answer(vec({0.25, 0})));
    const Errors in_quad = Evaluator(problem, Precision::kQuad).errors(answer(vec({0.25, 0})));
    EXPECT_EQ(in_quad.solved, side < 0);
    EXPECT_EQ(found.solved, in_quad.solved);
    EXPECT_EQ(found.velocity_residual_relative, in_quad.velocity_residual_relative);
  }
}

// The residuals differ by 2^-80, of which no digit is printed: it takes no 113 bits to name one of the two.
TEST(BoundedTest, OfRowsThatAreEqualToThePromisedAccuracyAnyIsTheWorst) {
  Matrix N = Matrix::Zero(4, 2);
  N(0, 0) = N(1, 1) = N(3, 1) = 1;
  N(2, 0) = N(2, 1) = 0x1p-70;
  const auto worst = [&](double difference, Precision precision) {
    const Problem problem("tie", ContactProblem{vec({-1, -1, 0, -difference}),
                                                N,
                                                Matrix(4, 0),
                                                {0, 0},
                                                Vector::Zero(2),
                                                DenseInertia{Matrix::Identity(4, 4)}});
    return Evaluator(problem, precision).errors(answer(vec({0, 0}))).worst.row;
  };
  EXPECT_EQ(worst(0x1p-80, Precision::kQuad), 1);
  EXPECT_EQ(worst(0x1p-80, Precision::kAsNeeded), 0);
  EXPECT_EQ(worst(0x1p-29, Precision::kAsNeeded), 1);
}

TEST(BoundedTest, ABackwardErrorIsPassedOnWithTheRoundingOfTheData) {
  EXPECT_EQ(settled(Bounded(1e-17, 0, 0x1p-54), kSettledByData), 1e-17);
  EXPECT_THROW(settled(Bounded(1e-17, 0, 0x1p-54)), Doubt);
  EXPECT_THROW(settled(Bounded(1e-17, 0, 0x1p-53), kSettledByData), Doubt);
  EXPECT_EQ(settled(Bounded(1, 0, 0x1p-31), kSettledByData), 1);
}

}  // namespace
}  // namespace lcpbench::bounded_test
