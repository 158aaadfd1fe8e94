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

TEST(HardSetsTest, ThePageCountsTheCasesOfEachFamily) {
  std::ostringstream page;
  page << std::ifstream(HARD_CASES_PAGE).rdbuf();
  std::map<std::string, int> cases;
  for (const HardSet& set : hard_sets()) ++cases[set.name.substr(0, set.name.rfind('/'))];
  for (const auto& [family, count] : cases) {
    EXPECT_NE(page.str().find("| `" + family + "/*` | " + std::to_string(count) + " |"), std::string::npos) << family;
  }
}

TEST(HardSetsTest, OtherSetsAreNone) {
  EXPECT_FALSE(hard_case("paper/monotone/exp1").has_value());
  EXPECT_THROW(hard_case("hard/contact/stack{ratio=47}"), InputError);
  EXPECT_THROW(hard_case("hard/contact/stack{height=3}"), InputError);
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

TEST(HardTruthTest, AnAnswerThatIsNoNormalDoubleIsNotGiven) {
  for (const char* text : {"hard/edge/scalar{M=1e-300,q=-1e100}", "hard/edge/scalar{M=1e100,q=-1e-300}"}) {
    const HardTruth truth = hard_case(text)->truth;
    EXPECT_EQ(truth.known, HardKnown::kSolvable);
    EXPECT_TRUE(truth.z.empty()) << text;
  }
}

TEST(HardSetsTest, DialsThatAreNotTheOrderSayWhatTheyAre) {
  for (const char* text : {"hard/game/cyclic{half=2}", "hard/exponential/klee-minty{n=5}"}) {
    EXPECT_EQ(hard_case(text)->M.rows, 10U);
    const auto set = std::ranges::find(hard_sets(), parse_spec(text).name, &HardSet::name);
    EXPECT_FALSE(set->options()[0].help.starts_with("the order") || set->options()[0].help == "order of M") << text;
  }
}

TEST(HardTruthTest, AReasonNamesTheUnitOfItsNumbers) {
  const std::string reason = hard_case("hard/ray/copositive-none")->truth.reason;
  EXPECT_EQ(reason, "w >= 0 asks for z_1 >= 2, then w_1 > 0 asks for z_1 = 0");
  EXPECT_EQ(hard_case("hard/ray/copositive-none{scale=-3}")->truth.reason, reason + "; q, z and w in units of 2^-3");
}

TEST(HardTruthTest, AWrongAnswerIsNoticed) {
  const std::string name = "hard/contact/friction-angle{ulps=-1000}";
  HardTruth truth = hard_case(name)->truth;
  ASSERT_TRUE(truth.exact);
  truth.z[3] = 0;  // sticks, where mu is too small for it by 1000 ulps
  EXPECT_GT(Evaluator(problem_of(name)).errors(answer_of(truth)).velocity_residual_relative, 1e-15);
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

TEST(HardTruthTest, TheoryOfTheDataNeverContradicts) {
  for (const std::string& name : instances()) {
    const bool solvable = hard_case(name)->truth.known == HardKnown::kSolvable;
    EXPECT_TRUE(solvable || Evaluator(problem_of(name)).truth() != Truth::kSolvable) << name;
  }
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

/// The distinct solutions at nonsingular bases of a small LCP, by elimination in doubles.
std::vector<Vector> vertex_solutions(const Lcp& lcp) {
  const Index n = lcp.size();
  std::vector<Vector> found;
  for (unsigned set = 0; set < (1U << n); ++set) {
    Matrix B = Matrix::Identity(n, n);  // [I -M] restricted: w off the set, z on it
    for (Index j = 0; j < n; ++j) {
      if ((set >> j & 1U) != 0) B.col(j) = -lcp.M.col(j);
    }
    const Eigen::FullPivLU<Matrix> lu(B);
    if (!lu.isInvertible()) continue;
    const Vector x = lu.solve(lcp.q);
    const double scale = 1e-9 * x.cwiseAbs().maxCoeff();
    if (!(x.minCoeff() >= -scale)) continue;
    Vector z = Vector::Zero(n);
    for (Index j = 0; j < n; ++j) {
      if ((set >> j & 1U) != 0) z(j) = x(j);
    }
    const bool known = std::any_of(found.begin(), found.end(), [&](const Vector& other) {
      return (other - z).cwiseAbs().maxCoeff() <= 10 * scale;
    });
    if (!known) found.push_back(z);
  }
  return found;
}

TEST(HardTruthTest, OneSolutionWhereTheFormulaSaysSo) {
  constexpr Index kLargest = 7;
  std::size_t checked = 0;
  for (const HardSet& set : hard_sets()) {
    const Problem problem = problem_of(set.name);
    const HardTruth truth = hard_case(set.name)->truth;
    const bool tiny_numbers = family(set) == "edge";  // elimination in doubles takes them for zeros
    if (problem.contact() != nullptr || problem.size() > kLargest || tiny_numbers) continue;
    if (truth.known == HardKnown::kUnsolvable || truth.unique != HardUnique::kYes) continue;
    EXPECT_EQ(vertex_solutions(problem.lcp()).size(), 1U) << set.name;
    ++checked;
  }
  EXPECT_GE(checked, 12U);
}

TEST(HardTruthTest, SeveralEquilibriaWhereTheGameHasThem) {
  EXPECT_EQ(vertex_solutions(problem_of("hard/game/battle-of-sexes").lcp()).size(), 3U);
  EXPECT_EQ(vertex_solutions(problem_of("hard/game/coordination").lcp()).size(), 7U);
  EXPECT_EQ(vertex_solutions(problem_of("hard/class/n-matrix").lcp()).size(), 3U);
}

// It took coordinates of small inertia for ones without any: thin rods, lengths in other units.
TEST(HardSolversTest, ContactLemkeClaimsNothingFalse) {
  std::size_t claimed = 0;
  for (const std::string& name : instances()) {
    const Problem problem = problem_of(name);
    if (problem.contact() == nullptr) continue;
    const Answer answer = solve("contact_lemke", problem);
    const bool solvable = hard_case(name)->truth.known == HardKnown::kSolvable;
    EXPECT_TRUE(answer.claim != Claim::kSolved || Evaluator(problem).errors(answer).solved) << name;
    EXPECT_TRUE(answer.claim != Claim::kUnsolvable || !solvable) << name;
    if (answer.claim == Claim::kSolved || answer.claim == Claim::kUnsolvable) ++claimed;
  }
  EXPECT_GE(claimed, 130U) << "a solver that gives up everywhere claims nothing false either";
}

// An answer to them is within 2^-bits of right; only exact arithmetic on the basis shows that there is none.
TEST(HardSolversTest, AutoProvesWhatIsBarelyInfeasible) {
  for (const int bits : {5, 20, 30, 40, 50}) {
    const Problem problem = problem_of("hard/ray/barely-infeasible{bits=" + std::to_string(bits) + "}");
    const Answer answer = solve("auto", problem);
    EXPECT_EQ(answer.claim, Claim::kUnsolvable) << bits;
    EXPECT_TRUE(Evaluator(problem).check_farkas(answer.farkas)) << bits;
  }
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

TEST(HardFormulaTest, TheIntegersOfMurtyAreThoseOfTheSum) {
  const Lcp lcp = problem_of("hard/exponential/murty-nondegenerate{n=10}").lcp();
  for (Index i = 0; i < 10; ++i) {
    const double sum = std::ldexp(1.0, 11) - std::ldexp(1.0, 10 - static_cast<int>(i));
    EXPECT_EQ(lcp.q(i), -sum);
  }
}

TEST(HardFormulaTest, LemkesPathDoublesWithEachRow) {
  const auto pivots = [](int n) {
    return solve("lemke{engine=dense}", problem_of("hard/exponential/murty-nondegenerate{n=" + std::to_string(n) + "}"))
        .counters.pivots;
  };
  for (const int n : {4, 5, 8, 9}) EXPECT_EQ(pivots(n), (1 << n) - 1) << n;  // the first exchange is not counted
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
