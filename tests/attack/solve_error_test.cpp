// The bound on the error of solving with an inertia of reduced rank, compared with exact arithmetic.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/quad_inertia.h"
#include "tests/attack/problems.h"
#include "tests/attack/truth.h"
#include "tests/support/contacts.h"

namespace lcpbench::attack::solve_error_test {
namespace {

Dyadic exact(Quad x) {
  Dyadic sum;
  for (int part = 0; part < 3; ++part) {  // of 53 bits each
    const double leading = to_double(x);
    sum = sum + Dyadic(leading);
    x -= leading;
  }
  return sum;
}

struct Compared {
  int within = 0, beyond = 0;
  double worst = 0;  ///< the largest share that an error has of its bound
};

void compare(const Inertia& inertia, const Vector& right, Compared& compared) {
  const QuadInertia known(inertia);
  if (!known.well_defined() || !known.has_reduced_rank()) return;
  QuadVector y(right.begin(), right.end());
  const QuadVector bound = known.solve_error(y);
  known.solve(y);
  const Inverse inverse = exact_response(inertia);
  const DyadicVector expected = product(inverse.numerator, attack::exact(right));
  for (std::size_t i = 0; i < y.size(); ++i) {
    const Dyadic off = abs(exact(y[i]) * inverse.denominator - expected[i]);
    const Dyadic most = exact(bound[i]) * inverse.denominator;
    (off <= most ? compared.within : compared.beyond) += 1;
    if (off.sign() != 0) compared.worst = std::max(compared.worst, quotient(off, most));
  }
}

Vector direction(Index size, Draw& draw) {
  Vector x(size);
  for (double& value : x) value = draw.chance(1, 3) ? draw.small(9) : draw.signed_unit();
  return x;
}

/// Factors of which all but the first are within 2^-bits of the span of those before; right sides are long, and hardly
/// any in the range. At 2^-32 the inertia changes from one way of solving to another.
TEST(SolveErrorTest, BoundsTheErrorOfFactorsThatHardlyDiffer) {
  Compared compared;
  for (int bits = 2; bits <= 60; ++bits) {
    for (std::uint64_t trial = 0; trial < 12; ++trial) {
      Draw draw({stream_id("solve error"), static_cast<std::uint64_t>(bits), trial}, 0);
      const Index ngc = draw.index(2, 5);
      const Index count = draw.index(1, ngc);
      const bool repeats = draw.chance(1, 3);  // more factors than their rank
      FactoredInertia inertia{Matrix(ngc, count + (repeats ? 1 : 0)), Vector::Ones(count + (repeats ? 1 : 0))};
      for (Index k = 0; k < count; ++k) {
        inertia.X.col(k) = direction(ngc, draw);
        if (k > 0) inertia.X.col(k) = inertia.X.col(k - 1) + std::ldexp(1.0, -bits) * inertia.X.col(k);
      }
      if (repeats) inertia.X.col(count) = 2 * inertia.X.col(0);
      for (double& alpha : inertia.alpha) alpha = draw.power_of_two(-8, 8);
      compare(inertia, draw.power_of_two(0, 20) * direction(ngc, draw), compared);
      compare(inertia, inertia.X * Vector::Ones(inertia.X.cols()), compared);
    }
  }
  EXPECT_EQ(compared.beyond, 0) << "the worst is " << compared.worst << " of its bound";
  EXPECT_GT(compared.within, 2000);
  EXPECT_GT(compared.worst, 1e-4) << "the bound is of no use";
}

/// A given G, the exact sum of squares of such factors, of few digits.
TEST(SolveErrorTest, BoundsTheErrorOfAGivenInertia) {
  Compared compared;
  for (int bits = 0; bits <= 18; ++bits) {
    for (std::uint64_t trial = 0; trial < 20; ++trial) {
      Draw draw({stream_id("solve error of G"), static_cast<std::uint64_t>(bits), trial}, 0);
      const Index ngc = draw.index(2, 4), rank = draw.index(1, ngc - 1);
      Matrix X(ngc, rank);
      for (double& x : X.reshaped()) x = draw.small(9);
      for (Index k = 1; k < rank; ++k) X.col(k) = X.col(k - 1) + std::ldexp(1.0, -bits) * X.col(k);
      compare(DenseInertia{product(X, X.transpose())}, direction(ngc, draw), compared);
    }
  }
  EXPECT_EQ(compared.beyond, 0) << "the worst is " << compared.worst << " of its bound";
  EXPECT_GT(compared.within, 300);
}

}  // namespace
}  // namespace lcpbench::attack::solve_error_test
