// The precision ladder of `lemke`: each rung's answers are verified by the evaluation, and its errors are where its
// arithmetic puts them.

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/registry.h"
#include "generators/sets.h"
#include "native/lemke/lemke.h"
#include "native/lemke/lemke_sweep.h"
#include "study/certify/certificate.h"
#include "study/evaluation/evaluation.h"
#include "study/statistics/statistics.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/exact_velocity.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench {
namespace {

constexpr LemkePrecision kRungs[] = {LemkePrecision::kFloat, LemkePrecision::kDouble, LemkePrecision::kPolished,
                                     LemkePrecision::kQuad};

LemkeSettings at(LemkePrecision precision) {
  LemkeSettings settings;
  settings.precision = precision;
  return settings;
}

std::string name_of(LemkePrecision precision) {
  for (const auto& [key, value] : all_settings(at(precision))) {
    if (key == "precision") return value;
  }
  return "";
}

Answer solve(LemkePrecision precision, const Problem& problem, IsaLevel level = isa_level()) {
  Lemke solver(at(precision), level);
  Answer answer;
  solver.load(problem);
  solver.solve({}, answer);
  return answer;
}

/// Errors of the velocities of the rungs on one set.
struct Ladder {
  std::vector<double> errors[4];

  Ladder(const std::string& set_name, int trials) {
    const auto set = open_set(set_name);
    for (int trial = 0; trial < trials; ++trial) add(set->generate(41, trial));
  }

  void add(const Problem& problem) {
    Evaluator evaluator(problem);
    QuadVector exact;
    if (!testing::exact_velocity(*problem.contact(), solve(LemkePrecision::kQuad, problem).z, exact)) return;
    for (std::size_t rung = 0; rung < 4; ++rung) {
      const Answer answer = solve(kRungs[rung], problem);
      if (answer.claim != Claim::kSolved) continue;
      EXPECT_TRUE(evaluator.errors(answer).solved) << name_of(kRungs[rung]) << ", " << problem.name();
      const Vector velocity =
          answer.velocity.size() > 0 ? Vector(answer.velocity) : post_impact_velocity(*problem.contact(), answer.z);
      errors[rung].push_back(testing::velocity_error(*problem.contact(), velocity, exact));
    }
  }
};

TEST(LemkePrecisionTest, ErrorsFallFromRungToRung) {
  for (const char* set : {"paper/monotone/exp1", "paper/monotone/exp5-1e5"}) {
    SCOPED_TRACE(set);
    Ladder ladder(set, 80);
    for (std::size_t rung = 1; rung < 4; ++rung) ASSERT_GE(ladder.errors[rung].size(), 70U) << name_of(kRungs[rung]);
    ASSERT_GE(ladder.errors[0].size(), 10U) << "float solves nothing";
    const double in_float = spread(ladder.errors[0]).median;
    const double in_double = spread(ladder.errors[1]).median;
    const double polished = spread(ladder.errors[2]).median;
    const double in_quad = spread(ladder.errors[3]).median;
    EXPECT_GE(in_float, 1e5 * in_double);  // 29 bits lie between them, 5e8
    EXPECT_LE(polished, in_double);
    EXPECT_LE(polished, 3e-14);  // what an orthogonal projection leaves at this condition number
    EXPECT_LE(in_quad, polished);
    EXPECT_LE(in_quad, 2e-16);  // v* itself, rounded to double
  }
}

// Where double alone loses digits to the condition number of G, hundreds of roundings and more, the polish does not.
TEST(LemkePrecisionTest, PolishGivesTheVelocityBackWhatTheMatrixLost) {
  Ladder ladder("paper/monotone/exp5-1e8", 60);
  ASSERT_GE(ladder.errors[1].size(), 50U);
  ASSERT_GE(ladder.errors[2].size(), 50U);
  ASSERT_GE(ladder.errors[3].size(), 50U);
  EXPECT_LE(100 * spread(ladder.errors[2]).median, spread(ladder.errors[1]).median);
  EXPECT_LE(spread(ladder.errors[2]).median, 1e-12);
  EXPECT_LE(spread(ladder.errors[3]).median, 2e-16);
}

TEST(LemkePrecisionTest, NoOtherRungClaimsWhatTheEvaluationRejects) {
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
    for (const LemkePrecision precision : {LemkePrecision::kFloat, LemkePrecision::kPolished, LemkePrecision::kQuad}) {
      for (int trial = 0; trial < each.trials; ++trial) {
        const Problem problem = set->generate(42, trial);
        if (precision == LemkePrecision::kQuad && problem.size() > 120) continue;  // minutes in all
        const Answer answer = solve(precision, problem);
        if (answer.claim == Claim::kUnsolvable) {
          ASSERT_EQ(Certifier({}).certify(problem).kind, CertificateKind::kUnsolvable) << each.set << ", trial " << trial;
        }
        if (answer.claim != Claim::kSolved) {
          EXPECT_EQ(answer.z.cwiseAbs().maxCoeff(), 0) << "an answer that is none must not look like one";
          continue;
        }
        ASSERT_TRUE(Evaluator(problem).errors(answer).solved)
            << each.set << ", trial " << trial << ", " << name_of(precision);
      }
    }
  }
}

