// `lemke` in 113 bits: its answers are verified by the evaluation.

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/registry.h"
#include "generators/sets.h"
#include "native/lemke/lemke.h"
#include "native/lemke/lemke_sweep.h"
#include "study/certify/certificate.h"
#include "study/evaluation/evaluation.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench {
namespace {

LemkeSettings at(LemkePrecision precision) {
  LemkeSettings settings;
  settings.precision = precision;
  return settings;
}

Answer solve(LemkePrecision precision, const Problem& problem) {
  Lemke solver(at(precision));
  Answer answer;
  solver.load(problem);
  solver.solve({}, answer);
  return answer;
}

TEST(LemkePrecisionTest, QuadClaimsNothingThatTheEvaluationRejects) {
  struct Case {
    const char* set;
    int trials;
  };
  for (const Case& each :
       {Case{"paper/monotone/exp1", 150}, Case{"paper/monotone/exp2", 150}, Case{"paper/monotone/exp3", 100},
        Case{"paper/monotone/exp4", 100}, Case{"paper/monotone/exp5-1e5", 100}, Case{"paper/monotone/exp5-1e8", 100},
        Case{"paper/monotone/exp5-1e10", 100}, Case{"paper/monotone/exp5-1e10{redundancy=combination}", 100},
        Case{"paper/copositive/exp1", 12}, Case{"paper/copositive/exp5-1e8", 12}}) {
    const auto set = open_set(each.set);
    for (int trial = 0; trial < each.trials; ++trial) {
      const Problem problem = set->generate(42, trial);
      if (problem.size() > 120) continue;  // minutes in all
      const Answer answer = solve(LemkePrecision::kQuad, problem);
      if (answer.claim == Claim::kUnsolvable) {
        ASSERT_EQ(Certifier({}).certify(problem).kind, CertificateKind::kUnsolvable) << each.set << ", trial " << trial;
      }
      if (answer.claim != Claim::kSolved) {
        EXPECT_EQ(answer.z.cwiseAbs().maxCoeff(), 0) << "an answer that is none must not look like one";
        continue;
      }
      ASSERT_TRUE(Evaluator(problem).errors(answer).solved) << each.set << ", trial " << trial;
    }
  }
}

TEST(LemkePrecisionTest, QuadSolvesWhatDoubleDoesNot) {
  for (const char* name : {"hard/ill-conditioned/pascal", "hard/scaling/columns", "hard/scaling/rows"}) {
    const Problem problem = open_set(name)->generate(1, 0);
    EXPECT_NE(solve(LemkePrecision::kDouble, problem).claim, Claim::kSolved) << name;
    const Answer answer = solve(LemkePrecision::kQuad, problem);
    ASSERT_EQ(answer.claim, Claim::kSolved) << name << ": " << answer.detail;
    EXPECT_TRUE(Evaluator(problem).errors(answer).solved) << name;
  }
}

/// Pascal's matrix: integers, positive definite, inverse integer, condition number about 16^n / n.
Matrix pascal(Index n) {
  Matrix P = Matrix::Ones(n, n);
  for (Index i = 1; i < n; ++i) {
    for (Index j = 1; j < n; ++j) P(i, j) = P(i - 1, j) + P(i, j - 1);
  }
  return P;
}

TEST(LemkePrecisionTest, QuadLosesNothingToTheConditionOfM) {
  const Index n = 9;
  Vector z(n);
  for (Index i = 0; i < n; ++i) z(i) = static_cast<double>(1 + i % 3);
  const Problem problem("pascal", Lcp{pascal(n), -pascal(n) * z});  // exact: small integers
  const auto error = [&](LemkePrecision precision) {
    const Answer answer = solve(precision, problem);
    EXPECT_EQ(answer.claim, Claim::kSolved) << answer.detail;
    return (answer.z - z).cwiseAbs().maxCoeff();
  };
  EXPECT_GE(error(LemkePrecision::kDouble), 1e-13) << "nothing is lost in double: the test shows nothing";
  EXPECT_LE(error(LemkePrecision::kQuad), 1e-15);
}

TEST(LemkePrecisionTest, QuadAllocatesNothingInASolve) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "the allocator of this build cannot be replaced";
  const Problem contacts = open_set("paper/monotone/exp1")->generate(45, 0);
  const Problem friction = open_set("paper/copositive/exp2")->generate(45, 2);
  const Problem bare("pascal", Lcp{pascal(8), -testing::ones(8)});
  Lemke solver(at(LemkePrecision::kQuad));
  ASSERT_TRUE(solver.capabilities().allocation_free);
  for (const Problem& problem : {contacts, friction, bare}) {
    Answer answer;
    solver.load(problem);
    solver.solve({}, answer);  // its storage is reused below
    EXPECT_EQ(testing::count_allocations([&] { solver.solve({}, answer); }), 0) << problem.name();
  }
}

TEST(LemkePrecisionTest, SweepsOfOtherPrecisionsRunOneByOne) {
  const auto sweep = [](const char* precision) {
    return make_swept_lemke({{{"pivot_tolerance", "1e-8"}, {"precision", precision}, {"test", "none"}},
                             {{"pivot_tolerance", "1e-12"}, {"precision", precision}, {"test", "none"}}});
  };
  EXPECT_NE(sweep("double"), nullptr);
  EXPECT_EQ(sweep("quad"), nullptr);
}

TEST(LemkePrecisionTest, TheDenseEngineKnowsDoubleOnly) {
  LemkeSettings settings = at(LemkePrecision::kQuad);
  settings.engine = LemkeEngine::kDense;
  EXPECT_THROW(Lemke{settings}, InputError);
}

TEST(LemkeEnginesTest, ALevelTheProcessorLacksIsRefused) {
  if (best_isa_level() == IsaLevel::kAvx512) GTEST_SKIP() << "this processor has every level";
  EXPECT_THROW(Lemke(LemkeSettings{}, IsaLevel::kAvx512), std::invalid_argument);
}

TEST(LemkeEnginesTest, AllocateNothingInASolve) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "the allocator of this build cannot be replaced";
  Vector nearly_at_rest = testing::ones(400);
  nearly_at_rest.head(3) *= -1;
  const Problem frictional = open_set("paper/copositive/exp2")->generate(1, 0);
  const auto bare = [](Matrix M, Vector q) { return Problem("test", Lcp{std::move(M), std::move(q)}); };
  Lemke solver(LemkeSettings{});
  ASSERT_TRUE(solver.capabilities().allocation_free);
  Answer answer;
  for (const Problem& problem :
       {frictional, bare(testing::tridiagonal(150, 4, -1), -testing::ones(150)), bare(testing::tridiagonal(400, 4, -1), nearly_at_rest),
        bare(testing::matrix_of(2, {1, -1, -1, 1}), testing::vector_of({-1, -1}))}) {
    solver.load(problem);
    answer.reserve(problem);
    EXPECT_EQ(testing::count_allocations([&] { solver.solve({}, answer); }), 0) << problem.size();
  }
  EXPECT_EQ(answer.claim, Claim::kUnsolvable);
  LemkeSettings dense;
  dense.engine = LemkeEngine::kDense;
  EXPECT_FALSE(Lemke(dense).capabilities().allocation_free);  // Eigen's LU of large matrices takes memory
}

}  // namespace
}  // namespace lcpbench
