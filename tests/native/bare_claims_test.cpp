// What native solvers claim of bare LCPs (q, M) holds exactly: recorded failures, and small problems against
// enumeration.
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "core/spec.h"
#include "core/timed_solve.h"
#include "generators/sets.h"
#include "native/answer_test/bare_lcp_test.h"
#include "native/lcp_ladder/covering_lemke.h"
#include "native/proofs/exact_sum.h"
#include "native/proofs/farkas_search.h"
#include "study/evaluation/evaluation.h"
#include "tests/support/enumeration.h"

namespace lcpbench::bare_claims_test {
namespace {

constexpr double kForever = std::numeric_limits<double>::infinity();

const std::vector<std::string> kSolvers{"auto",        "lemke",              "murty",
                                        "primal_dual", "principal_pivoting", "regularized"};

Lcp lcp_of(Index n, const std::vector<double>& M_by_rows, const std::vector<double>& q) {
  Lcp lcp{Matrix(n, n), Vector(n)};
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) lcp.M(i, j) = M_by_rows[static_cast<std::size_t>(i * n + j)];
    lcp.q(i) = q[static_cast<std::size_t>(i)];
  }
  return lcp;
}

Answer solve(const std::string& solver, const Problem& problem, double time_limit_s = 10) {
  const auto made = make_solver(parse_spec(solver));
  Answer answer;
  made->load(problem);
  made->solve({.time_limit_s = time_limit_s}, answer);
  return answer;
}

/// That no claim contradicts the truth, which enumeration knows.
void expect_true_claims(const Lcp& lcp, const std::string& what) {
  const bool solvable = testing::enumerate(lcp).solvable;
  const Problem problem("small", lcp);
  Evaluator evaluator(problem);
  for (const std::string& solver : kSolvers) {
    const Answer answer = solve(solver, problem);
    if (answer.claim == Claim::kSolved) {
      EXPECT_TRUE(solvable) << solver << " solved what has no solution: " << what;
      EXPECT_TRUE(evaluator.errors(answer).solved) << solver << ": " << what;
    } else if (answer.claim == Claim::kUnsolvable) {
      EXPECT_FALSE(solvable) << solver << ": " << what << ", " << answer.detail;
      if (answer.farkas.size() > 0) EXPECT_TRUE(is_farkas_vector(lcp, answer.farkas)) << solver << ": " << what;
    }
  }
}

// --- recorded failures ---

const Lcp kInfeasibleByAnUlp = lcp_of(3, {0, -1, 2, 1, 0, 0, -2, 0, 0}, {0, -2.0000000000000004, 4});
const Lcp kFeasibleButUnsolvable = lcp_of(2, {0, 3, 0, 1}, {-3, -0.9999999999});

TEST(BareClaimsTest, RaysOnContactsWithRegularInertiaAreFailures) {
  for (const char* name : {"paper/copositive/exp5-1e10{redundancy=combination}", "paper/copositive/exp2"}) {
    const auto set = open_set(name);
    for (std::int64_t trial = 0; trial < 40; ++trial) {
      const Problem problem = set->generate(3, trial);
      if (problem.size() > 150) continue;
      for (const char* solver : {"lemke", "principal_pivoting"}) {
        EXPECT_NE(solve(solver, problem, 1).claim, Claim::kUnsolvable) << solver << " " << name << " " << trial;
      }
    }
  }
}

// --- blocks ---

/// Rows 0 and 1 are `corner`, the others the identity.
Lcp beside_identity(Index n, const Matrix& corner, const Vector& q) {
  Lcp lcp{Matrix::Identity(n, n), Vector::Constant(n, -1)};
  lcp.M.topLeftCorner(2, 2) = corner;
  lcp.q.head(2) = q;
  return lcp;
}

TEST(BareClaimsTest, AutoSolvesEveryBlockByItself) {
  for (const Index n : {12, 13, 60}) {
    const Lcp lcp = beside_identity(n, Matrix{{0, 1}, {0, 0}}, Vector{{-1, 0}});
    const Answer answer = solve("auto", Problem("blocks", lcp));
    EXPECT_EQ(answer.claim, Claim::kSolved) << n << ": " << answer.detail;
    EXPECT_EQ(Evaluator(Problem("blocks", lcp)).errors(answer).backward_row_norm, 0) << n;
    EXPECT_EQ(answer.z.tail(n - 1), Vector::Ones(n - 1)) << n;
  }
}

