// The hard cases against what is known of them otherwise: the formulas' own answers by the evaluation in 113 bits, the
// unsolvable ones by proofs in exact arithmetic, the small ones by exact enumeration of all bases.

#include "generators/hard/hard.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/registry.h"
#include "generators/sets.h"
#include "study/evaluation/evaluation.h"
#include "study/run/plan.h"
#include "study/run/study.h"
#include "tests/attack/truth.h"

namespace lcpbench::hard_test {
namespace {

/// Every instance of the built-in plan: each set as it is, and along its dials.
const std::vector<std::string>& instances() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> found;
    for (const PlannedSet& planned : load_plan("hard").sets) {
      for (std::string& name : expand_sets(planned.pattern)) found.push_back(std::move(name));
    }
    return found;
  }();
  return names;
}

Problem problem_of(const std::string& name) { return open_set(name)->generate(1, 0); }

Vector vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Vector>(values.data(), static_cast<Index>(values.size()));
}

Answer answer_of(const HardTruth& truth) {
  Answer answer;
  answer.claim = Claim::kSolved;
  answer.z = vector_of(truth.z);
  answer.velocity = vector_of(truth.velocity);
  return answer;
}

Answer solve(const std::string& solver, const Problem& problem) {
  const auto made = make_solver(parse_spec(solver));
  Answer answer;
  made->load(problem);
  made->solve({}, answer);
  return answer;
}

/// The verdict's measure.
double error_of(const Problem& problem, const Errors& errors) {
  return problem.contact() != nullptr ? errors.velocity_residual_relative : errors.backward_row_norm;
}

TEST(HardTruthTest, ExactAnswersLeaveNothing) {
  // 113 bits: sums of products of doubles in this range of exponents round at 1e-34 of their terms.
  constexpr double kQuadRounding = 1e-30;
  std::size_t checked = 0;
  for (const std::string& name : instances()) {
    const HardTruth truth = hard_case(name)->truth;
    if (truth.z.empty() || !truth.exact) continue;
    const Problem problem = problem_of(name);
    const Errors errors = Evaluator(problem).errors(answer_of(truth));
    EXPECT_TRUE(errors.solved) << name;
    EXPECT_GE(errors.min_z, 0.0) << name;
    EXPECT_LE(error_of(problem, errors), kQuadRounding) << name;
    if (!truth.velocity.empty()) {
      EXPECT_LE(errors.velocity_mismatch, kQuadRounding) << name;
    }
    ++checked;
  }
  EXPECT_GE(checked, 200U);
}

TEST(HardTruthTest, RoundedAnswersAreWithinRounding) {
  std::size_t checked = 0;
  for (const std::string& name : instances()) {
    const HardTruth truth = hard_case(name)->truth;
    if (truth.z.empty() || truth.exact) continue;
    const Problem problem = problem_of(name);
    const Errors errors = Evaluator(problem).errors(answer_of(truth));
    EXPECT_TRUE(errors.solved) << name;
    EXPECT_LE(error_of(problem, errors), 1e-15) << name;
    ++checked;
  }
  EXPECT_GE(checked, 4U);
}

TEST(HardTruthTest, ProofsOfUnsolvabilityHoldExactly) {
  std::size_t checked = 0;
  for (const std::string& name : instances()) {
    const HardTruth truth = hard_case(name)->truth;
    if (truth.known != HardKnown::kUnsolvable || truth.farkas.empty()) continue;
    Evaluator evaluator(problem_of(name));
    Vector proof = vector_of(truth.farkas);
    EXPECT_TRUE(evaluator.check_farkas(proof)) << name;
    EXPECT_FALSE(evaluator.check_farkas(Vector::Zero(proof.size()))) << name;
    EXPECT_FALSE(evaluator.check_farkas(-proof)) << name;
    ++checked;
  }
  EXPECT_GE(checked, 10U);
}

TEST(HardTruthTest, SolvableWithoutAFormulaIsProvenOtherwise) {
  for (const std::string& name : instances()) {
    const HardTruth truth = hard_case(name)->truth;
    if (truth.known != HardKnown::kSolvable || !truth.z.empty()) continue;
    const Problem problem = problem_of(name);
    Evaluator evaluator(problem);
    const bool proven = evaluator.truth() == Truth::kSolvable;
    EXPECT_TRUE(proven || evaluator.errors(solve("auto", problem)).solved) << name;
  }
}

// Independent of formula, evaluation and floating point: every basis, over the integers.
TEST(HardTruthTest, ExactEnumerationOfSmallLcpsAgrees) {
  constexpr Index kLargest = 8;
  std::size_t checked = 0;
  for (const std::string& name : instances()) {
    const Problem problem = problem_of(name);
    if (problem.contact() != nullptr || problem.size() > kLargest) continue;
    const bool solvable = hard_case(name)->truth.known == HardKnown::kSolvable;
    EXPECT_EQ(attack::exact_truth(problem).truth == Truth::kSolvable, solvable) << name;
    ++checked;
  }
  EXPECT_GE(checked, 60U);
}

TEST(HardFormulaTest, OneUlpDecidesBetweenStickingAndSliding) {
  EXPECT_EQ(hard_case("hard/contact/friction-angle{ulps=1}")->truth.z.back(), 0);
  EXPECT_EQ(hard_case("hard/contact/friction-angle")->truth.z.back(), 0);
  EXPECT_EQ(hard_case("hard/contact/friction-angle{ulps=-1}")->truth.z.back(), 0x1p-51);
}

}  // namespace
}  // namespace lcpbench::hard_test
