#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/islands.h"
#include "core/scene.h"
#include "generators/sets.h"
#include "native/active_set/active_set.h"
#include "native/contact_ipm/contact_ipm.h"
#include "native/contact_lemke/contact_lemke.h"
#include "native/contacts/budgeted_solver.h"
#include "native/friction_ipm/friction_ipm.h"
#include "native/contact_lemke/contact_farkas.h"
#include "native/proximal_newton/proximal_newton.h"
#include "native/sor/psor.h"
#include "native/velocity_ipm/velocity_ipm.h"
#include "study/evaluation/evaluation.h"
#include "tests/support/brick_wall.h"
#include "tests/support/sphere_piles.h"
#include "tests/support/allocation_counter.h"

namespace lcpbench::budgeted_test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Method {
  std::string name;
  std::unique_ptr<BudgetedSolver> solver;
};

std::vector<Method> methods() {
  std::vector<Method> all;
  all.push_back({"psor", make_psor({.max_iterations = 2000})});
  all.push_back({"psor of sweeps alone", make_psor({.max_iterations = 500, .parts = PsorSettings::Parts::kNone})});
  all.push_back({"friction_ipm", make_friction_ipm()});
  all.push_back({"proximal_newton", make_proximal_newton()});
  all.push_back({"contact_ipm", make_contact_ipm()});
  all.push_back({"velocity_ipm", make_velocity_ipm()});
  ContactLemkeSettings quad, strict;
  quad.precision = ContactLemkePrecision::kQuad;
  strict.accept_residual = 0;  // climbs to the last stage
  all.push_back({"contact_lemke", std::make_unique<ContactLemke>(ContactLemkeSettings{})});
  all.push_back({"contact_lemke in 113 bits", std::make_unique<ContactLemke>(quad)});
  all.push_back({"contact_lemke on every stage", std::make_unique<ContactLemke>(strict)});
  all.push_back({"active_set", std::make_unique<ActiveSet>(ActiveSetSettings{})});
  return all;
}

/// The problem with offsets of the size of one step's gravity, some of them below zero.
Problem with_offsets(const Problem& problem) {
  ContactProblem contact = *problem.contact();
  contact.b.resize(contact.nc());
  for (Index i = 0; i < contact.nc(); ++i) contact.b(i) = 1e-3 * static_cast<double>(i * 7 % 5 - 1);
  return Problem(problem.name() + " with offsets", std::move(contact));
}

/// Their best impulses are those of a vertex, or none.
bool pivots(const Method& method) {
  return method.name.starts_with("contact_lemke") || method.name.starts_with("active_set");
}

/// Not the interior points on the pile for exact parts: they take long, and end in nothing. Nor pivots on many contacts.
bool takes(const Method& method, const Problem& problem) {
  const bool is_psor = method.name.starts_with("psor");
  return why_not(method.solver->capabilities(), problem).empty() && (is_psor || problem.name() != "rough pile") &&
         !(pivots(method) && problem.size() > 400);
}

std::vector<Problem> problems() {
  std::vector<Problem> all;
  for (const char* name : {"paper/monotone/exp1", "paper/copositive/exp1", "paper/copositive/exp3"}) {
    for (std::int64_t trial = 0; trial < 2; ++trial) all.push_back(open_set(name)->generate(912, trial));
  }
  all.emplace_back("bare", make_lcp(all.front()));
  all.emplace_back("wall", testing::brick_wall(5, 6));
  all.emplace_back("frictional wall", testing::frictional_brick_wall(4, 5, 0.5));
  all.push_back(with_offsets(all.back()));
  all.emplace_back("smooth pile", testing::sphere_pile({.columns = 4, .layers = 4}));
  all.emplace_back("rough pile", testing::sphere_pile({.columns = 6, .mu = 1.5, .seed = 3}));  // in exact parts
  all.push_back(with_offsets(Problem("pile", testing::sphere_pile({.columns = 4, .layers = 5, .mu = 0.5}))));
  all.emplace_back("at rest", [] {
    ContactProblem contact = *open_set("paper/copositive/exp1")->generate(912, 1).contact();
    contact.v.setZero();
    return contact;
  }());
  return all;
}

struct Outcome {
  Answer answer;
  double work = 0, residual = 0;
  bool has_ended = false;
};

/// Where an earlier solve may have left the solver, at another velocity and with another budget.
Outcome solve_within(BudgetedSolver& solver, const Budget& budget = {}) {
  Outcome outcome;
  outcome.has_ended = solver.solve_within(budget, outcome.answer);
  outcome.work = solver.work();
  outcome.residual = solver.residual(outcome.answer);
  return outcome;
}

/// The units of several islands are powers of two. An interior point begins far out, where rounding counts: what is
/// worse than no impulses at all is not compared, with singular inertia what is worse than a tenth of that, nor bare
/// LCPs, which the evaluation measures otherwise.
void expect_residual(const Problem& problem, const Vector& z, double residual) {
  if (problem.contact() == nullptr || residual > (may_be_singular(*problem.contact()) ? 0.1 : 1)) return;
  Answer answer;
  answer.z = z;
  const double found = Evaluator(problem).errors(answer).velocity_residual_relative;
  const bool is_one_island = find_islands(*problem.contact()).size() == 1;
  EXPECT_LE(found, residual * (1 + 1e-6) + 1e-9) << problem.name();
  EXPECT_GE(found, residual * (is_one_island ? 1 : 0.5) * (1 - 1e-6) - 1e-9) << problem.name();
}