TEST(BareClaimsTest, AutoProvesThatABlockHasNoSolution) {
  const Lcp lcp = beside_identity(13, Matrix{{0, 1}, {0, 0}}, Vector{{-1, -1}});
  const Answer answer = solve("auto", Problem("blocks", lcp));
  EXPECT_EQ(answer.claim, Claim::kUnsolvable) << answer.detail;
  EXPECT_TRUE(is_farkas_vector(lcp, answer.farkas));
  EXPECT_EQ(answer.detail.find("block of 2 rows, from row 0: "), 0U) << answer.detail;
}

// --- small problems of every kind ---

class Nasty {
 public:
  explicit Nasty(std::uint64_t seed) : random_(seed) {}

  Lcp next() {
    const Index n = integer(1, 7);
    Lcp lcp{Matrix::Zero(n, n), Vector::Zero(n)};
    const bool skew = integer(0, 3) == 0;
    const bool wide = integer(0, 3) == 0;
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j < n; ++j) lcp.M(i, j) = integer(0, 2) > 0 ? static_cast<double>(integer(-2, 2)) : 0.0;
      lcp.q(i) = static_cast<double>(integer(-3, 3));
    }
    if (skew) lcp.M = (lcp.M - lcp.M.transpose()).eval();
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j < n; ++j) lcp.M(i, j) = disturbed(lcp.M(i, j), wide);
      lcp.q(i) = disturbed(lcp.q(i), wide);
    }
    return lcp;
  }

 private:
  Index integer(Index first, Index last) {
    return first + static_cast<Index>(random_() % static_cast<std::uint64_t>(last - first + 1));
  }
  double disturbed(double x, bool wide) {
    if (wide && integer(0, 2) == 0) return std::ldexp(x, static_cast<int>(integer(-900, 900)));
    if (integer(0, 3) > 0 || x == 0) return x;
    return std::nextafter(x, integer(0, 1) == 0 ? 0.0 : 4 * x);
  }

  std::mt19937_64 random_;
};

TEST(BareClaimsTest, TheBoundIsThatOfTheVerdict) {
  Nasty nasty(73);
  std::mt19937_64 random(73);
  for (int trial = 0; trial < 2000; ++trial) {
    const Lcp lcp = nasty.next();
    BareLcpTest test;
    test.load(lcp);
    Answer answer;
    answer.z.resize(lcp.size());
    for (double& z : answer.z) z = std::ldexp(static_cast<double>(random() % 7), -static_cast<int>(random() % 40));
    const double judged = Evaluator(Problem("nasty", lcp)).errors(answer).backward_row_norm;
    EXPECT_NEAR(test.backward_error(answer.z), judged, 1e-14 + 1e-13 * judged) << trial;
    EXPECT_GE(test.backward_error(answer.z), judged * (1 - 0x1p-50)) << trial;
  }
}

TEST(BareClaimsTest, AgreeWithEnumerationOnNastyProblems) {
  Nasty nasty(20261121);
  for (int trial = 0; trial < 600; ++trial) {
    expect_true_claims(nasty.next(), "trial " + std::to_string(trial));
    if (HasFailure()) return;
  }
}

// --- what auto solves beside ---

/// A game of two groups of players: each plays against the others with payoffs of its own. [Howson 1972]
Lcp game(std::uint64_t seed) {
  constexpr Index kPlayers = 8, kChoices = 4, kAll = kPlayers * kChoices, kSize = kAll + kPlayers;
  std::mt19937_64 random(seed);
  Lcp lcp{Matrix::Zero(kSize, kSize), Vector::Zero(kSize)};
  for (Index i = 0; i < kAll; ++i) {
    for (Index j = 0; j < kAll; ++j) {
      const bool same = (i < kAll / 2) == (j < kAll / 2);
      lcp.M(i, j) = same ? 1.0 : static_cast<double>(1 + random() % 250);
    }
    lcp.M(i, kAll + i / kChoices) = -1;
    lcp.M(kAll + i / kChoices, i) = 1;
  }
  lcp.q.tail(kPlayers).setConstant(-1);
  return lcp;
}