TEST(LemkePrecisionTest, FloatSolvesWellConditionedContacts) {
  const auto set = open_set("paper/monotone/exp1");
  int solved = 0;
  for (int trial = 0; trial < 100; ++trial) {
    solved += solve(LemkePrecision::kFloat, set->generate(43, trial)).claim == Claim::kSolved;
  }
  EXPECT_GE(solved, 40);
}

TEST(LemkePrecisionTest, FrictionIsPolishedToo) {
  for (const char* name : {"paper/copositive/exp1", "paper/copositive/exp5-1e5"}) {
    const auto set = open_set(name);
    int polished = 0, compared = 0;
    for (int trial = 0; compared < 15; ++trial) {
      const Problem problem = set->generate(44, trial);
      if (problem.size() > 150) continue;
      ++compared;
      Evaluator evaluator(problem);
      const double plain = evaluator.errors(solve(LemkePrecision::kDouble, problem)).velocity_residual_relative;
      for (const LemkePrecision precision : {LemkePrecision::kPolished, LemkePrecision::kQuad}) {
        const Answer answer = solve(precision, problem);
        ASSERT_EQ(answer.claim, Claim::kSolved) << name << ", trial " << trial << ": " << answer.detail;
        const Errors errors = evaluator.errors(answer);
        EXPECT_TRUE(errors.solved) << name << ", trial " << trial;
        // Of z as rounded to double: no better than double may be, but for rounding no worse.
        EXPECT_LE(errors.velocity_residual_relative, 10 * plain + 1e-10) << name << ", trial " << trial;
        if (answer.velocity.size() == 0) continue;
        ++polished;
        EXPECT_LE(errors.velocity_mismatch, 1e-12) << name << ", trial " << trial;
      }
    }
    EXPECT_EQ(polished, 30) << name << ": returns no velocity";
  }
}

