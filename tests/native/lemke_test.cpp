#include "native/lemke/lemke.h"

#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "generators/sets.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench {
SolverDefinition lcpbench_solver_lemke();
}

namespace lcpbench::lemke_test {
namespace {

using testing::circulant;
using testing::klee_minty;
using testing::matrix_of;
using testing::murty_matrix;
using testing::ones;
using testing::plant;
using testing::relative_residual;
using testing::TextbookLcp;
using testing::tridiagonal;
using testing::Uniform;
using testing::vector_of;

struct Recorded {
  Answer answer;
  std::vector<LemkePivot> pivots;
};

Recorded run(const LemkeSettings& settings, const Problem& problem, IsaLevel level = isa_level()) {
  Lemke solver(settings, level);
  Recorded result;
  solver.record_pivots(&result.pivots);
  solver.load(problem);
  solver.solve({}, result.answer);
  return result;
}

Problem bare(Matrix M, Vector q) { return Problem("test", Lcp{std::move(M), std::move(q)}); }

LemkeSettings with(LemkeEngine engine) {
  LemkeSettings settings;
  settings.engine = engine;
  return settings;
}

std::vector<IsaLevel> levels_of_this_machine() {
  std::vector<IsaLevel> levels;
  for (const IsaLevel level : {IsaLevel::kBaseline, IsaLevel::kAvx2, IsaLevel::kAvx512}) {
    if (level <= best_isa_level()) levels.push_back(level);
  }
  return levels;
}

/// Largest error of z where z is unique and well determined.
double error(const Vector& z, const Vector& expected) {
  return (z - expected).cwiseAbs().maxCoeff() / (1 + expected.cwiseAbs().maxCoeff());
}

class LemkeTest : public ::testing::TestWithParam<LemkeEngine> {
 protected:
  LemkeSettings settings() const { return with(GetParam()); }
  Recorded solve(Matrix M, Vector q) const { return run(settings(), bare(std::move(M), std::move(q))); }
};

INSTANTIATE_TEST_SUITE_P(
    Engines, LemkeTest, ::testing::Values(LemkeEngine::kDense, LemkeEngine::kKernel),
    [](const auto& engine) { return std::string(engine.param == LemkeEngine::kDense ? "Dense" : "Kernel"); });

TEST_P(LemkeTest, SolvesWhatTheoryPromises) {
  // Lemke's method processes monotone problems: it solves them, or ends on a ray when there is no solution.
  for (const TextbookLcp& example : testing::textbook_lcps()) {
    if (!example.monotone) continue;
    SCOPED_TRACE(example.name + ", " + example.source);
    const Recorded result = run(settings(), Problem(example.name, example.lcp));
    ASSERT_EQ(result.answer.claim, example.solvable ? Claim::kSolved : Claim::kUnsolvable);
    if (!example.solvable) {
      EXPECT_EQ(result.answer.z.cwiseAbs().maxCoeff(), 0) << "an answer that is none must not look like one";
      continue;
    }
    EXPECT_LE(relative_residual(example.lcp, result.answer.z), 1e-10);
    if (example.unique && example.name != "hilbert_8") {
      EXPECT_LE(error(result.answer.z, example.z), 1e-10);
    }
  }
}

TEST_P(LemkeTest, ClaimsNothingUntrue) {
  for (const TextbookLcp& example : testing::textbook_lcps()) {
    SCOPED_TRACE(example.name + ", " + example.source);
    const Recorded result = run(settings(), Problem(example.name, example.lcp));
    if (result.answer.claim == Claim::kSolved) {
      EXPECT_LE(relative_residual(example.lcp, result.answer.z), 1e-10);
    }
  }
}

TEST_P(LemkeTest, EndsOnARayWhereTheMethodMust) {
  // Copositive but not copositive-plus, and not copositive: no row blocks the first entering variable although both
  // problems have a solution, (2, 2) and (1, 1). [Cottle, Pang, Stone 1992, 4.4; Kojima, Saigal 1979]
  // The published method calls that unsolvable; the solver that tests its answers knows that a ray proves nothing.
  for (const Recorded& result : {solve(matrix_of(2, {0, 1, 1, 0}), vector_of({-2, -2})),
                                 solve(matrix_of(2, {-1, 2, 2, -1}), vector_of({-1, -1}))}) {
    const bool tests = settings().engine == LemkeEngine::kKernel;
    EXPECT_EQ(result.answer.claim, tests ? Claim::kNumericalFailure : Claim::kUnsolvable);
    EXPECT_EQ(result.answer.detail, "ray");
  }
}

TEST_P(LemkeTest, CyclingExamplesEnd) {
  // With ties to the first index both cycle for ever. [Kostreva 1979; Morris 2002]
  const Recorded kostreva = solve(circulant(3, 1, 2, 0), -ones(3));
  ASSERT_EQ(kostreva.answer.claim, Claim::kSolved);
  EXPECT_LE(error(kostreva.answer.z, ones(3) / 3), 1e-14);
  EXPECT_LE(kostreva.pivots.size(), 8U);
  const Recorded morris = solve(circulant(5, 1, 2, 0), -ones(5));
  ASSERT_EQ(morris.answer.claim, Claim::kSolved);
  EXPECT_LE(error(morris.answer.z, ones(5) / 3), 1e-14);
  EXPECT_LE(morris.pivots.size(), 40U);
}

TEST_P(LemkeTest, TiesGoToTheLargestPivotAndTheArtificialVariable) {
  // Murty's matrix with q = -e: every first ratio ties, and the rule leaves by the artificial variable at once where
  // the lexicographic rule takes 2^n pivots. Without ties there is no choice, and it is 2^n - 1 after the first
  // exchange.
  const Recorded tied = solve(murty_matrix(8), -ones(8));
  EXPECT_EQ(tied.pivots, (std::vector<LemkePivot>{{8, 16}}));
  Vector untied(8);
  for (Index i = 0; i < 8; ++i) untied(i) = -(512.0 - std::ldexp(1.0, static_cast<int>(8 - i)));
  const Recorded exponential = solve(murty_matrix(8), untied);
  EXPECT_EQ(exponential.answer.claim, Claim::kSolved);
  EXPECT_EQ(exponential.pivots.size(), 255U);
  // z_0 enters for w_0; w_1 and w_2 block at 1, w_2 with twice the pivot.
  const Recorded largest = solve(matrix_of(3, {1, 0, 0, -1, 1, 0, -2, 0, 1}), vector_of({-4, 1, 2}));
  ASSERT_FALSE(largest.pivots.empty());
  EXPECT_EQ(largest.pivots.front(), (LemkePivot{3, 2}));
  // Equal pivots: the lowest number.
  const Recorded lowest = solve(matrix_of(3, {1, 0, 0, -1, 1, 0, -1, 0, 1}), vector_of({-4, 1, 1}));
  ASSERT_FALSE(lowest.pivots.empty());
  EXPECT_EQ(lowest.pivots.front(), (LemkePivot{3, 1}));
  // The artificial variable blocks at 1 too, with the smallest pivot, and is preferred.
  const Recorded artificial = solve(matrix_of(3, {1, 0, 0, -1, 1, 0, -2, 0, 1}), vector_of({-1, 1, 2}));
  EXPECT_EQ(artificial.pivots, (std::vector<LemkePivot>{{3, 6}}));
}

TEST_P(LemkeTest, SolvesKleeMinty) {
  const Lcp lcp = klee_minty(5);
  const Recorded result = solve(lcp.M, lcp.q);
  ASSERT_EQ(result.answer.claim, Claim::kSolved);
  Vector expected = Vector::Zero(5);
  expected(4) = 3125;
  EXPECT_LE(error(result.answer.z.head(5), expected), 1e-12);
}

TEST_P(LemkeTest, SmallestCases) {
  EXPECT_EQ(solve(Matrix(0, 0), Vector(0)).answer.claim, Claim::kSolved);
  const Recorded basic = solve(matrix_of(1, {2}), vector_of({-3}));
  EXPECT_EQ(basic.answer.claim, Claim::kSolved);
  EXPECT_EQ(basic.answer.z(0), 1.5);
  EXPECT_EQ(solve(matrix_of(1, {-1}), vector_of({-1})).answer.claim, Claim::kUnsolvable);
  EXPECT_EQ(solve(matrix_of(1, {0}), vector_of({-1})).answer.claim, Claim::kUnsolvable);
  // The answer 1e400 is no double, and a pivot of 1e-200 is below the tolerance: neither may be claimed solved.
  EXPECT_NE(solve(matrix_of(1, {1e-200}), vector_of({-1e200})).answer.claim, Claim::kSolved);
}

TEST_P(LemkeTest, ReturnsZeroAtOnceWhenQIsNonnegativeToTolerance) {
  LemkeSettings loose = settings();
  loose.test = LemkeAnswerTest::kNone;
  loose.zero_tolerance = 1e-3;
  const Recorded trivial = run(loose, bare(matrix_of(2, {-1, 5, 3, -7}), vector_of({0, -0.9e-3})));
  EXPECT_EQ(trivial.answer.claim, Claim::kSolved);
  EXPECT_EQ(trivial.answer.counters.pivots, 0);
  EXPECT_EQ(trivial.answer.counters.factorizations, 0);
  EXPECT_EQ(trivial.answer.z, Vector::Zero(2));
  const Recorded not_trivial = run(loose, bare(Matrix::Identity(2, 2), vector_of({0, -1.1e-3})));
  EXPECT_GT(not_trivial.answer.counters.pivots, 0);
}

TEST_P(LemkeTest, ReturnsZeroForZeroQWithoutAnyTolerance) {
  LemkeSettings strict = settings();
  strict.zero_tolerance = 0;
  const Recorded trivial = run(strict, bare(matrix_of(2, {2, 1, 1, 2}), vector_of({0, 1})));
  EXPECT_EQ(trivial.answer.claim, Claim::kSolved);
  EXPECT_EQ(trivial.answer.counters.pivots, 0);
}

TEST_P(LemkeTest, PivotToleranceBarsSmallerPivots) {
  LemkeSettings strict = settings();
  strict.pivot_tolerance = 0.1;
  EXPECT_EQ(run(strict, bare(matrix_of(1, {0.09}), vector_of({-1}))).answer.claim, Claim::kUnsolvable);
  EXPECT_EQ(run(strict, bare(matrix_of(1, {0.11}), vector_of({-1}))).answer.claim, Claim::kSolved);
}

TEST_P(LemkeTest, AnOverflowLeavesNothingBehind) {
  // With a slack of 2^600 w_1 leaves first, which takes w_2 to -2^600; its pivot of 2^-600 then makes the step
  // infinite. The same object afterwards solves another problem as a new one does.
  const Problem problem = bare(matrix_of(3, {0, 0, 0, -2, 0, 0, -1, -0x1p-600, 1}), vector_of({-0x1p601, 0x1p601, 0}));
  const Problem other = bare(tridiagonal(3, 4, -1), vector_of({-0x1p602, -0x1p603, -0x1p602}));
  LemkeSettings settings = this->settings();
  settings.test = LemkeAnswerTest::kNone;
  settings.pivot_tolerance = 0;
  settings.zero_tolerance = 0x1p600;
  const Answer expected = run(settings, other).answer;
  EXPECT_EQ(expected.claim, Claim::kSolved);
  Lemke solver(settings);
  solver.load(problem);
  Answer answer;
  solver.solve({}, answer);
  solver.load(other);
  solver.solve({}, answer);
  EXPECT_EQ(answer.claim, expected.claim);
  EXPECT_EQ(answer.z, expected.z);
}

TEST_P(LemkeTest, CapsAreThoseTheyAreNamedAfter) {
  // 2^12 - 1 pivots: over max(1000, 12^2), over min(1000, 50 * 12), over max(200, 3 * 12).
  Vector q(12);
  for (Index i = 0; i < 12; ++i) q(i) = -(8192.0 - std::ldexp(1.0, static_cast<int>(12 - i)));
  LemkeSettings capped = settings();
  EXPECT_EQ(run(capped, bare(murty_matrix(12), q)).answer.counters.pivots, 1000);
  capped.cap = LemkeCap::kLemke;
  EXPECT_EQ(run(capped, bare(murty_matrix(12), q)).answer.counters.pivots, 600);
  capped.cap = LemkeCap::k3n;
  EXPECT_EQ(run(capped, bare(murty_matrix(12), q)).answer.counters.pivots, 200);
}

TEST_P(LemkeTest, OneObjectServesProblemsOfAllSizes) {
  // Kernels of up to 150 rows outgrow the first layout, which has room for 64.
  Lemke solver(settings());
  Answer answer;
  for (const Index n : {3, 150, 1, 70, 150, 0, 20}) {
    const Problem problem = bare(tridiagonal(n, 4, -1), -ones(n));
    solver.load(problem);
    for (int repetition = 0; repetition < 2; ++repetition) {
      solver.solve({}, answer);
      ASSERT_EQ(answer.claim, Claim::kSolved) << "n = " << n;
      EXPECT_LE(relative_residual(problem.lcp(), answer.z), 1e-12) << "n = " << n;
      if (n > 0) {
        EXPECT_GE(answer.counters.pivots, n);
      }
    }
  }
}

TEST_P(LemkeTest, ContactProblemAndItsMatrixGiveTheSameAnswer) {
  // Columns formed from the factors, cone rows and columns included, are those of the whole matrix.
  const auto set = open_set("paper/copositive/exp1");
  int compared = 0;
  for (std::int64_t trial = 0; compared < 5; ++trial) {
    const Problem contact = set->generate(3, trial);
    if (contact.size() > 120) continue;
    ++compared;
    const Recorded factors = run(settings(), contact);
    const Recorded matrix = run(settings(), Problem("matrix", contact.lcp()));
    ASSERT_EQ(factors.answer.claim, Claim::kSolved) << "trial " << trial;
    EXPECT_EQ(factors.pivots, matrix.pivots) << "trial " << trial;
    EXPECT_LE(relative_residual(contact.lcp(), factors.answer.z), 1e-6) << "trial " << trial;
  }
}

TEST_P(LemkeTest, TakesTheMatrixThatItsSetAsksFor) {
  const std::string set = "paper/copositive/";
  const std::pair<std::string, std::string> cases[] = {{"exp1{nc_max=6}", "exp1{cone_diagonal=0.5,nc_max=6}"},
                                                       {"exp3{nc_max=6}", "exp3{inverse=plain,nc_max=6}"}};
  for (const auto& [usual, other] : cases) {
    LemkeSettings untested = settings();
    untested.test = LemkeAnswerTest::kNone;
    const auto usual_set = open_set(set + usual), other_set = open_set(set + other);
    int differ = 0;
    for (std::int64_t trial = 0; trial < 8; ++trial) {
      const Problem problem = other_set->generate(1, trial);
      EXPECT_EQ(problem.contact()->v, usual_set->generate(1, trial).contact()->v);
      const Vector z = run(untested, problem).answer.z;
      EXPECT_EQ(z, run(untested, Problem("matrix", problem.lcp())).answer.z) << other << " " << trial;
      differ += z != run(untested, usual_set->generate(1, trial)).answer.z ? 1 : 0;
    }
    EXPECT_GT(differ, 0) << other;
  }
}

void expect_same_path(const std::string& set_name, std::int64_t trials, std::int64_t allowed,
                      LemkeCover cover = LemkeCover::kNegative) {
  const auto set = open_set(set_name);
  std::int64_t different = 0;
  for (std::int64_t trial = 0; trial < trials; ++trial) {
    const Problem problem = set->generate(1, trial);
    LemkeSettings dense_settings = with(LemkeEngine::kDense), kernel_settings = with(LemkeEngine::kKernel);
    dense_settings.cover = kernel_settings.cover = cover;
    const Recorded dense = run(dense_settings, problem);
    const Recorded kernel = run(kernel_settings, problem);
    different += dense.pivots == kernel.pivots && dense.answer.claim == kernel.answer.claim ? 0 : 1;
  }
  EXPECT_LE(different, allowed) << set_name;
}

TEST(LemkeEnginesTest, TakeTheSamePivots) {
  // 0.1 % may part: where rounding decides whether a pivot of a rank-deficient basis passes for one.
  for (const char* name :
       {"paper/monotone/exp1", "paper/monotone/exp2", "paper/monotone/exp2{redundancy=combination}"}) {
    expect_same_path(name, 1000, 1);
  }
  expect_same_path("paper/copositive/exp1", 6, 0);
  expect_same_path("paper/copositive/exp2", 6, 0);
  expect_same_path("paper/copositive/exp1", 6, 0, LemkeCover::kAll);
}

TEST(LemkeEnginesTest, AgreeOnPivotsOfExponentialPaths) {
  const Problem problem("klee_minty", klee_minty(8));
  const Recorded dense = run(with(LemkeEngine::kDense), problem);
  const Recorded kernel = run(with(LemkeEngine::kKernel), problem);
  EXPECT_GT(dense.pivots.size(), 8U);
  EXPECT_EQ(dense.pivots, kernel.pivots);
}

TEST(LemkeEnginesTest, LevelsAgreeOnAnswers) {
  const auto set = open_set("paper/copositive/exp1");
  for (const LemkeEngine engine : {LemkeEngine::kDense, LemkeEngine::kKernel}) {
    int compared = 0;
    for (std::int64_t trial = 0; compared < 4; ++trial) {
      const Problem problem = set->generate(2, trial);
      if (problem.size() > 150) continue;
      ++compared;
      const Recorded reference = run(with(engine), problem, IsaLevel::kBaseline);
      ASSERT_EQ(reference.answer.claim, Claim::kSolved);
      for (const IsaLevel level : levels_of_this_machine()) {
        const Recorded result = run(with(engine), problem, level);
        ASSERT_EQ(result.answer.claim, Claim::kSolved) << to_string(level);
        EXPECT_EQ(result.pivots, reference.pivots) << to_string(level);
        EXPECT_LE(error(result.answer.z, reference.answer.z), 1e-6) << to_string(level);
      }
    }
  }
}

TEST(LemkeEnginesTest, CountsItsWork) {
  const Problem problem = bare(tridiagonal(9, 4, -1), -ones(9));
  const Recorded result = run(with(LemkeEngine::kKernel), problem);
  EXPECT_EQ(result.answer.counters.pivots, static_cast<std::int64_t>(result.pivots.size()));
  EXPECT_EQ(result.answer.counters.factorizations, result.answer.counters.pivots + 1);  // the last basis, for its values
}

}  // namespace
}  // namespace lcpbench::lemke_test
