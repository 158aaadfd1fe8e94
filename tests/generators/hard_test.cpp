// The hard cases against what is known of them otherwise: the formulas' own answers by the evaluation in 113 bits, the
// unsolvable ones by proofs in exact arithmetic, the small ones by exact enumeration of all bases.

#include "generators/hard/hard.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/registry.h"
#include "generators/sets.h"
#include "study/evaluation/evaluation.h"
#include "study/run/plan.h"
#include "study/run/study.h"
#include "tests/support/enumeration.h"

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

/// The second part of the name.
std::string family(const HardSet& set) {
  const std::size_t begin = set.name.find('/') + 1;
  return set.name.substr(begin, set.name.find('/', begin) - begin);
}

/// The verdict's measure.
double error_of(const Problem& problem, const Errors& errors) {
  return problem.contact() != nullptr ? errors.velocity_residual_relative : errors.backward_row_norm;
}

TEST(HardSetsTest, AreManyInManyFamiliesAndSayWhatTheyAre) {
  std::set<std::string> families;
  std::set<std::string> names;
  for (const HardSet& set : hard_sets()) {
    families.insert(family(set));
    names.insert(set.name);
    EXPECT_FALSE(set.size.empty() || set.summary.empty() || set.hard.empty() || set.source.empty()) << set.name;
  }
  EXPECT_GE(names.size(), 60U);
  EXPECT_EQ(names.size(), hard_sets().size());
  const std::set<std::string> expected{"edge", "cycling", "degenerate",      "exponential", "ray",     "class",
                                       "game", "family",  "ill-conditioned", "scaling",     "contact", "pde"};
  EXPECT_EQ(families, expected);
  EXPECT_GE(instances().size(), 300U);
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
    EXPECT_EQ(testing::enumerate(problem.lcp()).solvable, solvable) << name;
    ++checked;
  }
  EXPECT_GE(checked, 60U);
}

// ---- formulas against a second way to the same numbers ----

TEST(HardFormulaTest, TheRingIsTheCirculantOfItsAngle) {
  for (const int doublings : {0, 2, 4}) {
    const Matrix M = problem_of("hard/contact/ring{doublings=" + std::to_string(doublings) + "}").lcp().M;
    const Index k = M.rows();
    const double angle = 2 * std::acos(-1.0) / static_cast<double>(k);
    for (Index i = 0; i < k; ++i) {
      EXPECT_NEAR(M(i, i), 2, 1e-11);
      EXPECT_NEAR(M(i, (i + 1) % k), -std::cos(angle), 1e-11);
    }
    EXPECT_TRUE(k == 3 || M(0, 2) == 0);
  }
}

TEST(HardFormulaTest, HilbertAndPascalAreWhatTheyAreCalled) {
  const Matrix H = problem_of("hard/ill-conditioned/hilbert{n=8}").lcp().M;
  EXPECT_EQ(H(0, 0), 360360);  // lcm(1..15)
  EXPECT_EQ(H(3, 4), 360360.0 / 8);
  const Matrix P = problem_of("hard/ill-conditioned/pascal{n=12}").lcp().M;
  EXPECT_EQ(P(4, 6), 210);  // 10 choose 4
  EXPECT_NEAR(P.partialPivLu().determinant(), 1, 1e-3);
}

TEST(HardFormulaTest, UnitsChangeNothingButUnits) {
  const ContactProblem metres = *problem_of("hard/contact/units{mass=0,length=0}").contact();
  const ContactProblem others = *problem_of("hard/contact/units{mass=3,length=7}").contact();
  EXPECT_EQ(dense_inertia(others.inertia)(0, 0), 8 * dense_inertia(metres.inertia)(0, 0));
  EXPECT_EQ(dense_inertia(others.inertia)(5, 5), 8 * 128 * 128 * dense_inertia(metres.inertia)(5, 5));
  EXPECT_EQ(others.v(2), 128 * metres.v(2));
  const std::vector<double> z = hard_case("hard/contact/units{mass=0,length=0}")->truth.z;
  const std::vector<double> scaled = hard_case("hard/contact/units{mass=3,length=7}")->truth.z;
  for (std::size_t i = 0; i < z.size(); ++i) EXPECT_EQ(scaled[i], 8 * 128 * z[i]);
}

TEST(HardFormulaTest, OneUlpDecidesBetweenStickingAndSliding) {
  EXPECT_EQ(hard_case("hard/contact/friction-angle{ulps=1}")->truth.z.back(), 0);
  EXPECT_EQ(hard_case("hard/contact/friction-angle")->truth.z.back(), 0);
  EXPECT_EQ(hard_case("hard/contact/friction-angle{ulps=-1}")->truth.z.back(), 0x1p-51);
}

}  // namespace
}  // namespace lcpbench::hard_test
