#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "generators/sets.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench {
SolverDefinition lcpbench_solver_enumeration();

namespace {

using testing::TextbookLcp;
using testing::Uniform;

Answer enumerate(const Problem& problem, double time_limit_s = std::numeric_limits<double>::infinity()) {
  const auto solver = lcpbench_solver_enumeration().make({});
  solver->load(problem);
  Answer answer;
  SolveRequest request;
  request.time_limit_s = time_limit_s;
  solver->solve(request, answer);
  return answer;
}

Answer enumerate(const Lcp& lcp) { return enumerate(Problem("case", lcp)); }

class EnumerationOnTextbookLcps : public ::testing::TestWithParam<TextbookLcp> {};

TEST_P(EnumerationOnTextbookLcps, DecidesThemAll) {
  const TextbookLcp& textbook = GetParam();
  const Answer answer = enumerate(textbook.lcp);
  if (!textbook.solvable) {
    EXPECT_EQ(answer.claim, Claim::kUnsolvable) << answer.detail;
    return;
  }
  ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_GE(answer.z.minCoeff(), 0);
  // One rounding of each z_i, and the residual itself is computed in double.
  EXPECT_LE(testing::relative_residual(textbook.lcp, answer.z), 1e-14) << answer.z.transpose();
  if (textbook.unique) {
    EXPECT_EQ(answer.z, textbook.z) << answer.z.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(All, EnumerationOnTextbookLcps, ::testing::ValuesIn(testing::textbook_lcps()),
                         [](const auto& test) { return test.param.name; });

TEST(EnumerationTest, OfSeveralSolutionsTheFirstSupportIsReturned) {
  const Matrix M = testing::matrix_of(2, {-1, 2, 2, -1});
  const Answer three = enumerate({M, testing::vector_of({1, 1})});  // solutions (0, 0), (1, 0), (0, 1)
  EXPECT_EQ(three.z, testing::vector_of({0, 0}));
  const Answer plates = enumerate({testing::matrix_of(2, {1, -1, -1, 1}), testing::vector_of({-1, 1})});
  EXPECT_EQ(plates.z, testing::vector_of({1, 0}));  // of (1 + t, t): the vertex
  EXPECT_EQ(plates.detail, "exact solution with z = 0 outside {0}");
}

// Solvable by construction, most of them with singular principal submatrices and degenerate: a claim that nothing
// solves them would be false.
TEST(EnumerationTest, NeverCallsASolvableProblemUnsolvable) {
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
    const Answer answer = enumerate(lcp);
    ASSERT_EQ(answer.claim, Claim::kSolved) << "trial " << trial << "\n" << lcp.M << "\n" << lcp.q.transpose();
    ASSERT_LE(testing::relative_residual(lcp, answer.z), 1e-14) << "trial " << trial;
  }
}

// u >= 0 with M'u <= 0 and q'u < 0 leaves no z >= 0 with M z + q >= 0.
TEST(EnumerationTest, NeverSolvesAnInfeasibleProblem) {
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
    ASSERT_EQ(enumerate({M, q}).claim, Claim::kUnsolvable) << "trial " << trial;
  }
}

TEST(EnumerationTest, IsExactWhereDoubleArithmeticIsNot) {
  // With e = 2^-40: det M = e^2, q = -M (1, 1), and each single variable solves its own row but leaves the other w at
  // -e^2, which double arithmetic rounds to zero.
  const double e = 0x1p-40;
  const Answer answer = enumerate({testing::matrix_of(2, {1, 1 + e, 1 - e, 1}), testing::vector_of({-2 - e, e - 2})});
  ASSERT_EQ(answer.claim, Claim::kSolved);
  EXPECT_EQ(answer.z, testing::vector_of({1, 1}));
}

TEST(EnumerationTest, SpansTheRangeOfDoubles) {
  const Answer tiny = enumerate({testing::matrix_of(1, {1e-290}), testing::vector_of({-1})});
  ASSERT_EQ(tiny.claim, Claim::kSolved);
  EXPECT_DOUBLE_EQ(tiny.z(0), 1e290);

  const Answer overflow = enumerate({testing::matrix_of(1, {1e-200}), testing::vector_of({-1e200})});
  EXPECT_EQ(overflow.claim, Claim::kNumericalFailure);

  const Matrix denormal = 0x1p-1060 * testing::tridiagonal(6, 4, -1);
  const Answer ones = enumerate({denormal, -denormal * testing::ones(6)});
  ASSERT_EQ(ones.claim, Claim::kSolved);
  EXPECT_EQ(ones.z, testing::ones(6));
}

TEST(EnumerationTest, RoundsEachEntryToNearest) {
  for (const double denominator : {3.0, 7.0, 10.0, 49.0, 1e17, 0x1.fffffffffffffp+3}) {
    const Answer answer = enumerate({testing::matrix_of(1, {denominator}), testing::vector_of({-1})});
    ASSERT_EQ(answer.claim, Claim::kSolved);
    EXPECT_EQ(answer.z(0), 1 / denominator);  // IEEE division rounds to nearest
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
TEST(EnumerationTest, HasRoomForTheLargestDeterminant) {
  const Matrix H = hadamard_matrix_12();
  ASSERT_EQ(H * H.transpose(), 12 * Matrix::Identity(12, 12));
  const double odd = 0x1p53 - 1;
  const Answer answer = enumerate({odd * H, -odd * Vector::Unit(12, 0)});
  ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_EQ(answer.counters.iterations, 1 << 12);
  EXPECT_EQ(answer.z, Vector::Constant(12, 1.0 / 12));  // H' e_0 / 12
}

// What is exact is M after it was rounded; the contact problem may be solvable where that M is not.
TEST(EnumerationTest, ClaimsNothingUnsolvableOfAContactProblem) {
  ContactProblem crushed;  // a ball between two plates that close in
  crushed.v = testing::vector_of({0, 1});
  crushed.N = Matrix(testing::matrix_of(2, {1, -1, -1, -1}));
  crushed.D = Matrix(2, 0);
  crushed.edges = {0, 0};
  crushed.mu = Vector::Zero(2);
  crushed.inertia = InverseInertia{testing::matrix_of(2, {1, 0, 0, 0})};
  const Answer answer = enumerate(Problem("crushed", crushed));
  EXPECT_EQ(answer.claim, Claim::kNumericalFailure);
  EXPECT_NE(answer.detail.find("contact problem"), std::string::npos);
}

// Nor need the exact solution of that M be one of the contacts: these two are off by more than max|q|.
TEST(EnumerationTest, ClaimsNothingSolvedThatTheContactsAreNot) {
  const auto set = open_set("paper/monotone/exp3");
  for (const std::int64_t trial : {3040, 3985}) {
    const Answer answer = enumerate(set->generate(1, trial));
    EXPECT_EQ(answer.claim, Claim::kNumericalFailure) << trial;
    EXPECT_NE(answer.detail.find("contact problem"), std::string::npos);
  }
  EXPECT_EQ(enumerate(set->generate(1, 0)).claim, Claim::kSolved);
}

TEST(EnumerationTest, RefusesMoreThanTwelve) {
  const Answer answer = enumerate({Matrix::Identity(13, 13), -testing::ones(13)});
  EXPECT_EQ(answer.claim, Claim::kUnsupported);
  EXPECT_NE(answer.detail.find("12"), std::string::npos);
}

TEST(EnumerationTest, CountsSupportsAndObeysItsTimeLimit) {
  const Lcp last_support{Matrix::Identity(10, 10), -testing::ones(10)};
  EXPECT_EQ(enumerate(last_support).counters.iterations, 1 << 10);
  EXPECT_EQ(enumerate(Problem("case", last_support), 0.0).claim, Claim::kTimeLimit);
}

/// 12 rows of doubles that span 2,000 bits; the solution has its support among the first three.
Problem of_2000_bits() {
  Uniform uniform(3);
  Matrix M = Matrix::Identity(12, 12);
  for (Index j = 0; j < 12; ++j) {
    for (Index i = 0; i < 12; ++i) {
      if (i != j) M(i, j) = (i + j) % 2 == 0 ? 1e300 * (1 + std::fabs(uniform())) : 1e-300 * uniform();
    }
  }
  Vector q = Vector::Constant(12, 1e300);
  q.head(3).setConstant(-1);
  return {"2,000 bits", Lcp{M, q}};
}

std::vector<Problem> problems_that_end_in_all_ways() {
  std::vector<Problem> problems;
  for (const TextbookLcp& textbook : testing::textbook_lcps()) {
    if (textbook.lcp.size() <= 12) problems.emplace_back(textbook.name, textbook.lcp);
  }
  const auto contacts = open_set("paper/monotone/exp1{nc_max=12}");
  for (std::int64_t trial = 0; trial < 30; ++trial) problems.push_back(contacts->generate(1, trial));
  const auto singular_inertia = open_set("paper/monotone/exp3");
  for (const std::int64_t trial : {0, 3040}) problems.push_back(singular_inertia->generate(1, trial));
  problems.emplace_back("singular", Lcp{Matrix::Ones(7, 7), -testing::ones(7)});
  problems.emplace_back("singular, unsolvable", Lcp{Matrix::Zero(6, 6), -testing::ones(6)});
  problems.emplace_back("overflow", Lcp{testing::matrix_of(1, {1e-200}), testing::vector_of({-1e200})});
  problems.emplace_back("largest determinant", Lcp{hadamard_matrix_12(), -Vector::Unit(12, 0)});
  problems.push_back(of_2000_bits());
  return problems;
}

// From the first solve after load() on.
TEST(EnumerationTest, AllocatesNothingInASolveHoweverItEnds) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "allocations cannot be counted in this build";
  const auto solver = lcpbench_solver_enumeration().make({});
  for (const Problem& problem : problems_that_end_in_all_ways()) {
    solver->load(problem);
    Answer answer;
    answer.reserve(problem);
    for (const double time_limit_s : {0.0, std::numeric_limits<double>::infinity()}) {
      SolveRequest request;
      request.time_limit_s = time_limit_s;
      EXPECT_EQ(testing::count_allocations([&] { solver->solve(request, answer); }), 0)
          << problem.name() << " within " << time_limit_s << " s: " << answer.detail;
    }
    EXPECT_NE(answer.claim, Claim::kTimeLimit) << problem.name();
  }
}

TEST(EnumerationTest, SolvesWhatSpans2000Bits) {
  const Problem problem = of_2000_bits();
  const Answer answer = enumerate(problem);
  ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_LE(answer.counters.iterations, 8);
  EXPECT_LE(testing::relative_residual(problem.lcp(), answer.z), 1e-14);
}

}  // namespace
}  // namespace lcpbench
