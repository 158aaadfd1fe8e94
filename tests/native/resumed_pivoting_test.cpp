#include <cmath>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "generators/sets.h"
#include "native/active_set/active_set.h"
#include "native/contact_lemke/contact_lemke.h"
#include "study/evaluation/evaluation.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/textbook_lcps.h"

// contact_lemke and active_set, solved in parts.

namespace lcpbench::resumed_pivoting_test {
namespace {

using testing::Uniform;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The problem on the inertia X X' with X of one column less than rows: it may have no solution, or nearly have one.
Problem on_singular_inertia(const Problem& problem, Uniform& uniform) {
  ContactProblem contact = *problem.contact();
  const Index factors = contact.ngc() - 1;
  contact.inertia = FactoredInertia{uniform.matrix(contact.ngc(), factors), Vector::Ones(factors)};
  return Problem("singular " + problem.name(), contact);
}

Problem with_offsets(const Problem& problem, Uniform& uniform) {
  ContactProblem contact = *problem.contact();
  contact.b = 0.1 * contact.v.lpNorm<Eigen::Infinity>() * uniform.vector(contact.nc());
  return Problem("offset " + problem.name(), contact);
}

/// Of each set some problems, each as it is, on singular inertia and with offsets.
std::vector<Problem> problems_of(const std::vector<std::string>& sets, std::int64_t trials) {
  Uniform uniform(7);
  std::vector<Problem> problems;
  for (const std::string& set : sets) {
    for (std::int64_t trial = 0; trial < trials; ++trial) {
      const Problem problem = open_set(set)->generate(91, trial);
      problems.push_back(problem);
      problems.push_back(on_singular_inertia(problem, uniform));
      problems.push_back(with_offsets(problem, uniform));
    }
  }
  return problems;
}

std::vector<std::string> paper_sets(const std::string& kind) {
  std::vector<std::string> sets;
  for (const char* experiment : {"exp1", "exp2", "exp3", "exp4", "exp5-1e10{redundancy=combination}"}) {
    sets.push_back("paper/" + kind + "/" + experiment);
  }
  return sets;
}

/// The best answer so far has the residual that the evaluation finds, or is none. What rounding leaves of either on an
/// ill-conditioned inertia differs.
void expect_true_residual(ResumableSolver& solver, const Problem& problem, Evaluator& evaluator) {
  Answer answer;
  answer.z.resize(problem.size());
  Vector z = Vector::Constant(problem.size(), 7);
  const double residual = solver.best(z);
  if (residual == kInfinity) {
    EXPECT_EQ(z, Vector::Constant(problem.size(), 7)) << problem.name();
    return;
  }
  answer.z = z;
  const double evaluated = evaluator.errors(answer).velocity_residual_relative;
  EXPECT_LE(evaluated, 1.5 * residual + 1e-6) << problem.name();
  EXPECT_LE(residual, 1.5 * evaluated + 1e-6) << problem.name();
}

/// Random parts, in some solves of a pivot or less, in others of hundreds. @returns how many there were
int solve_in_parts(ResumableSolver& solver, const Problem& problem, const Vector* start, Uniform& uniform,
                   Answer& answer) {
  Evaluator evaluator(problem);
  int parts = 1;
  double work = 0;
  const double largest = std::pow(10, 5 + 2 * uniform());
  solver.begin(start, 0);
  while (!solver.go_on(largest * (1 + uniform()) / 2, kInfinity, answer)) {
    EXPECT_GT(solver.work(), work) << problem.name();  // else nobody would ever come to the end
    work = solver.work();
    ++parts;
    if ((parts & (parts - 1)) == 0) expect_true_residual(solver, problem, evaluator);
  }
  expect_true_residual(solver, problem, evaluator);
  return parts;
}

void expect_same(const Answer& answer, const Answer& expected, const std::string& what) {
  EXPECT_EQ(answer.claim, expected.claim) << what;
  EXPECT_EQ(answer.z, expected.z) << what;
  EXPECT_EQ(answer.velocity, expected.velocity) << what;
  EXPECT_EQ(answer.farkas, expected.farkas) << what;
  EXPECT_EQ(answer.detail, expected.detail) << what;
  EXPECT_EQ(answer.counters.pivots, expected.counters.pivots) << what;
  EXPECT_EQ(answer.counters.iterations, expected.counters.iterations) << what;
  EXPECT_EQ(answer.counters.factorizations, expected.counters.factorizations) << what;
}

/// One solver in one part and another in many come to the same: at first, from there at other velocities, and anew
/// after a solve that was given up. @returns the parts, of all problems
template <class Settings, class Method>
int expect_same_in_parts(const Settings& settings, const std::vector<Problem>& problems, int steps = 3) {
  Uniform uniform(17);
  Method whole(settings), in_parts(settings);
  int parts = 0;
  for (const Problem& problem : problems) {
    whole.load(problem);
    in_parts.load(problem);
    Answer expected, answer;
    whole.solve({}, expected);
    parts += solve_in_parts(in_parts, problem, nullptr, uniform, answer);
    expect_same(answer, expected, problem.name());
    for (int step = 0; step < steps; ++step) {
      ContactProblem moved = *problem.contact();
      moved.v += 0.1 * moved.v.norm() * uniform.vector(moved.v.size());
      const Problem now(problem.name() + ", step " + std::to_string(step), moved);
      whole.update(moved.v);
      in_parts.update(moved.v);
      const Vector start = expected.z;
      if (step == 1) {
        in_parts.begin(nullptr, 0);
        in_parts.go_on(1e5, kInfinity, answer);
        whole.solve({}, expected);  // the basis that `start` belongs to may be gone
        solve_in_parts(in_parts, now, nullptr, uniform, answer);
      } else {
        whole.solve({.start = &start}, expected);
        parts += solve_in_parts(in_parts, now, &start, uniform, answer);
      }
      expect_same(answer, expected, now.name());
    }
  }
  return parts;
}

TEST(ResumedPivotingTest, ContactLemkeComesToTheSameInParts) {
  std::vector<std::string> sets = paper_sets("copositive");
  sets.insert(sets.end(), {"scene/hand/mujoco", "scene/humanoid-lying/mujoco"});
  const std::vector<Problem> problems = problems_of(sets, 2);
  const int parts = expect_same_in_parts<ContactLemkeSettings, ContactLemke>({}, problems);
  EXPECT_GT(parts, 4 * static_cast<int>(problems.size()));
}

// Stages that follow one another, a path that cycles and one of many pivots.
TEST(ResumedPivotingTest, ContactLemkeComesToTheSameInPartsOnEveryStage) {
  ContactLemkeSettings settings;
  settings.accept_residual = 0;
  using enum ContactLemkePrecision;
  for (const auto precision : {kCascade, kDouble, kQuad}) {
    settings.precision = precision;
    expect_same_in_parts<ContactLemkeSettings, ContactLemke>(
        settings, problems_of({"paper/copositive/exp5-1e8", "paper/monotone/exp2"}, 1));
  }
  const auto lying = open_set("scene/humanoid-lying/mujoco");
  expect_same_in_parts<ContactLemkeSettings, ContactLemke>(
      {}, {lying->generate(1, 1), lying->generate(1, 9), lying->generate(1, 9),
           open_set("scene/stack/dart")->generate(1, 1)});
  settings.precision = kDouble;  // more bits would take a hundred times as long for the same pivots
  const auto of_many_pivots = open_set("paper/copositive/extra100{redundancy=combination}");
  expect_same_in_parts<ContactLemkeSettings, ContactLemke>(settings, {of_many_pivots->generate(555777, 0)}, 0);
}

TEST(ResumedPivotingTest, ActiveSetComesToTheSameInParts) {
  const std::vector<Problem> problems = problems_of(paper_sets("monotone"), 6);
  const int parts = expect_same_in_parts<ActiveSetSettings, ActiveSet>({}, problems);
  EXPECT_GT(parts, 4 * static_cast<int>(problems.size()));
  for (const auto precision : {ActiveSetPrecision::kDouble, ActiveSetPrecision::kQuad}) {
    ActiveSetSettings settings;
    settings.precision = precision;
    expect_same_in_parts<ActiveSetSettings, ActiveSet>(settings, problems_of({"paper/monotone/exp2"}, 3));
  }
  ActiveSetSettings strict;  // climbs to the last stage
  strict.accept_residual = 0;
  expect_same_in_parts<ActiveSetSettings, ActiveSet>(strict, problems_of({"paper/monotone/exp2"}, 3));
}

// Solvers that share the engines beyond double may take them from each other between two parts.
TEST(ResumedPivotingTest, AnEngineThatIsTakenIsLoadedAgain) {
  ContactLemkeSettings settings;
  settings.precision = ContactLemkePrecision::kQuad;
  const auto later = std::make_shared<LaterEngines>();
  const Problem problems[] = {open_set("paper/copositive/exp2")->generate(41, 1),
                              open_set("paper/copositive/exp5-1e8")->generate(41, 2)};
  ContactLemke shared[] = {{settings, later}, {settings, later}};
  Answer expected[2], answers[2];
  bool has_ended[] = {false, false};
  for (int k = 0; k < 2; ++k) {
    ContactLemke alone(settings);
    alone.load(problems[k]);
    alone.solve({}, expected[k]);
    shared[k].load(problems[k]);
    shared[k].begin(nullptr, 0);
  }
  double work = 1e4;  // a path that has to begin anew needs more than the last time
  while (!has_ended[0] || !has_ended[1]) {
    for (int k = 0; k < 2; ++k) {
      if (!has_ended[k]) has_ended[k] = shared[k].go_on(work *= 1.2, kInfinity, answers[k]);
    }
  }
  for (int k = 0; k < 2; ++k) expect_same(answers[k], expected[k], problems[k].name());
}

template <class Method>
void expect_no_allocations(Method&& solver, const std::vector<Problem>& problems) {
  for (const Problem& problem : problems) {
    solver.load(problem);
    Answer answer;
    answer.reserve(problem);
    const auto work = [&] {
      solver.begin(nullptr, 1e-4);
      while (!solver.go_on(1e4, kInfinity, answer)) continue;
    };
    EXPECT_EQ(testing::count_allocations(work), 0) << problem.name();
  }
}

TEST(ResumedPivotingTest, PartsAllocateNothing) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "allocations cannot be counted in this build";
  std::vector<Problem> problems;
  for (std::int64_t trial = 0; trial < 6; ++trial) {
    problems.push_back(open_set("paper/monotone/exp5-1e10{redundancy=combination}")->generate(52, trial));
  }
  expect_no_allocations(ActiveSet(ActiveSetSettings{}), problems);
  for (std::int64_t trial = 0; trial < 6; ++trial) {
    problems.push_back(open_set("paper/copositive/exp5-1e10{redundancy=combination}")->generate(52, trial));
  }
  ContactLemkeSettings strict;
  strict.accept_residual = 0;
  expect_no_allocations(ContactLemke(strict), problems);
  ContactLemkeSettings quad;
  quad.precision = ContactLemkePrecision::kQuad;
  expect_no_allocations(ContactLemke(quad), problems);
}

TEST(ResumedPivotingTest, ADeadlineEndsAPart) {
  const Problem problem = open_set("paper/monotone/exp1")->generate(1, 1);
  const auto expect_late = [&](ResumableSolver& solver) {
    solver.load(problem);
    solver.begin(nullptr, 0);
    Answer answer;
    ASSERT_TRUE(solver.go_on(kInfinity, 0, answer));
    EXPECT_EQ(answer.claim, Claim::kTimeLimit);
    EXPECT_EQ(answer.z, Vector::Zero(problem.size()));
  };
  ContactLemke lemke{ContactLemkeSettings{}};
  ActiveSet active_set{ActiveSetSettings{}};
  expect_late(lemke);
  expect_late(active_set);
}

// An error below what the default accepts asks for more; a larger one for no less.
TEST(ResumedPivotingTest, ContactLemkeClimbsToTheStatedError) {
  const Problem problem = open_set("paper/copositive/exp5-1e8")->generate(62, 5);
  ContactLemke solver{ContactLemkeSettings{}};
  solver.load(problem);
  const auto pivots = [&](double error) {
    Answer answer;
    solver.begin(nullptr, error);
    EXPECT_TRUE(solver.go_on(kInfinity, kInfinity, answer));
    EXPECT_EQ(answer.claim, Claim::kSolved);
    return answer.counters.pivots;
  };
  EXPECT_EQ(pivots(1e-2), pivots(0));
  EXPECT_GT(pivots(1e-30), 2 * pivots(0));
}

}  // namespace
}  // namespace lcpbench::resumed_pivoting_test
