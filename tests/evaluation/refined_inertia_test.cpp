// Factors in double with residuals in 113 bits give the solutions of a factorization in 113 bits.
#include "core/answer/refined_inertia.h"

#include <Eigen/QR>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/evaluation_cases.h"

namespace lcpbench::refined_inertia_test {
namespace {

double largest_of(const QuadVector& x) {
  double largest = 0;
  for (const Quad value : x) largest = std::fmax(largest, std::abs(to_double(value)));
  return largest;
}

/// Of solutions for b, relative to the largest entry, where each coordinate is measured in `units`.
double difference_of_solutions(const Matrix& G, const Vector& b, const Vector& units) {
  const Inertia inertia(DenseInertia{G});
  QuadVector x(b.begin(), b.end()), y = x;
  const RefinedInertia refined(inertia);
  EXPECT_TRUE(refined.well_defined());
  refined.solve(x);
  EXPECT_TRUE(refined.is_moderate()) << "took factors in 113 bits";
  QuadInertia(inertia).solve(y);
  QuadVector apart;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double unit = units(static_cast<Index>(i));
    apart.push_back((x[i] - y[i]) * unit);
    y[i] *= unit;
  }
  return largest_of(apart) / largest_of(y);
}

Matrix symmetric(const Matrix& G) { return G.selfadjointView<Eigen::Lower>(); }

Matrix of_condition(Draw& draw, Index n, double exponent) {
  const Matrix orthogonal = Eigen::HouseholderQR<Matrix>(draw.matrix(n, n)).householderQ();
  const Vector spectrum = Vector::LinSpaced(n, 0, -exponent).unaryExpr([](double e) { return std::pow(10, e); });
  return symmetric(orthogonal * spectrum.asDiagonal() * orthogonal.transpose());
}

// The condition times the rounding of 113 bits, whatever the units of the coordinates are.
TEST(RefinedInertiaTest, SolvesAsFactorsIn113Bits) {
  Draw draw(2);
  for (int trial = 0; trial < 40; ++trial) {
    const Index n = 2 + trial % 9;
    const double exponent = trial / 5.0;
    const Vector units = draw.vector(n).unaryExpr([](double u) { return std::exp2(std::floor(30 * u)); });
    const Matrix G = units.asDiagonal() * of_condition(draw, n, exponent) * units.asDiagonal();
    EXPECT_LE(difference_of_solutions(symmetric(G), draw.vector(n), units), 0x1p-98 * std::pow(10, exponent)) << trial;
  }
}

// A chain as a robot's inertia is one: a branch of its tree is coupled to no other.
TEST(RefinedInertiaTest, SolvesForATree) {
  Draw draw(3);
  for (const Index n : {4, 9, 27}) {
    Matrix L = Matrix::Identity(n, n);
    for (Index i = 1; i < n; ++i) {
      for (Index j = (i - 1) / 2;; j = (j - 1) / 2) {  // its ancestors
        L(i, j) = draw.uniform() / 2;
        if (j == 0) break;
      }
    }
    EXPECT_LE(difference_of_solutions(symmetric(L.transpose() * L), draw.vector(n), Vector::Ones(n)), 0x1p-95) << n;
  }
}

// Whether double is enough is decided by whether it converges: all but singular, indefinite or asymmetric matrices, and
// numbers at the ends of the range, are left to QuadInertia.
TEST(RefinedInertiaTest, LeavesDoubtfulInertiaTo113Bits) {
  const auto left = [](Matrix G) {
    const Inertia inertia(DenseInertia{std::move(G)});
    return !RefinedInertia(inertia).is_moderate();
  };
  Matrix G = Matrix::Identity(2, 2);
  EXPECT_FALSE(left(G));
  EXPECT_TRUE(left(G * 0x1p-590));
  G(0, 1) = G(1, 0) = 1 - 0x1p-50;
  EXPECT_TRUE(left(G));
  G(0, 1) = G(1, 0) = 2;
  EXPECT_TRUE(left(G));
  const Inertia indefinite(DenseInertia{G});
  EXPECT_FALSE(RefinedInertia(indefinite).well_defined());
  G(0, 1) = 0.5, G(1, 0) = 0.25;
  EXPECT_TRUE(left(G));
  EXPECT_TRUE(left(Matrix::Constant(1, 1, kNan)));
  const Inertia factors(FactoredInertia{Matrix::Identity(2, 2), Vector::Ones(2)});
  EXPECT_FALSE(RefinedInertia(factors).is_moderate());
  EXPECT_TRUE(RefinedInertia(factors).well_defined());
}

TEST(RefinedInertiaTest, TinyImpulsesAreSolvedForIn113Bits) {
  const Inertia inertia(DenseInertia{(Matrix(2, 2) << 2, 1, 1, 2).finished()});
  const RefinedInertia refined(inertia);
  QuadVector x{Quad{0x1p-1000} * 0x1p-1000, 0};
  refined.solve(x);
  EXPECT_FALSE(refined.is_moderate());
  EXPECT_LE(std::abs(to_double(x[0] * 0x1p1000 * 0x1p1000 * 3 - 2)), 0x1p-50);
}

// Of blocks, well or badly conditioned, of factors and of a given inverse.
TEST(RefinedInertiaTest, EnergiesAndColumnsOfTheInverseAreThoseOf113Bits) {
  Draw draw(4);
  const Matrix good = of_condition(draw, 5, 2), bad = of_condition(draw, 5, 8);
  const std::vector<Inertia> cases{BlockInertia{{good, bad, Matrix::Constant(1, 1, 3)}}, DenseInertia{bad},
                                   FactoredInertia{draw.matrix(6, 4), Vector::LinSpaced(4, 1, 2)},
                                   InverseInertia{good}};
  for (const Inertia& inertia : cases) {
    const RefinedInertia refined(inertia);
    const auto n = static_cast<std::size_t>(dimension(inertia));
    const std::vector<std::size_t> rows{0, 2, n - 1};
    const std::vector<double> entries{1, -0.5, 0.25};
    QuadVector x(n, 0), column(n, 0);
    for (std::size_t e = 0; e < rows.size(); ++e) x[rows[e]] = entries[e];
    column[2] = 1;
    refined.solve(x);
    refined.solve(column);
    Quad energy = 0;
    for (std::size_t e = 0; e < rows.size(); ++e) energy += entries[e] * x[rows[e]];
    EXPECT_LE(std::abs(to_double(refined.energy(rows, entries.data()) / energy - 1)), 0x1p-30) << inertia.index();
    std::vector<double> found(n, 0);
    refined.for_each_inverse(2, [&](std::size_t i, Quad entry) { found[i] = to_double(entry); });
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_LE(std::abs(found[i] - to_double(column[i])), 0x1p-30 * largest_of(column)) << inertia.index() << ' ' << i;
    }
  }
}

