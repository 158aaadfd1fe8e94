#include "native/proofs/support_search.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/textbook_lcps.h"

namespace lcpbench::support_search_test {
namespace {

using testing::TextbookLcp;
using testing::Uniform;

constexpr double kForever = std::numeric_limits<double>::infinity();
constexpr std::int64_t kAllSystems = std::numeric_limits<std::int64_t>::max();

struct Enumerated {
  bool solvable = false;
  Vector z;  ///< the first solution
};

Enumerated enumerate(const Lcp& lcp) {
  SupportSearch search;
  search.load(lcp);
  if (search.run(kForever, kAllSystems) != SupportSearch::End::kFound) return {};
  return {true, search.z()};
}

class SupportSearchOnTextbookLcps : public ::testing::TestWithParam<TextbookLcp> {};

TEST_P(SupportSearchOnTextbookLcps, DecidesThemAll) {
  const TextbookLcp& textbook = GetParam();
  const Enumerated found = enumerate(textbook.lcp);
  ASSERT_EQ(found.solvable, textbook.solvable);
  if (!textbook.solvable) return;
  EXPECT_GE(found.z.minCoeff(), 0);
  // One rounding of each z_i, and the residual itself is computed in double.
  EXPECT_LE(testing::relative_residual(textbook.lcp, found.z), 1e-14) << found.z.transpose();
  if (textbook.unique) {
    EXPECT_EQ(found.z, textbook.z) << found.z.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(All, SupportSearchOnTextbookLcps, ::testing::ValuesIn(testing::textbook_lcps()),
                         [](const auto& test) { return test.param.name; });

TEST(SupportSearchTest, OfSeveralSolutionsTheFirstSupportIsReturned) {
  const Matrix M = testing::matrix_of(2, {-1, 2, 2, -1});
  const Enumerated three = enumerate(Lcp{M, testing::vector_of({1, 1})});  // solutions (0, 0), (1, 0), (0, 1)
  EXPECT_EQ(three.z, testing::vector_of({0, 0}));
  const Enumerated plates = enumerate(Lcp{testing::matrix_of(2, {1, -1, -1, 1}), testing::vector_of({-1, 1})});
  EXPECT_EQ(plates.z, testing::vector_of({1, 0}));  // of (1 + t, t): the vertex
}

// Solvable by construction, most of them with singular principal submatrices and degenerate: a claim that nothing
// solves them would be false.
TEST(SupportSearchTest, NeverCallsASolvableProblemUnsolvable) {
  Uniform uniform(1);
  for (int trial = 0; trial < 3000; ++trial) {
    const Index n = uniform.integer(1, 5);
    Matrix M(n, n);
    Vector t(n);
    for (Index j = 0; j < n; ++j) {
      t(j) = static_cast<double>(uniform.integer(-2, 2));
      for (Index i = 0; i < n; ++i) M(i, j) = static_cast<double>(uniform.integer(-1, 1));
    }
    if (trial % 2 == 0) M.row(n - 1) = M.row(0);
    Vector planted;
    const Lcp lcp = testing::plant(M, t, planted);
    const Enumerated found = enumerate(lcp);
    ASSERT_TRUE(found.solvable) << "trial " << trial << "\n" << lcp.M << "\n" << lcp.q.transpose();
    ASSERT_LE(testing::relative_residual(lcp, found.z), 1e-14) << "trial " << trial;
  }
}

// u >= 0 with M'u <= 0 and q'u < 0 leaves no z >= 0 with M z + q >= 0.
TEST(SupportSearchTest, NeverSolvesAnInfeasibleProblem) {
  Uniform uniform(2);
  for (int trial = 0; trial < 1000; ++trial) {
    const Index n = uniform.integer(2, 6);
    Matrix M(n, n);
    Vector q(n);
    for (Index j = 0; j < n; ++j) {
      q(j) = static_cast<double>(uniform.integer(-3, 3));
      for (Index i = 0; i < n; ++i) M(i, j) = static_cast<double>(uniform.integer(-2, 2));
    }
    M.row(n - 1) = -M.topRows(n - 1).colwise().sum();  // u = e
    q(n - 1) = -q.head(n - 1).sum() - 1;
    ASSERT_FALSE(enumerate(Lcp{M, q}).solvable) << "trial " << trial;
  }
}

TEST(SupportSearchTest, TellsSupportsThatDoubleDoesNot) {
  // With e = 2^-40: det M = e^2, q = -M (1, 1), and each single variable solves its own row but leaves the other w at
  // -e^2, which double arithmetic rounds to zero.
  const double e = 0x1p-40;
  const Enumerated found =
      enumerate(Lcp{testing::matrix_of(2, {1, 1 + e, 1 - e, 1}), testing::vector_of({-2 - e, e - 2})});
  ASSERT_TRUE(found.solvable);
  EXPECT_TRUE(found.z.isApprox(testing::vector_of({1, 1}), 0x1p-28)) << found.z.transpose();  // 2^-113 / e^2
}

TEST(SupportSearchTest, SpansTheRangeOfDoubles) {
  const Enumerated tiny = enumerate(Lcp{testing::matrix_of(1, {1e-290}), testing::vector_of({-1})});
  ASSERT_TRUE(tiny.solvable);
  EXPECT_DOUBLE_EQ(tiny.z(0), 1e290);

  const Enumerated overflow = enumerate(Lcp{testing::matrix_of(1, {1e-200}), testing::vector_of({-1e200})});
  ASSERT_TRUE(overflow.solvable);
  EXPECT_EQ(overflow.z(0), kForever);

  const Matrix denormal = 0x1p-1060 * testing::tridiagonal(6, 4, -1);
  const Enumerated ones = enumerate(Lcp{denormal, -denormal * testing::ones(6)});
  ASSERT_TRUE(ones.solvable);
  EXPECT_EQ(ones.z, testing::ones(6));
}

TEST(SupportSearchTest, RoundsEachEntryToNearest) {
  for (const double denominator : {3.0, 7.0, 10.0, 49.0, 1e17, 0x1.fffffffffffffp+3}) {
    const Enumerated found = enumerate(Lcp{testing::matrix_of(1, {denominator}), testing::vector_of({-1})});
    ASSERT_TRUE(found.solvable);
    EXPECT_EQ(found.z(0), 1 / denominator);  // IEEE division rounds to nearest
  }
}

/// I + S, S skew, of entries +-1 with orthogonal rows: by the squares modulo 11. [Paley 1933]
Matrix hadamard_matrix_12() {
  constexpr std::array<int, 11> kSquare = {0, 1, -1, 1, 1, 1, -1, -1, -1, 1, -1};
  Matrix H = Matrix::Identity(12, 12);
  for (Index i = 0; i < 11; ++i) {
    H(0, i + 1) = 1;
    H(i + 1, 0) = -1;
    for (Index j = 0; j < 11; ++j) {
      if (i != j) H(i + 1, j + 1) = kSquare[static_cast<std::size_t>((i - j + 11) % 11)];
    }
  }
  return H;
}

// No matrix with entries of this size has a larger determinant. [Hadamard 1893]
TEST(SupportSearchTest, HasRoomForTheLargestDeterminant) {
  const Matrix H = hadamard_matrix_12();
  ASSERT_EQ(H * H.transpose(), 12 * Matrix::Identity(12, 12));
  const double odd = 0x1p53 - 1;
  const Enumerated found = enumerate(Lcp{odd * H, -odd * Vector::Unit(12, 0)});
  ASSERT_TRUE(found.solvable);
  EXPECT_EQ(found.z, Vector::Constant(12, 1.0 / 12));  // H' e_0 / 12
}

TEST(SupportSearchTest, ObeysItsLimits) {
  const Lcp last_support{Matrix::Identity(10, 10), -testing::ones(10)};
  SupportSearch search;
  search.load(last_support);
  EXPECT_EQ(search.run(0, kAllSystems), SupportSearch::End::kTimeLimit);
  EXPECT_EQ(search.run(kForever, 100), SupportSearch::End::kSystemLimit);
  EXPECT_EQ(search.run(kForever, kAllSystems), SupportSearch::End::kFound);
}

/// 12 rows of doubles that span 2,000 bits; the solution has its support among the first three.
Lcp of_2000_bits() {
  Uniform uniform(3);
  Matrix M = Matrix::Identity(12, 12);
  for (Index j = 0; j < 12; ++j) {
    for (Index i = 0; i < 12; ++i) {
      if (i != j) M(i, j) = (i + j) % 2 == 0 ? 1e300 * (1 + std::fabs(uniform())) : 1e-300 * uniform();
    }
  }
  Vector q = Vector::Constant(12, 1e300);
  q.head(3).setConstant(-1);
  return {M, q};
}

TEST(SupportSearchTest, SolvesWhatSpans2000Bits) {
  const Lcp lcp = of_2000_bits();
  const Enumerated found = enumerate(lcp);
  ASSERT_TRUE(found.solvable);
  EXPECT_LE(testing::relative_residual(lcp, found.z), 1e-14);
}

// Entries of z from 2^-120 to 2^120: what elimination leaves of a small one is no rounding of a large one.
TEST(SupportSearchTest, DoesNotDependOnTheScaleOfColumns) {
  const Index n = 7;
  Matrix M = testing::tridiagonal(n, 4, -1);
  const Vector q = -M * testing::ones(n);
  Vector expected(n);
  for (Index j = 0; j < n; ++j) {
    expected(j) = std::ldexp(1.0, static_cast<int>(40 * ((3 * j) % n) - 120));
    M.col(j) /= expected(j);
  }
  const Enumerated found = enumerate(Lcp{M, q});
  ASSERT_TRUE(found.solvable);
  EXPECT_EQ(found.z, expected);
}

}  // namespace
}  // namespace lcpbench::support_search_test
