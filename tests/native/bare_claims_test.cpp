// What native solvers do with bare LCPs (q, M): blocks, games, proofs. tests/attack has small problems of every kind.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/answer/exact_sum.h"
#include "core/answer/farkas.h"
#include "core/answer/lcp_error.h"
#include "core/registry.h"
#include "core/spec.h"
#include "core/timed_solve.h"
#include "generators/sets.h"
#include "native/answer_test/bare_lcp_test.h"
#include "native/proofs/farkas_search.h"
#include "study/evaluation/evaluation.h"
#include "tests/support/solving.h"

namespace lcpbench::bare_claims_test {
namespace {

constexpr double kForever = std::numeric_limits<double>::infinity();

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

// --- recorded failures ---

const Lcp kInfeasibleByAnUlp = lcp_of(3, {0, -1, 2, 1, 0, 0, -2, 0, 0}, {0, -2.0000000000000004, 4});
const Lcp kFeasibleButUnsolvable = lcp_of(2, {0, 3, 0, 1}, {-3, -0.9999999999});

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
  EXPECT_TRUE(proves_unsolvable(lcp, answer.farkas));
  EXPECT_EQ(answer.detail.find("block of 2 rows, from row 0: "), 0U) << answer.detail;
}

/// M has rank 1, so that not all unknowns that were split in two can be eliminated.
TEST(BareClaimsTest, AutoSolvesWhereFreeUnknownsCannotBeEliminated) {
  const Vector a{{1, -2, 2, 3, -3, -2, -1, 2}};
  const Problem problem("rank 1", Lcp{a * a.transpose(), Vector{{-10, 20, -20, -30, 30, 20, 13, -20}}});
  const Answer answer = solve("auto", problem);
  EXPECT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_LE(Evaluator(problem).errors(answer).backward_row_norm, 1e-12);  // rounding of sums of eight numbers up to 90
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
    for (const char* engine : {"dense", "kernel"}) {
      const Answer covered = solve("lemke{cover=all,engine=" + std::string(engine) + "}", problem);
      EXPECT_EQ(covered.claim, Claim::kSolved) << seed << ": " << engine;
    }
  }
  EXPECT_LT(by_lemke, 10);
}

/// Two players with costs from 1 to 1000; where scaled, q is not -1 in all rows, and the rows are shuffled.
Lcp bimatrix_game(Index choices, std::uint64_t seed, bool scaled) {
  std::mt19937_64 random(seed);
  const Index n = 2 * choices;
  Lcp lcp{Matrix::Zero(n, n), Vector::Constant(n, -1)};
  for (Index i = 0; i < choices; ++i) {
    for (Index j = 0; j < choices; ++j) {
      lcp.M(i, choices + j) = static_cast<double>(1 + random() % 1000);
      lcp.M(choices + i, j) = static_cast<double>(1 + random() % 1000);
    }
  }
  if (!scaled) return lcp;
  for (double& each : lcp.q) each = -static_cast<double>(1 + random() % 8);
  std::vector<Index> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), Index{0});
  std::shuffle(order.begin(), order.end(), random);
  return {lcp.M(order, order), lcp.q(order)};
}

/// Each has an equilibrium [Nash 1951]; Lemke's covering vector, which has no part in the game, misses most.
TEST(BareClaimsTest, AutoSolvesEveryBimatrixGame) {
  for (const Index choices : {1, 2, 8, 15, 30}) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const Problem problem("game", bimatrix_game(choices, seed, seed % 2 == 0));
      const Answer answer = solve("auto", problem);
      EXPECT_EQ(answer.claim, Claim::kSolved) << choices << " " << seed << ": " << answer.detail;
      EXPECT_LE(Evaluator(problem).errors(answer).backward_row_norm, 1e-9) << choices << " " << seed;
    }
  }
}

/// Equal costs tie everywhere.
TEST(BareClaimsTest, AutoSolvesGamesWhoseCostsTie) {
  Lcp lcp = bimatrix_game(12, 1, false);
  for (double& each : lcp.M.reshaped()) each = each == 0 ? 0 : 1 + std::fmod(each, 2.0);
  EXPECT_EQ(solve("auto", Problem("game", lcp)).claim, Claim::kSolved);
}

// --- what is measured row by row ---

/// z_0 <= 1 and z_0 >= 2, with multipliers as large as one likes.
const Lcp kContradiction = lcp_of(3, {0, 1, -1, -1, 0, 0, 1, 0, 0}, {0, 1, -2});

TEST(BareClaimsTest, HugeMultipliersSolveNothing) {
  const Problem problem("contradiction", kContradiction);
  for (const std::string& solver : testing::native_solvers()) {
    EXPECT_NE(solve(solver, problem).claim, Claim::kSolved) << solver;
  }
  EXPECT_EQ(solve("auto", problem).claim, Claim::kUnsolvable);
}