TEST(BareClaimsTest, AutoSolvesGamesThatTheRulesOfLemkeDoNot) {
  int by_lemke = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Problem problem("game", game(seed));
    const Answer answer = solve("auto", problem);
    EXPECT_EQ(answer.claim, Claim::kSolved) << seed << ": " << answer.detail;
    EXPECT_TRUE(Evaluator(problem).errors(answer).solved) << seed;
    by_lemke += solve("lemke", problem).claim == Claim::kSolved;
  }
  EXPECT_LT(by_lemke, 10);
}

// --- the parts ---

TEST(ExactSumTest, KnowsTheSignWhereEverythingCancels) {
  ExactSum sum;
  EXPECT_EQ(sum.sign(), 0);
  sum.add(1e300, 1e300);
  sum.add(-1e-300, 1e-300);
  EXPECT_EQ(sum.sign(), 1);
  sum.add(-1e300, 1e300);
  EXPECT_EQ(sum.sign(), -1);
  sum.add(1e-300, 1e-300);
  EXPECT_EQ(sum.sign(), 0);
  sum.add(0x1p-1074, 0x1p-1074);
  EXPECT_EQ(sum.sign(), 1);
  sum.add(-0x1p-1074, 0x1p-1073);
  EXPECT_EQ(sum.sign(), -1);
  sum.clear();
  sum.add(1 + 0x1p-52, 1 + 0x1p-52);
  sum.add(-1, 1 + 0x1p-51);
  EXPECT_EQ(sum.sign(), 1);  // 2^-104
  sum.add(-0x1p-52, 0x1p-52);
  EXPECT_EQ(sum.sign(), 0);
  for (int k = 0; k < 100; ++k) sum.add(std::numeric_limits<double>::max(), -std::numeric_limits<double>::max());
  EXPECT_EQ(sum.sign(), -1);
}

TEST(FarkasSearchTest, FindsAProofWhoseBasisIsSingular) {
  FarkasSearch search;
  search.load(kInfeasibleByAnUlp);
  ASSERT_TRUE(search.find({1, 1, 1}, kForever));
  EXPECT_TRUE(is_farkas_vector(kInfeasibleByAnUlp, search.proof()));
  search.load(kFeasibleButUnsolvable);
  EXPECT_FALSE(search.find({1, 1}, kForever));
  EXPECT_FALSE(is_farkas_vector(kInfeasibleByAnUlp, Vector::Ones(3)));
  Vector not_a_number = Vector::Ones(3);
  not_a_number(1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_farkas_vector(kInfeasibleByAnUlp, not_a_number));
}

TEST(FarkasSearchTest, FindsProofsOfEveryScale) {
  for (const double scale : {1e-300, 1e-100, 1.0, 1e100, 1e300}) {
    const Lcp lcp = lcp_of(2, {scale, -1, 0, -1}, {1, -1});
    FarkasSearch search;
    search.load(lcp);
    EXPECT_TRUE(search.find({1, 1}, kForever)) << scale;
  }
}

// Without the 1e-13 u = (1, 1) would have M'u = 0, but q'u is no clear proof. In the second all q_i u_i underflow.
TEST(FarkasSearchTest, TermsThatUnderflowAreNoNearProof) {
  for (const double scale : {1.0, 1e200}) {
    const double less = -(1 - 1e-13) * scale, of_q = scale > 1 ? 1e-150 : 1;
    const Lcp lcp = lcp_of(2, {scale, less, less, scale}, {-of_q, of_q * (1 - 1e-6)});
    FarkasSearch search;
    search.load(lcp);
    EXPECT_FALSE(search.find({1, 1}, kForever)) << scale;
    EXPECT_FALSE(search.found_near_proof()) << scale;
  }
}

// Problems of any order may follow each other; above 300 rows there is no memory for 113 bits.
TEST(CoveringLemkeTest, SolvesSmallProblemsAfterLargeOnes) {
  CoveringLemke method;
  for (const Index rows : {350, 2, 200, 400, 250}) {
    const Lcp lcp{.M = Matrix::Identity(rows, rows), .q = Vector::Constant(rows, -1)};
    method.load(lcp);
    if (rows > CoveringLemke::kLargestQuad) continue;
    Vector z(rows);
    const CoveringLemke::Limits limits{.deadline_s = kForever, .pivots = 4 * rows};
    ASSERT_EQ(method.run<Quad>(CoveringLemke::Cover::kAll, limits, z), CoveringLemke::End::kSolved) << rows;
    EXPECT_EQ(z, Vector::Ones(rows)) << rows;
  }
}

}  // namespace
}  // namespace lcpbench::bare_claims_test
