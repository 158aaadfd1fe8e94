#define LCPBENCH_LEVEL rounded_shares_test

#include "native/contact_lemke/rounded_shares.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/types.h"
#include "tests/support/evaluation_cases.h"

namespace lcpbench::rounded_shares_test {
namespace {

using Shares = lemke::rounded_shares_test::RoundedShares<double>;

/// 1 is no multiple of it.
constexpr double kStep = 0.003;

/// The shares of A's columns, each rounded to a multiple of kStep; empty where the columns are found to be dependent.
std::vector<double> rounded_shares(const Matrix& A) {
  Shares shares;
  shares.load(A.rows());
  shares.clear();
  for (Index k = 0; k < A.cols(); ++k) {
    double* const column = shares.next_column();
    for (Index i = 0; i < A.rows(); ++i) column[i] = A(i, k);
  }
  std::vector<double> y(static_cast<std::size_t>(A.cols()));
  const bool found = shares.round([&](Index k, double share) {
    return y[static_cast<std::size_t>(k)] = kStep * std::round(share / kStep);
  });
  return found ? y : std::vector<double>();
}

TEST(RoundedSharesTest, TheShortestColumnMakesUpForTheRoundingOfTheOthers) {
  Draw draw(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Vector direction = draw.vector(6).normalized();
    Matrix A(6, 4);
    for (Index k = 0; k < 4; ++k) A.col(k) = std::pow(10, k) * direction + 1e-3 * draw.vector(6);
    const std::vector<double> y = rounded_shares(A);
    ASSERT_EQ(y.size(), 4);
    Vector miss = A.rowwise().sum();
    for (Index k = 0; k < 4; ++k) miss -= y[static_cast<std::size_t>(k)] * A.col(k);
    // Half a step of what each column adds to those before it: 1, and at most sqrt(6) / 1000 of each other one. Rounded
    // each for itself the columns miss by a thousandth of their sum, 1.1.
    EXPECT_LE(miss.norm(), kStep / 2 * 1.01);
  }
}

TEST(RoundedSharesTest, DependentColumnsAreRefused) {
  Draw draw(2);
  for (int trial = 0; trial < 500; ++trial) {
    Matrix A(6, 4);
    for (const Index k : {0, 1, 3}) A.col(k) = draw.vector(6);
    A.col(2) = (1 + draw.uniform() / 2) * A.col(0) + (1 + draw.uniform() / 2) * A.col(1);
    EXPECT_TRUE(rounded_shares(A).empty()) << trial;
  }
}

}  // namespace
}  // namespace lcpbench::rounded_shares_test