void expect_same(const Answer& answer, const Answer& expected, const std::string& what) {
  EXPECT_EQ(answer.claim, expected.claim) << what;
  EXPECT_EQ(answer.detail, expected.detail) << what;
  ASSERT_EQ(answer.farkas.size(), expected.farkas.size()) << what;
  EXPECT_EQ(answer.farkas, expected.farkas) << what;
  ASSERT_EQ(answer.z.size(), expected.z.size()) << what;
  ASSERT_EQ(answer.velocity.size(), expected.velocity.size()) << what;
  EXPECT_EQ(static_cast<const Vector&>(answer.z), expected.z) << what;
  EXPECT_EQ(static_cast<const Vector&>(answer.velocity), expected.velocity) << what;
  EXPECT_EQ(answer.counters.iterations, expected.counters.iterations) << what;
  EXPECT_EQ(answer.counters.pivots, expected.counters.pivots) << what;
  EXPECT_EQ(answer.counters.factorizations, expected.counters.factorizations) << what;
}

// Work depends on the data alone: so that the same turns give the same answer on every machine.
TEST(BudgetedTest, ABudgetEndsTheSolveAndALargerOneChangesNothing) {
  int ended_by_budget = 0;
  for (const Problem& problem : problems()) {
    for (const Method& method : methods()) {
      if (!takes(method, problem)) continue;
      const std::string what = problem.name() + ", " + method.name;
      method.solver->load(problem);
      solve_within(*method.solver);  // the first solve of a problem may prepare what later ones find
      const Outcome whole = solve_within(*method.solver);
      EXPECT_TRUE(whole.has_ended) << what;
      if (whole.answer.claim == Claim::kUnsupported) continue;
      const Vector start = 0.9 * whole.answer.z;
      for (const double share : {0.0, 0.01, 0.3}) {
        for (const Vector* from : {static_cast<const Vector*>(nullptr), &start}) {
          const double work = share * whole.work;
          const Outcome part = solve_within(*method.solver, {.start = from, .error = 1e-12, .work = work});
          expect_residual(problem, part.answer.z, part.residual);
          if (part.has_ended) continue;
          ++ended_by_budget;
          EXPECT_EQ(part.answer.claim, Claim::kIterationLimit) << what;
          EXPECT_GE(part.work, work) << what;
        }
      }
      const Outcome again = solve_within(*method.solver, {.work = 2 * whole.work + 1});
      EXPECT_TRUE(again.has_ended) << what;
      EXPECT_NEAR(again.work, whole.work, 1e-9 * whole.work) << what;  // a difference of sums
      expect_same(again.answer, whole.answer, what);
      Answer solved;
      method.solver->solve({}, solved);
      expect_same(solved, whole.answer, what + " by solve()");
    }
  }
  EXPECT_GE(ended_by_budget, 200);
}

// A path of pivots ends within a few of them, not at its end.
TEST(BudgetedTest, EndsContactLemkeAtItsBudget) {
  const Problem wall("wall", testing::frictional_brick_wall(6, 8, 0.5));
  ContactLemke solver{ContactLemkeSettings{}};
  solver.load(wall);
  const double whole = solve_within(solver).work;
  const Outcome part = solve_within(solver, {.work = whole / 4});
  EXPECT_FALSE(part.has_ended);
  EXPECT_EQ(part.answer.claim, Claim::kIterationLimit);
  EXPECT_GE(part.work, whole / 4);
  EXPECT_LE(part.work, whole / 3);
}

TEST(BudgetedTest, TheStatedErrorIsClaimedAndNoMore) {
  const Problem wall("wall", testing::frictional_brick_wall(6, 8, 0.5));
  for (const Method& method : methods()) {
    if (pivots(method) || !why_not(method.solver->capabilities(), wall).empty()) continue;
    method.solver->load(wall);
    const Outcome rough = solve_within(*method.solver, {.error = 1e-2});
    const Outcome full = solve_within(*method.solver);
    ASSERT_EQ(rough.answer.claim, Claim::kSolved) << method.name;
    EXPECT_LE(Evaluator(wall).errors(rough.answer).velocity_residual_relative, 1.01e-2) << method.name;
    EXPECT_LT(rough.work, full.work) << method.name;
    Answer solved;  // the error of the last solve_within() is not that of a solve
    solve_within(*method.solver, {.error = 1e-2});
    method.solver->solve({}, solved);
    expect_same(solved, full.answer, method.name);
  }
}

TEST(BudgetedTest, SolvesAllocateNothing) {
  for (const Problem& problem : problems()) {
    for (const Method& method : methods()) {
      if (!takes(method, problem) || !method.solver->capabilities().allocation_free) continue;
      method.solver->load(problem);
      Answer answer;
      answer.reserve(problem);
      const Vector start = Vector::Ones(problem.size());
      const double work = 0.5 * solve_within(*method.solver).work;
      EXPECT_EQ(testing::count_allocations([&] {
                  method.solver->solve_within({.start = &start, .error = 1e-6, .work = work}, answer);
                  method.solver->residual(answer);
                }),
                0)
          << problem.name() << ", " << method.name;
    }
  }
}

}  // namespace
}  // namespace lcpbench::budgeted_test