// Contacts that press while they stick, slide, and slide along two directions at once.
TEST(LemkePrecisionTest, PolishKnowsStickingAndSlidingContacts) {
  RigidScene scene;
  scene.bodies.resize(1);
  scene.bodies[0].position = {0, 0, 0.5};
  scene.contacts.push_back({.point = {0, 0, 0}, .mu = 0.5, .edges = 4});
  struct Case {
    Eigen::Vector3d velocity;
    Eigen::Vector3d expected;  // of the linear velocity's impulse, for a body that cannot turn
  };
  scene.bodies[0].inertia = 1e6 * Eigen::Matrix3d::Identity();
  for (const Case& each : {Case{{0, 0, -1}, {0, 0, 1}}, Case{{0.25, 0, -1}, {-0.25, 0, 1}},
                           Case{{2, 0, -1}, {-0.5, 0, 1}}, Case{{2, 0.125, -1}, {-0.5, 0, 1}}}) {
    scene.bodies[0].linear_velocity = each.velocity;
    const Problem problem("foot", scene);
    for (const LemkePrecision precision : {LemkePrecision::kPolished, LemkePrecision::kQuad}) {
      const Answer answer = solve(precision, problem);
      ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
      ASSERT_EQ(answer.velocity.size(), 6);
      EXPECT_LE((answer.velocity.head<3>() - each.velocity - each.expected).norm(), 1e-5) << each.velocity.transpose();
      EXPECT_TRUE(Evaluator(problem).errors(answer).solved);
      EXPECT_LE(Evaluator(problem).errors(answer).velocity_mismatch, 1e-15);
    }
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

TEST(LemkePrecisionTest, BareProblemsAreRefined) {
  const Index n = 9;
  Vector z(n);
  for (Index i = 0; i < n; ++i) z(i) = static_cast<double>(1 + i % 3);
  const Problem problem("pascal", Lcp{pascal(n), -pascal(n) * z});  // exact: small integers
  const auto error = [&](LemkePrecision precision) {
    const Answer answer = solve(precision, problem);
    EXPECT_EQ(answer.claim, Claim::kSolved) << name_of(precision) << ": " << answer.detail;
    return (answer.z - z).cwiseAbs().maxCoeff();
  };
  EXPECT_GE(error(LemkePrecision::kDouble), 1e-13) << "nothing left to refine: the test shows nothing";
  EXPECT_LE(error(LemkePrecision::kPolished), 1e-15);
  EXPECT_LE(error(LemkePrecision::kQuad), 1e-15);
  const Answer in_float = solve(LemkePrecision::kFloat, problem);
  EXPECT_EQ(in_float.claim, Claim::kNumericalFailure);  // 24 bits cannot pass for a solution of it
}

TEST(LemkePrecisionTest, TrivialAnswersHaveNoBasisToRefine) {
  Lemke solver(at(LemkePrecision::kPolished));
  Answer answer;
  solver.load(Problem("first", Lcp{pascal(4), -testing::ones(4)}));
  solver.solve({}, answer);
  ASSERT_EQ(answer.claim, Claim::kSolved);
  solver.load(Problem("trivial", Lcp{pascal(4), testing::ones(4)}));
  solver.solve({}, answer);
  EXPECT_EQ(answer.claim, Claim::kSolved);
  EXPECT_EQ(answer.z, Vector::Zero(4));
}

TEST(LemkePrecisionTest, NoRungAllocatesInASolve) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "the allocator of this build cannot be replaced";
  const Problem contacts = open_set("paper/monotone/exp1")->generate(45, 0);
  const Problem friction = open_set("paper/copositive/exp2")->generate(45, 2);
  const Problem bare("pascal", Lcp{pascal(8), -testing::ones(8)});
  for (const LemkePrecision precision : kRungs) {
    SCOPED_TRACE(name_of(precision));
    Lemke solver(at(precision));
    ASSERT_TRUE(solver.capabilities().allocation_free);
    for (const Problem& problem : {contacts, friction, bare}) {
      Answer answer;
      solver.load(problem);
      solver.solve({}, answer);  // its storage is reused below
      EXPECT_EQ(testing::count_allocations([&] { solver.solve({}, answer); }), 0) << problem.name();
    }
  }
}

TEST(LemkePrecisionTest, SweepsOfOtherPrecisionsRunOneByOne) {
  const auto sweep = [](const char* precision) {
    return make_swept_lemke({{{"pivot_tolerance", "1e-8"}, {"precision", precision}, {"test", "none"}},
                             {{"pivot_tolerance", "1e-12"}, {"precision", precision}, {"test", "none"}}});
  };
  EXPECT_NE(sweep("double"), nullptr);
  for (const char* precision : {"float", "polished", "quad"}) EXPECT_EQ(sweep(precision), nullptr) << precision;
}

TEST(LemkePrecisionTest, TheDenseEngineKnowsDoubleOnly) {
  LemkeSettings settings = at(LemkePrecision::kQuad);
  settings.engine = LemkeEngine::kDense;
  EXPECT_THROW(Lemke{settings}, InputError);
}

TEST(LemkePrecisionTest, EveryInstructionSetLevelPolishesAlike) {
  const auto set = open_set("paper/monotone/exp5-1e5");
  for (int trial = 0; trial < 20; ++trial) {
    const Problem problem = set->generate(46, trial);
    const Answer reference = solve(LemkePrecision::kPolished, problem, IsaLevel::kBaseline);
    for (const IsaLevel level : {IsaLevel::kAvx2, IsaLevel::kAvx512}) {
      if (level > best_isa_level()) continue;
      const Answer answer = solve(LemkePrecision::kPolished, problem, level);
      ASSERT_EQ(answer.claim, reference.claim) << to_string(level);
      ASSERT_EQ(answer.velocity.size(), reference.velocity.size());
      EXPECT_LE((answer.velocity - reference.velocity).norm(), 1e-11 * problem.contact()->v.norm());
    }
  }
}

}  // namespace
}  // namespace lcpbench