TEST(RefinedInertiaTest, ProvesOnlyWhatIsDefinite) {
  const auto proven = [](double coupling) {
    const Inertia inertia(DenseInertia{(Matrix(2, 2) << 1, coupling, coupling, 1).finished()});
    return RefinedInertia(inertia).proven_positive_definite();
  };
  EXPECT_TRUE(proven(0.5));
  EXPECT_TRUE(proven(1 - 0x1p-30));
  EXPECT_TRUE(proven(1 - 0x1p-52));  // in 113 bits
  EXPECT_FALSE(proven(1));
  EXPECT_FALSE(proven(1 + 0x1p-52));
}

// The residual of the first row is 1e-4 of the scale, half a unit in its last place, and 2^-124 more or less.
TEST(RefinedInertiaTest, TheVerdictIsThatOf113Bits) {
  for (const double side : {-1.0, 1.0}) {
    Matrix N = Matrix::Zero(4, 2);
    N(0, 0) = 4;
    N.col(1).setOnes();
    const Vector v = vec({-1, -4e-4, -0x1p-65, -side * 0x1p-122});
    const Problem problem(
        "forged", ContactProblem{v, N, Matrix(4, 0), {0, 0}, Vector::Zero(2), DenseInertia{Matrix::Identity(4, 4)}});
    EXPECT_EQ(evaluate(problem, vec({0.25, 0})).solved, side < 0);
  }
}

TEST(RefinedInertiaTest, MeasuresOutliveTheRangeOfADouble) {
  const ContactProblem light{vec({-1, 1}),    (Matrix(2, 2) << 1, 1, 0, 1).finished(),        Matrix(2, 0), {0, 0},
                             Vector::Zero(2), DenseInertia{Matrix::Identity(2, 2) * 0x1p-590}};
  const Errors exact = evaluate(Problem("light", light), vec({0x1p-590, 0}));
  EXPECT_EQ(exact.velocity_residual_m_per_s, 0);
  EXPECT_TRUE(exact.solved);
  const Errors far = evaluate(Problem("light", light), vec({0x1p450, 0}));
  EXPECT_TRUE(std::isinf(far.velocity_residual_m_per_s));
  EXPECT_FALSE(far.solved);
  ContactProblem lightest = light;  // its inverse is beyond the range of a double
  lightest.inertia = DenseInertia{Matrix::Identity(2, 2) * 0x1p-1074};
  Answer wrong = answer(vec({0x1p-1074, 0}));
  EXPECT_TRUE(Evaluator(Problem("lightest", lightest)).errors(wrong).solved);
  wrong.velocity = vec({1e100, 1});
  EXPECT_FALSE(Evaluator(Problem("lightest", lightest)).errors(wrong).solved);
}

// M_ii = 2e400 is in the scale of a returned velocity.
TEST(RefinedInertiaTest, ADiagonalEntryBeyondDoubleExcusesNoVelocity) {
  const ContactProblem contact =
      frictionless(vec({1e200, 2e200}), Matrix{{0, 1e200}, {0, -1e200}}, DenseInertia{Matrix::Identity(2, 2)});
  Answer given = answer(vec({0, 0.5}));
  for (const double off : {0.0, 1e196, 1e199}) {
    given.velocity = vec({1.5e200 + off, 1.5e200});
    EXPECT_EQ(Evaluator(Problem("two that overflow", contact)).errors(given).solved, off < 1e197) << off;
  }
}

}  // namespace
}  // namespace lcpbench::refined_inertia_test
