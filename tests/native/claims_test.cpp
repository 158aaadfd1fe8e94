// No native solver claims at its default settings what the verdict calls wrong: the cases where one once did.
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "core/spec.h"
#include "core/timed_solve.h"
#include "generators/sets.h"
#include "native/answer_test/answer_test.h"
#include "native/answer_test/bodies_test.h"
#include "study/evaluation/evaluation.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/evaluation_cases.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench::claims_test {
namespace {

using testing::vector_of;

constexpr double kTimeLimit_s = 600;

std::vector<std::string> native_solvers() {
  std::vector<std::string> names;
  for (const RegisteredSolver& solver : registered_solvers()) {
    if (solver.library == "native") names.push_back(solver.definition.name);
  }
  return names;
}

Answer solve(const std::string& solver, const Problem& problem) {
  const auto made = make_solver(parse_spec(solver));
  Answer answer;
  made->load(problem);
  made->solve({.time_limit_s = kTimeLimit_s}, answer);
  return answer;
}

void expect_honest(const std::string& solver, const Problem& problem, Evaluator& evaluator, bool unsolvable) {
  const Answer answer = solve(solver, problem);
  if (answer.claim != Claim::kSolved) return;
  EXPECT_FALSE(unsolvable) << solver << " solved what has no solution: " << problem.name();
  const Errors errors = evaluator.errors(answer);
  EXPECT_TRUE(errors.solved) << solver << ", " << problem.name() << ": " << errors.velocity_residual_relative << ", "
                             << errors.backward_row_norm;
}

/// Of `hard/`: backward errors just above the test's 1e-9, or small ones of problems without any solution.
const std::vector<const char*> kHard{"hard/class/horn",
                                     "hard/class/horn{scale=-40}",
                                     "hard/class/n-matrix",
                                     "hard/class/n-matrix-negative",
                                     "hard/contact/massless{scale=-40}",
                                     "hard/contact/painleve-acceleration{mu=0}",
                                     "hard/contact/painleve-acceleration{mu=1.4}",
                                     "hard/contact/painleve-acceleration{mu=1}",
                                     "hard/degenerate/identity",
                                     "hard/degenerate/identity{n=100}",
                                     "hard/degenerate/ones",
                                     "hard/degenerate/ones{n=20}",
                                     "hard/degenerate/ones{n=100}",
                                     "hard/edge/denormal",
                                     "hard/edge/denormal{bits=40}",
                                     "hard/edge/denormal{bits=300}",
                                     "hard/edge/denormal{bits=600}",
                                     "hard/edge/denormal{bits=1022}",
                                     "hard/edge/huge",
                                     "hard/edge/huge{bits=40}",
                                     "hard/edge/huge{bits=300}",
                                     "hard/edge/huge{bits=500}",
                                     "hard/edge/huge{bits=520}",
                                     "hard/edge/nonnegative-q{n=50}",
                                     "hard/edge/scalar",
                                     "hard/edge/scalar{M=-1,q=1}",
                                     "hard/edge/scalar{M=1}",
                                     "hard/edge/tiny-pivot{bits=10}",
                                     "hard/exponential/csizmadia",
                                     "hard/exponential/csizmadia{n=32}",
                                     "hard/exponential/csizmadia{n=100}",
                                     "hard/exponential/fathi",
                                     "hard/exponential/fathi{n=4}",
                                     "hard/exponential/fathi{n=8}",
                                     "hard/exponential/fathi{n=16}",
                                     "hard/exponential/fathi{n=20}",
                                     "hard/exponential/klee-minty{n=12}",
                                     "hard/exponential/murty-nondegenerate",
                                     "hard/exponential/murty-nondegenerate{n=4}",
                                     "hard/exponential/murty-nondegenerate{n=8}",
                                     "hard/exponential/murty-nondegenerate{n=16}",
                                     "hard/exponential/murty-nondegenerate{n=20}",
                                     "hard/exponential/upper-symmetric",
                                     "hard/exponential/upper-symmetric{n=4}",
                                     "hard/exponential/upper-symmetric{n=8}",
                                     "hard/exponential/upper-symmetric{n=16}",
                                     "hard/exponential/upper-symmetric{n=20}",
                                     "hard/exponential/upper{n=16}",
                                     "hard/exponential/upper{n=20}",
                                     "hard/family/diagonal-ramp",
                                     "hard/family/geiger-kanzow",
                                     "hard/family/geiger-kanzow{n=8}",
                                     "hard/family/geiger-kanzow{n=128}",
                                     "hard/ill-conditioned/hilbert-mixed",
                                     "hard/ill-conditioned/hilbert-mixed{n=6}",
                                     "hard/ill-conditioned/hilbert-mixed{n=8}",
                                     "hard/ill-conditioned/hilbert{n=4}",
                                     "hard/ill-conditioned/hilbert{n=8}",
                                     "hard/ill-conditioned/hilbert{n=18}",
                                     "hard/ill-conditioned/moler{n=30}",
                                     "hard/ill-conditioned/moler{n=60}",
                                     "hard/ill-conditioned/pascal",
                                     "hard/ill-conditioned/pascal{n=6}",
                                     "hard/ill-conditioned/pascal{n=10}",
                                     "hard/ill-conditioned/pascal{n=14}",
                                     "hard/ill-conditioned/pascal{n=24}",
                                     "hard/pde/american-put{n=10}",
                                     "hard/pde/bearing",
                                     "hard/pde/bearing{eccentricity=0.1}",
                                     "hard/pde/bearing{eccentricity=0.9}",
                                     "hard/pde/bearing{eccentricity=0.99}",
                                     "hard/pde/membrane{m=14}",
                                     "hard/ray/barely-feasible{bits=10}",
                                     "hard/ray/barely-feasible{bits=20}",
                                     "hard/ray/barely-infeasible",
                                     "hard/ray/barely-infeasible{bits=30}",
                                     "hard/ray/barely-infeasible{bits=40}",
                                     "hard/ray/barely-infeasible{bits=50}",
                                     "hard/ray/copositive-solvable{scale=-40}",
                                     "hard/ray/infeasible{scale=-40}",
                                     "hard/scaling/columns{range=0}",
                                     "hard/scaling/rows",
                                     "hard/scaling/rows{range=0}",
                                     "hard/scaling/rows{range=10}",
                                     "hard/scaling/rows{range=20}",
                                     "hard/scaling/small-block",
                                     "hard/scaling/small-block{bits=10}",
                                     "hard/scaling/small-block{bits=20}",
                                     "hard/scaling/small-block{bits=30}",
                                     "hard/scaling/small-block{bits=100}",
                                     "hard/scaling/symmetric",
                                     "hard/scaling/symmetric{range=0}",
                                     "hard/scaling/symmetric{range=20}"};

TEST(ClaimsTest, HoldOnTheHardCasesWhereTheyDidNot) {
  for (const char* name : kHard) {
    const Problem problem = open_set(name)->generate(1, 0);
    Evaluator evaluator(problem);
    const bool unsolvable = std::string(name).find("infeasible") != std::string::npos;
    for (const std::string& solver : native_solvers()) expect_honest(solver, problem, evaluator, unsolvable);
  }
}

struct Trial {
  const char* set;
  std::uint64_t seed;
  std::int64_t trial;
};

/// M as rounded is another problem: its exact solution is none of the contacts'.
TEST(ClaimsTest, HoldOnThePapersProblemsWhereTheyDidNot) {
  for (const auto& [set, seed, trial] :
       {Trial{"paper/monotone/exp4", 1, 11036}, Trial{"paper/monotone/exp5-1e10", 1, 900},
        Trial{"paper/monotone/exp5-1e10", 1, 1616}, Trial{"paper/monotone/exp5-1e10{redundancy=combination}", 1, 123},
        Trial{"paper/monotone/exp5-1e10{redundancy=combination}", 1, 297}}) {
    const Problem problem = open_set(set)->generate(seed, trial);
    Evaluator evaluator(problem);
    for (const std::string& solver : native_solvers()) expect_honest(solver, problem, evaluator, false);
  }
}

std::int64_t allocations_of_second_solve(const std::string& name, const Problem& problem) {
  const auto solver = make_solver(parse_spec(name));
  solver->load(problem);
  Answer answer;
  solver->solve({}, answer);  // its storage is reused below
  return testing::count_allocations([&] { solver->solve({}, answer); });
}

/// What passes any test of its residual.
Vector unconfirmed_answer(const Problem& problem) {
  const auto solver = make_solver(parse_spec("primal_dual{test=none}"));
  Answer answer;
  solver->load(problem);
  solver->solve({}, answer);
  EXPECT_EQ(answer.claim, Claim::kSolved);
  return answer.z;
}

// A contact that nothing moves has an offset below zero, which is zero in units of the largest one; the velocity of a
// light coordinate is zero in a unit that fits its inertia; contacts have velocities beyond double.
TEST(ClaimsTest, AreNotMadeAtTheEndsOfTheRangeOfDouble) {
  struct Case {
    Vector v;
    Matrix N;
    Matrix G;
    Vector b;
    bool unsolvable;
  };
  const Matrix one = Matrix::Identity(1, 1), light = Eigen::Vector2d(1, 1e-290).asDiagonal();
  const std::vector<Case> cases{
      {vector_of({1}), Matrix{{0, 0}}, one, vector_of({-1e-200, 1e150}), true},
      {vector_of({1}), Matrix{{0, 1}}, one, vector_of({-1e-200, -1e150}), true},
      {vector_of({1}), Matrix{{0, 1}}, one, vector_of({-1.7e-312, -1e200}), true},
      {vector_of({1, -4e-207}), Matrix{{0}, {1}}, light, Vector(), false},
      {vector_of({-6e194}), Matrix{{3e192}}, one, Vector(), false},
      {vector_of({5e199}), Matrix{{-2e110, 1}}, one, Vector(), false}};
  for (const Case& each : cases) {
    ContactProblem contact = frictionless(each.v, each.N, DenseInertia{each.G});
    contact.b = each.b;
    const Problem problem("case " + std::to_string(&each - cases.data()), contact);
    Evaluator evaluator(problem);
    for (const std::string& solver : native_solvers()) expect_honest(solver, problem, evaluator, each.unsolvable);
  }
}

// Singular inertia, and no solution by 2e-6: answers to it pass any test of their residual.
TEST(ClaimsTest, AreNotMadeWhereAProblemOfThePaperMissesItsSolution) {
  const Problem problem = open_set("paper/monotone/exp3")->generate(1, 4860);
  for (const std::string& solver : native_solvers()) EXPECT_NE(solve(solver, problem).claim, Claim::kSolved) << solver;
  const Answer answer = solve("primal_dual", problem);
  ASSERT_EQ(answer.claim, Claim::kUnsolvable);
  EXPECT_LT(problem.contact()->v.dot(to_dense(problem.contact()->N) * answer.farkas), 0);
}

// Confirming such answers may take longer than finding them.
TEST(ClaimsTest, AreConfirmedInTimeOrNotMade) {
  const Problem problem = open_set("paper/monotone/exp3")->generate(1, 4860);
  AnswerTest test;
  test.load(problem);
  Answer answer;
  answer.z = unconfirmed_answer(problem);
  answer.claim = Claim::kSolved;
  EXPECT_FALSE(test.settle(answer, wall_clock_s()));
  EXPECT_EQ(answer.claim, Claim::kTimeLimit);
  EXPECT_EQ(answer.farkas.size(), 0);
  answer.claim = Claim::kSolved;
  EXPECT_FALSE(test.settle(answer, wall_clock_s() + kTimeLimit_s));
  EXPECT_EQ(answer.claim, Claim::kUnsolvable);
}

Problem with_velocity(const Problem& problem, const Vector& v) {
  ContactProblem contact = *problem.contact();
  contact.v = v;
  return {problem.name(), std::move(contact)};
}

/// The same contacts, whose impulses miss a solution by `share` of what they did.
Problem nearly_solvable(const Problem& problem, const Vector& farkas, double share) {
  const ContactProblem& contact = *problem.contact();
  const Vector p = to_dense(contact.N) * farkas;
  return with_velocity(problem, contact.v - (1 - share) * contact.v.dot(p) / p.squaredNorm() * p);
}

/// Frictional problems take the others too long.
std::vector<std::string> solvers_of(const Problem& problem) {
  if (!problem.contact()->frictional()) return native_solvers();
  return {"lemke", "regularized", "friction_ipm", "proximal_newton", "quickstep_sor", "auto"};
}

TEST(ClaimsTest, LeaveNoMoreThanTheSureResidualHoweverLittleContactsMissTheirSolution) {
  constexpr int kProblems = 2;
  for (const char* set :
       {"paper/monotone/exp3", "paper/monotone/exp4{redundancy=combination}", "paper/copositive/exp3"}) {
    int unsolvable = 0;
    for (std::int64_t trial = 0; unsolvable < kProblems; ++trial) {
      const Problem problem = open_set(set)->generate(1, trial);
      const Answer disproof = solve("contact_lemke", problem);
      if (disproof.claim != Claim::kUnsolvable) continue;
      ++unsolvable;
      for (const double share : {1e-3, 1e-5, 1e-7}) {
        const Problem nearly = nearly_solvable(problem, disproof.farkas, share);
        Evaluator evaluator(nearly);
        for (const std::string& solver : solvers_of(nearly)) {
          const Answer answer = solve(solver, nearly);
          if (answer.claim != Claim::kSolved) continue;
          EXPECT_LE(evaluator.errors(answer).velocity_residual_relative, kSureResidual)
              << solver << ", " << set << ", " << trial << ", " << share;
        }
      }
    }
  }
}

// Where friction alone leaves no solution there is no ray to prove it by: what is claimed there is as good as exact.
TEST(ClaimsTest, AreNotMadeWhereFrictionMissesItsSolutionByLittle) {
  constexpr int kProblems = 2;
  constexpr int kHalvings = 22;
  int unsolved = 0;
  for (std::int64_t trial = 0; unsolved < kProblems; ++trial) {
    const Problem problem = open_set("paper/copositive/exp3")->generate(1, trial);
    const auto is_solved = [&](const Vector& v) {
      return solve("contact_lemke", with_velocity(problem, v)).claim == Claim::kSolved;
    };
    Vector without = problem.contact()->v;
    Vector with = without.reverse();
    if (is_solved(without) || !is_solved(with)) continue;
    ++unsolved;
    for (int k = 0; k < kHalvings; ++k) {
      const Vector middle = (with + without) / 2;
      (is_solved(middle) ? with : without) = middle;
    }
    const Problem nearly = with_velocity(problem, without);
    Evaluator evaluator(nearly);
    for (const std::string& solver : solvers_of(nearly)) {
      const Answer answer = solve(solver, nearly);
      if (answer.claim != Claim::kSolved) continue;
      EXPECT_LE(evaluator.errors(answer).velocity_residual_relative, 2e-10) << solver << ", " << trial;
    }
    EXPECT_EQ(allocations_of_second_solve("lemke", nearly), 0) << trial;
  }
}

TEST(ClaimsTest, HoldOnThePapersFrictionalProblemsWhereTheyDidNot) {
  for (const auto& [set, seed, trial] :
       {Trial{"paper/copositive/exp4", 20261122, 1044}, Trial{"paper/copositive/exp5-1e10", 20261122, 235},
        Trial{"paper/copositive/exp5-1e10{redundancy=combination}", 20261122, 34}}) {
    const Problem problem = open_set(set)->generate(seed, trial);
    Evaluator evaluator(problem);
    for (const char* solver : {"lemke", "regularized", "contact_lemke", "auto"}) {
      expect_honest(solver, problem, evaluator, false);
    }
  }
}

// The test is what makes the difference: without it these claims are made.
TEST(ClaimsTest, AreFalseWithoutTheTest) {
  const auto claims_falsely = [](const std::string& solver, const Problem& problem) {
    const Answer answer = solve(solver, problem);
    return answer.claim == Claim::kSolved && !Evaluator(problem).errors(answer).solved;
  };
  EXPECT_TRUE(claims_falsely("lemke{test=none}", open_set("hard/scaling/symmetric")->generate(1, 0)));
  EXPECT_TRUE(claims_falsely("regularized{test=original}", open_set("hard/scaling/rows")->generate(1, 0)));
  EXPECT_TRUE(claims_falsely("primal_dual{test=none}", open_set("paper/monotone/exp4")->generate(1, 11036)));
}

// Two plates close on a ball, by less than any tolerance sees: what almost solves it proves that nothing does.
TEST(ClaimsTest, ProveUnsolvableWhatIsNearlySolvable) {
  for (const char* bits : {"30", "40", "50", "52"}) {
    const Problem problem = open_set("hard/ray/barely-infeasible{bits=" + std::string(bits) + "}")->generate(1, 0);
    for (const char* solver : {"lemke", "psor", "primal_dual", "regularized", "auto"}) {
      const Answer answer = solve(solver, problem);
      EXPECT_EQ(answer.claim, Claim::kUnsolvable) << solver << ", " << bits;
      EXPECT_TRUE(Evaluator(problem).check_farkas(answer.farkas)) << solver << ", " << bits;
    }
  }
}

// Who sets a slack that moves the answer gets the published method's claim, where no test is asked for.
TEST(ClaimsTest, TolerancesOfOnesOwnMeanThePublishedMethod) {
  const Problem problem("slack", Lcp{Matrix::Identity(1, 1), Vector::Constant(1, -1.0)});
  EXPECT_EQ(solve("lemke{zero_tolerance=2,test=residual}", problem).claim, Claim::kNumericalFailure);
  EXPECT_EQ(solve("lemke{zero_tolerance=2,test=none}", problem).claim, Claim::kSolved);
  EXPECT_EQ(solve("lemke{zero_tolerance=2}", problem).claim, Claim::kSolved);
  EXPECT_EQ(solve("lemke{engine=dense,zero_tolerance=2}", problem).claim, Claim::kSolved);
}

// Every stage of auto's ladder for bare LCPs but the enumeration.
TEST(ClaimsTest, AutoAllocatesNothingOnTheHardBareProblems) {
  for (const char* name : {"hard/exponential/upper{n=16}", "hard/ill-conditioned/pascal",
                           "hard/ray/barely-infeasible{bits=40}", "hard/game/coordination{strategies=10}"}) {
    EXPECT_EQ(allocations_of_second_solve("auto", open_set(name)->generate(1, 0)), 0) << name;
  }
}

// An answer to contacts of bodies is tested in 113 bits, which takes dozens of times as long, only if 113 bits could
// accept it.
TEST(ClaimsTest, OfBodiesAreFarOffInDoubleOnlyIfTheyAre) {
  ContactProblem contact;
  contact.inertia = BlockInertia{{Matrix::Identity(2, 2), Matrix::Identity(1, 1)}};
  contact.N = Matrix{{0, 1, 0}}.transpose();
  contact.D = Matrix{{1, 0, 0}, {-1, 0, 0}}.transpose();
  contact.edges = {2};
  contact.mu = Vector{{0.5}};
  contact.v = Vector{{0.25, -1, 0}};
  BodiesTest test;
  test.load(contact, nullptr);
  test.set_velocity(contact.v);
  for (const double residual : {0.0, 1e-6, 1e-4, 1e-2, 0.1}) {
    Vector z{{1 - residual, 0, 0.25, 0}};
    const contact_lemke::Residual found = test.complete_in_double(z);
    EXPECT_NEAR(found.velocity, residual, 1e-14);
    EXPECT_LE(test.least(), residual);
    EXPECT_GE(test.least(), 0.49 * residual - 1e-13) << "half of it, and rounding of a few terms";
  }
}

/// Two bodies of which one has a nearly singular inertia: double cannot confirm an answer, 113 bits do.
Problem nearly_singular_bodies() {
  const Matrix nearly_singular{{81.0000000000001, 54}, {54, 36.0000000000001}};
  ContactProblem contact;
  contact.v = Vector{{-0.6, 0.5, -1, 1}};
  contact.N = Matrix{{-1, -4, 0, 0}, {0, -1, 1, 0}}.transpose();
  contact.D = Matrix(4, 0);
  contact.edges = {0, 0};
  contact.mu = Vector::Zero(2);
  contact.inertia = BlockInertia{{nearly_singular, Matrix::Identity(2, 2)}};
  return Problem("nearly singular", contact);
}

// 113 bits take long: whoever shares out work counts them, and a deadline comes before them.
TEST(ClaimsTest, OfBodiesInQuadCountAsWorkAndObeyTheDeadline) {
  const Problem problem = nearly_singular_bodies();
  const Answer solution = solve("contact_lemke", problem);
  ASSERT_EQ(solution.claim, Claim::kSolved);
  AnswerTest test;
  test.load(problem, AnswerTest::Bodies::kOneByOne);
  Answer answer = solution;
  EXPECT_TRUE(test.settle(answer, std::numeric_limits<double>::infinity()));
  EXPECT_GT(test.work_in_quad(), 0);
  answer = solution;
  EXPECT_FALSE(test.settle(answer, 0));
  EXPECT_EQ(answer.claim, Claim::kTimeLimit);
  EXPECT_EQ(test.work_in_quad(), 0);
  // What double decides takes no 113 bits, and no time.
  ContactProblem regular = *problem.contact();
  regular.inertia = BlockInertia{{Matrix::Identity(2, 2), Matrix::Identity(2, 2)}};
  const Problem other("regular", regular);
  test.load(other, AnswerTest::Bodies::kOneByOne);
  answer = solution;
  answer.z.setConstant(2);
  EXPECT_FALSE(test.settle(answer, 0));
  EXPECT_EQ(answer.claim, Claim::kNumericalFailure);
  EXPECT_EQ(test.work_in_quad(), 0);
}

// Their test of an answer needs no memory either, also where the inertia is nearly singular.
TEST(ClaimsTest, AreTestedWithoutAllocationOnContacts) {
  const Problem problem = nearly_singular_bodies();
  for (const char* name : {"auto", "active_set", "contact_lemke", "velocity_ipm", "friction_ipm", "psor",
                           "quickstep_sor", "primal_dual"}) {
    EXPECT_EQ(allocations_of_second_solve(name, problem), 0) << name;
  }
}

}  // namespace
}  // namespace lcpbench::claims_test