// The entries of z are powers of two from 2^-40 to 2^40.
TEST(BareClaimsTest, AutoFindsEntriesOfEverySize) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) {
    const Answer answer = solve("auto", open_set("hard/scaling/columns")->generate(seed, 0));
    ASSERT_EQ(answer.claim, Claim::kSolved) << seed << ": " << answer.detail;
    for (const double z : answer.z) EXPECT_NEAR(z / std::exp2(std::round(std::log2(z))), 1, 1e-9) << seed;
  }
}

// --- the parts ---

TEST(BareLcpTest, BoundsTheErrorOfTheVerdict) {
  std::mt19937_64 random(31);
  const auto number = [&](int bits) {
    const int exponent = static_cast<int>(random() % static_cast<std::uint64_t>(2 * bits + 1)) - bits;
    const double digits = static_cast<double>(random() % 2001) / 1000 - 1;
    return std::ldexp(digits, exponent);
  };
  for (int trial = 0; trial < 400; ++trial) {
    const Index n = 1 + trial % 6;
    const int bits = trial % 4 == 0 ? 0 : trial % 4 == 1 ? 20 : trial % 4 == 2 ? 300 : 900;
    Lcp lcp{Matrix(n, n), Vector(n)};
    for (double& x : lcp.M.reshaped()) x = random() % 3 == 0 ? 0 : number(bits);
    for (double& x : lcp.q) x = number(bits);
    Vector z(n);
    for (double& x : z) x = random() % 2 == 0 ? 0 : std::abs(number(bits));
    BareLcpTest test;
    test.load(lcp);
    const double exact = to_double(lcp_error<Quad>(lcp, {z.begin(), z.end()}).backward);
    EXPECT_GE(test.backward_error(z), exact * (1 - 1e-14)) << trial;
    if (std::isfinite(exact)) {
      EXPECT_LE(test.backward_error(z), exact * (1 + 1e-13) + 1e-13) << trial;
    }
  }
}

TEST(BareLcpTest, TellsWhatContradictsItselfFromWhatIsNearASolution) {
  BareLcpTest test;
  test.load(kContradiction);
  EXPECT_NEAR(test.backward_error(Vector{{1.5, 1e7, 1e7}}), 0.2, 1e-14);
  EXPECT_EQ(test.backward_error(Vector{{1.5, -1, 0}}), std::numeric_limits<double>::infinity());
  // z_0 <= 1 and z_0 >= 1 + 1e-7, which passes, and is disproved.
  const Lcp nearly = lcp_of(3, {0, 1, -1, -1, 0, 0, 1, 0, 0}, {0, 1, -1.0000001});
  test.load(nearly);
  const Vector z{{1.00000005, 1, 1}};
  EXPECT_LE(test.backward_error(z), kClaimedBackwardError);
  ASSERT_TRUE(test.disproves(z, kForever));
  EXPECT_TRUE(proves_unsolvable(nearly, test.proof()));
  // z_0 = 1, known to seven digits: the basis has a solution near by.
  const Lcp regular = lcp_of(2, {1, 0, 0, 1}, {-1, 1});
  test.load(regular);
  const Vector rounded{{1.0000001, 0}};
  EXPECT_LE(test.backward_error(rounded), kClaimedBackwardError);
  EXPECT_FALSE(test.disproves(rounded, kForever));
}

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
  sum.clear();
  constexpr double kOdd = 1 - 0x1p-53;
  sum.add(kOdd, -kOdd, kOdd);  // -1 + 3 2^-53 - 3 2^-106 + 2^-159
  sum.add(1, 1);
  sum.add(-3, 0x1p-53);
  sum.add(3, 0x1p-53, 0x1p-53);
  EXPECT_TRUE(sum.value() == 0x1p-159);
  sum.add(-0x1p-53, 0x1p-53, 0x1p-53);
  EXPECT_EQ(sum.sign(), 0);
  sum.add(-0x1p-1074, 0x1p-1074, 0x1p-1074);
  EXPECT_EQ(sum.sign(), -1);
  EXPECT_TRUE(sum.value() * Quad{0x1p1000} * Quad{0x1p1000} * Quad{0x1p1000} * Quad{0x1p222} == -1);
  sum.add(0x1p1023, 0x1p1023, 0x1p1023);
  EXPECT_TRUE(sum.value() / Quad{0x1p1023} / Quad{0x1p1023} / Quad{0x1p1023} == 1);
}

TEST(FarkasSearchTest, FindsAProofWhoseBasisIsSingular) {
  FarkasSearch search;
  search.load(kInfeasibleByAnUlp);
  ASSERT_TRUE(search.find({1, 1, 1}, kForever));
  EXPECT_TRUE(proves_unsolvable(kInfeasibleByAnUlp, search.proof()));
  search.load(kFeasibleButUnsolvable);
  EXPECT_FALSE(search.find({1, 1}, kForever));
  EXPECT_FALSE(proves_unsolvable(kInfeasibleByAnUlp, Vector::Ones(3)));
  Vector not_a_number = Vector::Ones(3);
  not_a_number(1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(proves_unsolvable(kInfeasibleByAnUlp, not_a_number));
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

}  // namespace
}  // namespace lcpbench::bare_claims_test
