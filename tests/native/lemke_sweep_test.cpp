#include "native/lemke/lemke_sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/registry.h"
#include "core/swept_answers.h"
#include "generators/sets.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench {

SolverDefinition lcpbench_solver_lemke();
SolverDefinition lcpbench_solver_primal_dual();
SolverDefinition lcpbench_solver_regularized();

// The registry of this test: what `regularized` can wrap here.
const std::vector<RegisteredSolver>& registered_solvers() {
  static const std::vector<RegisteredSolver> solvers{{lcpbench_solver_lemke(), "native", "", "", ""},
                                                     {lcpbench_solver_primal_dual(), "native", "", "", ""},
                                                     {lcpbench_solver_regularized(), "native", "", "", ""}};
  return solvers;
}

namespace {

using testing::matrix_of;
using testing::vector_of;

using Cells = std::vector<LemkeSettings>;

LemkeSettings cell(double pivot_tolerance, double zero_tolerance, LemkeSettings common = {}) {
  common.pivot_tolerance = pivot_tolerance;
  common.zero_tolerance = zero_tolerance;
  common.test = LemkeAnswerTest::kNone;  // paths end in the tree as in LEMKE
  return common;
}

/// The paper's 81 pairs: each tolerance 1e-20, 1e-18, ... 1e-4.
Cells paper_grid(const LemkeSettings& common = {}) {
  Cells cells;
  for (int pivot = -20; pivot <= -4; pivot += 2) {
    for (int zero = -20; zero <= -4; zero += 2) {
      cells.push_back(cell(std::pow(10.0, pivot), std::pow(10.0, zero), common));
    }
  }
  return cells;
}

/// Pairs in no order and on no grid, zeros, large tolerances and repetitions among them.
Cells scattered_cells(const LemkeSettings& common) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> exponent(-20, 0);
  Cells cells{cell(0, 0, common), cell(0.5, 1e-3, common), cell(0, 10, common)};
  for (int i = 0; i < 40; ++i) {
    cells.push_back(cell(std::pow(10.0, exponent(random)), std::pow(10.0, exponent(random)), common));
    if (i % 5 == 0) cells.push_back(cells[cells.size() / 2]);
  }
  return cells;
}

Problem bare(Matrix M, Vector q) { return Problem("test", Lcp{std::move(M), std::move(q)}); }

std::vector<Options> options_of(const Cells& cells) {
  std::vector<Options> options;
  for (const LemkeSettings& settings : cells) options.push_back(all_settings(settings));
  return options;
}

std::vector<IsaLevel> levels_of_this_machine() {
  std::vector<IsaLevel> levels;
  for (const IsaLevel level : {IsaLevel::kBaseline, IsaLevel::kAvx2, IsaLevel::kAvx512}) {
    if (level <= best_isa_level()) levels.push_back(level);
  }
  return levels;
}

std::vector<LemkeTry> all_of(std::size_t cells, double time_limit_s = std::numeric_limits<double>::infinity()) {
  std::vector<LemkeTry> tries(cells);
  for (std::size_t i = 0; i < cells; ++i) tries[i] = {static_cast<std::uint32_t>(i), time_limit_s};
  return tries;
}

/// Fails where a leaf differs from what its cells answer by themselves, or a cell is in no leaf or in two.
/// Returns the number of leaves.
std::size_t expect_same_as_alone(LemkeSweep& sweep, const Cells& cells, const Problem& problem, IsaLevel level) {
  std::vector<LemkeLeaf> leaves;
  sweep.load(problem);
  sweep.walk(all_of(cells.size()), leaves);
  std::vector<int> seen(cells.size(), 0);
  for (const LemkeLeaf& leaf : leaves) {
    EXPECT_TRUE(std::is_sorted(leaf.cells.begin(), leaf.cells.end()));
    for (const std::uint32_t number : leaf.cells) {
      ++seen[number];
      Lemke alone(cells[number], level);
      Answer answer;
      alone.load(problem);
      alone.solve({}, answer);
      EXPECT_TRUE(same_answer(answer, leaf.answer))
          << problem.name() << ", " << to_string(level) << ", cell " << number << ": " << to_string(leaf.answer.claim)
          << " after " << leaf.answer.counters.pivots << " pivots, alone " << to_string(answer.claim) << " after "
          << answer.counters.pivots;
    }
  }
  EXPECT_EQ(seen, std::vector<int>(cells.size(), 1)) << problem.name();
  return leaves.size();
}

/// The same for trials of a set at every level. Trees must have parted on a good share of them, or little was tested.
void expect_same_on(const std::string& set_name, std::int64_t trials, const Cells& cells) {
  const auto set = open_set(set_name);
  for (const IsaLevel level : levels_of_this_machine()) {
    LemkeSweep sweep(cells, level);
    std::size_t leaves = 0;
    for (std::int64_t trial = 0; trial < trials; ++trial) {
      leaves += expect_same_as_alone(sweep, cells, set->generate(9, trial), level);
    }
    EXPECT_GT(4 * leaves, static_cast<std::size_t>(5 * trials)) << set_name;
  }
}

class LemkeSweepTest : public ::testing::TestWithParam<LemkeUpdate> {
 protected:
  static LemkeSettings common() { return {.update = GetParam()}; }
};

INSTANTIATE_TEST_SUITE_P(Updates, LemkeSweepTest, ::testing::Values(LemkeUpdate::kResolve, LemkeUpdate::kIncremental),
                         [](const auto& update) {
                           return std::string(update.param == LemkeUpdate::kResolve ? "Resolve" : "Incremental");
                         });

TEST_P(LemkeSweepTest, FrictionlessAnswersAreThoseOfEachCellAlone) {
  for (const char* set : {"paper/monotone/exp2", "paper/monotone/exp4", "paper/monotone/exp5-1e10"}) {
    expect_same_on(set, 100, paper_grid(common()));
  }
  // Few of its paths part.
  const Cells cells = paper_grid(common());
  const auto set = open_set("paper/monotone/exp1");
  LemkeSweep sweep(cells);
  for (std::int64_t trial = 0; trial < 200; ++trial) {
    expect_same_as_alone(sweep, cells, set->generate(9, trial), isa_level());
  }
}

TEST_P(LemkeSweepTest, FrictionalAnswersAreThoseOfEachCellAlone) {
  for (const char* set : {"paper/copositive/exp1", "paper/copositive/exp2", "paper/copositive/exp5-1e8"}) {
    expect_same_on(set, 5, paper_grid({.update = GetParam(), .cap = LemkeCap::k3n}));
  }
}

TEST_P(LemkeSweepTest, AnyListOfCellsWillDo) {
  const Cells cells = scattered_cells(common());
  for (const char* set : {"paper/monotone/exp2", "paper/monotone/exp5-1e8"}) expect_same_on(set, 40, cells);
  expect_same_on("paper/copositive/exp5-1e8", 2, scattered_cells({.update = GetParam(), .cap = LemkeCap::kLemke}));
  expect_same_on("paper/monotone/exp4{redundancy=combination}", 40, cells);
}

TEST_P(LemkeSweepTest, BareMatricesWillDo) {
  const Cells cells = scattered_cells(common());
  LemkeSweep sweep(cells);
  const auto set = open_set("paper/monotone/exp2");
  for (std::int64_t trial = 0; trial < 20; ++trial) {
    expect_same_as_alone(sweep, cells, Problem("matrix", set->generate(2, trial).lcp()), isa_level());
  }
  for (const testing::TextbookLcp& example : testing::textbook_lcps()) {
    expect_same_as_alone(sweep, cells, Problem(example.name, example.lcp), isa_level());
  }
  // Kernels that outgrow the first layout of 64 rows, after and before smaller ones.
  for (const Index n : {0, 1, 150, 3}) {
    expect_same_as_alone(sweep, cells, bare(testing::tridiagonal(n, 4, -1), -testing::ones(n)), isa_level());
  }
}

TEST_P(LemkeSweepTest, PathsPartWhereATolerancePassesAnEntryAndNowhereElse) {
  // d = 0.09: a ray for the tolerance 0.1, else solved; and q = -1e-3 is none for the zero tolerance 1e-2.
  const Cells cells{cell(0.1, 1e-6, common()), cell(0.05, 1e-6, common()), cell(0.1, 1e-2, common()),
                    cell(0.01, 1e-5, common())};
  LemkeSweep sweep(cells);
  EXPECT_EQ(expect_same_as_alone(sweep, cells, bare(matrix_of(1, {0.09}), vector_of({-1e-3})), isa_level()), 3U);
}

TEST(LemkeSweepRulesTest, EqualPivotsWithinTheToleranceDoNotHideAMiddleChoice) {
  // Tied at 0: row 2 alone. From 1e-6 on row 1 as well, equal within 1e-9 and of a lower number: it leaves. From 3e-6
  // on also row 3, next to whose pivot that of row 1 is too small and that of row 2 is not: row 2 leaves again. That
  // both ends choose row 2 says nothing of the middle.
  const double row_1 = 1 - 1.5e-9, row_2 = 1 - 0.9e-9;
  const Problem problem = bare(matrix_of(4, {1, 0, 0, 0, -row_1, 1, 0, 0, -row_2, 0, 1, 0, -1, 0, 0, 1}),
                               vector_of({-5, row_1 * (1 + 1e-6), row_2, 1 + 3e-6}));
  Cells cells;
  for (const double zero : {0.0, 1e-7, 5e-7, 1.5e-6, 2e-6, 2.5e-6, 4e-6, 1e-5}) cells.push_back(cell(1e-10, zero));
  LemkeSweep sweep(cells);
  EXPECT_GT(expect_same_as_alone(sweep, cells, problem, isa_level()), 1U);
}

TEST(LemkeSweepRulesTest, AnswersByTheRulesOf2012AreThoseOfEachCellAlone) {
  // Some of these paths end in numbers that are not finite. Nothing of them may reach the paths that follow.
  const Cells cells = paper_grid({.cap = LemkeCap::kLemke, .rules = LemkeRules::k2012});
  const auto set = open_set("paper/copositive/exp1");
  for (const IsaLevel level : levels_of_this_machine()) {
    LemkeSweep sweep(cells, level);
    for (const std::int64_t trial : {1, 2, 4}) expect_same_as_alone(sweep, cells, set->generate(1, trial), level);
  }
  expect_same_on("paper/monotone/exp4", 40, cells);
}

TEST(LemkeSweepRulesTest, GoesCommonPivotsOnce) {
  const auto set = open_set("paper/copositive/exp1");
  const Cells cells = paper_grid({.cap = LemkeCap::k3n});
  LemkeSweep sweep(cells);
  std::vector<LemkeLeaf> leaves;
  std::int64_t gone_in_all = 0, cells_in_all = 0;
  for (std::int64_t trial = 0; trial < 5; ++trial) {
    sweep.load(set->generate(1, trial));
    const std::int64_t gone = sweep.walk(all_of(cells.size()), leaves);
    std::int64_t of_leaves = 0, longest = 0;
    for (const LemkeLeaf& leaf : leaves) {
      of_leaves += leaf.answer.counters.pivots;
      cells_in_all += leaf.answer.counters.pivots * static_cast<std::int64_t>(leaf.cells.size());
      longest = std::max(longest, leaf.answer.counters.pivots);
    }
    EXPECT_GE(gone, longest);
    EXPECT_LE(gone, of_leaves);
    gone_in_all += gone;
  }
  EXPECT_LT(8 * gone_in_all, cells_in_all);
}

TEST(LemkeSweepRulesTest, PathsThatGoRoundEndAtTheLimitAsIfTheyWereFollowed) {
  LemkeSettings far;
  far.max_pivots = 3001;
  const Cells cells = paper_grid(far);
  LemkeSweep sweep(cells);
  std::vector<LemkeLeaf> leaves;
  std::int64_t at_limit = 0, gone = 0;
  for (const char* name : {"paper/monotone/exp5-1e10", "paper/copositive/exp5-1e8"}) {
    const auto set = open_set(name);
    for (std::int64_t trial = 0; trial < 200; ++trial) {
      const Problem problem = set->generate(9, trial);
      if (problem.size() > 80) continue;
      expect_same_as_alone(sweep, cells, problem, isa_level());
      gone += sweep.walk(all_of(cells.size()), leaves);
      for (const LemkeLeaf& leaf : leaves) {
        if (leaf.answer.claim != Claim::kIterationLimit) continue;
        EXPECT_EQ(leaf.answer.counters.pivots, 3001);
        EXPECT_EQ(leaf.answer.counters.factorizations, 3001);
        // No pivot takes less than 20 ns: the laps that were not gone are in the time.
        EXPECT_GT(leaf.cpu_s, 3001 * 20e-9);
        ++at_limit;
      }
    }
  }
  EXPECT_GE(at_limit, 5);
  EXPECT_LT(gone, 3001 * at_limit) << "laps were gone one by one";
}

TEST(LemkeSweepRulesTest, LongPathsThatNeverGoRoundAreFollowed) {
  // Murty's exponential path: the same variables leave kernels of the same order again and again, but no basis returns.
  Vector q(9);
  for (Index i = 0; i < 9; ++i) q(i) = -(1024.0 - std::ldexp(1.0, static_cast<int>(9 - i)));
  const Problem problem = bare(testing::murty_matrix(9), q);
  const Cells cells = paper_grid();
  LemkeSweep sweep(cells);
  EXPECT_EQ(expect_same_as_alone(sweep, cells, problem, isa_level()), 1U);
  std::vector<LemkeLeaf> leaves;
  EXPECT_EQ(sweep.walk(all_of(cells.size()), leaves), 511);
}

TEST(LemkeSweepRulesTest, BranchesAllocateNothing) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "the allocator of this build cannot be replaced";
  const Cells cells = paper_grid();
  std::vector<lemke::Cell> plain;
  for (const LemkeSettings& each : cells) {
    plain.push_back({each.pivot_tolerance, each.zero_tolerance, std::numeric_limits<double>::infinity()});
  }
  const Problem problem = open_set("paper/copositive/exp2")->generate(1, 0);
  const auto engine = lemke::make_engine(LemkeEngine::kKernel, isa_level());
  Vector z(problem.size());
  int leaves = 0;
  lemke::WalkRules rules;
  rules.max_pivots = 3 * problem.size();
  rules.wall_s = wall_clock_s;
  rules.cpu_s = thread_cpu_clock_s;
  rules.on_leaf = [](void* count, const lemke::Leaf&) { ++*static_cast<int*>(count); };
  rules.context = &leaves;
  const auto walk = [&] { engine->walk(plain.data(), static_cast<std::ptrdiff_t>(plain.size()), rules, z.data()); };
  lemke::load(problem, *engine);
  walk();
  EXPECT_GT(leaves, 4);
  EXPECT_EQ(testing::count_allocations(walk), 0);
}

TEST(LemkeSweepRulesTest, EachCellHasItsOwnTimeLimit) {
  const Problem problem = bare(testing::tridiagonal(30, 4, -1), -testing::ones(30));
  const Cells cells(3, LemkeSettings{});
  LemkeSweep sweep(cells);
  sweep.load(problem);
  const double infinity = std::numeric_limits<double>::infinity();
  std::vector<LemkeLeaf> leaves;
  sweep.walk(std::vector<LemkeTry>{{0, infinity}, {1, 0.0}, {2, 1e6}}, leaves);
  ASSERT_EQ(leaves.size(), 2U);
  EXPECT_EQ(leaves[0].cells, std::vector<std::uint32_t>{1});
  EXPECT_EQ(leaves[0].answer.claim, Claim::kTimeLimit);
  EXPECT_EQ(leaves[0].answer.counters.pivots, 0);
  EXPECT_EQ(leaves[0].answer.z, Vector::Zero(30));
  EXPECT_EQ(leaves[1].cells, (std::vector<std::uint32_t>{0, 2}));
  EXPECT_EQ(leaves[1].answer.claim, Claim::kSolved);
}

// The whole contract of SweptSolver, for any solver: equal to the cells one by one, each cell once, no two answers
// equal.
void expect_swept(const std::string& solver, const std::vector<Options>& cells, const Problem& problem,
                  SweptSolver& swept, const TimedRequest& request = {}) {
  std::vector<SweptAnswer> answers;
  swept.run(problem, request, answers);
  std::vector<int> seen(cells.size(), 0);
  for (std::size_t a = 0; a < answers.size(); ++a) {
    const SweptAnswer& swept_answer = answers[a];
    ASSERT_FALSE(swept_answer.cells.empty());
    EXPECT_TRUE(std::is_sorted(swept_answer.cells.begin(), swept_answer.cells.end()));
    if (a > 0) {
      EXPECT_LT(answers[a - 1].cells.front(), swept_answer.cells.front());
    }
    for (std::size_t b = 0; b < a; ++b) {
      EXPECT_FALSE(same_answer(answers[b].timed.answer, swept_answer.timed.answer));
    }
    EXPECT_GE(swept_answer.timed.times.solve_wall_s, 0);
    EXPECT_GE(swept_answer.timed.times.setup_wall_s, 0);
    EXPECT_EQ(swept_answer.timed.times.repeats, 1);
    for (const std::uint32_t number : swept_answer.cells) {
      ++seen[number];
      const auto alone = in_process(find_solver(solver).definition.make(cells[number]));
      TimedAnswer answer;
      alone->run(problem, request, answer);
      EXPECT_TRUE(same_answer(answer.answer, swept_answer.timed.answer))
          << solver << Spec{"", cells[number]}.text() << " on " << problem.name() << ": "
          << to_string(swept_answer.timed.answer.claim) << ", " << swept_answer.timed.answer.detail << ", "
          << swept_answer.timed.answer.counters.pivots << " pivots; alone " << to_string(answer.answer.claim) << ", "
          << answer.answer.detail << ", " << answer.answer.counters.pivots << " pivots";
    }
  }
  EXPECT_EQ(seen, std::vector<int>(cells.size(), 1));
}

/// A particle of 1 kg on a contact that yields: z = 1 / 1.3 without friction, where a hard one has z = 1.
Problem soft_contact(double mu) {
  ContactProblem contact = *open_set("hard/contact/sticking")->generate(1, 0).contact();
  contact.mu(0) = mu;
  contact.compliance_n = Vector::Constant(1, 0.3);
  contact.compliance_t = Vector::Constant(1, 0.7);
  return {"soft", contact};
}

/// Problems at the edges: soft contacts, which solvers get as rigid equivalents; none, one, no solution, refused.
std::vector<Problem> edge_cases() {
  return {soft_contact(0), soft_contact(0.5), bare(Matrix(0, 0), Vector(0)),
          bare(matrix_of(1, {2}), vector_of({-3})),
          bare(matrix_of(1, {-1}), vector_of({0})),
          bare(matrix_of(1, {-1}), vector_of({-1})),
          bare(matrix_of(2, {1, -1, -1, 1}), vector_of({-1, -1})),
          bare(matrix_of(1, {1e-200}), vector_of({-1e200})),
          bare(matrix_of(1, {std::nan("")}), vector_of({-1}))};
}

TEST(SweptLemkeTest, GivesEachCellItsOwnAnswer) {
  const auto cells = options_of(paper_grid());
  const auto swept = find_solver("lemke").definition.make_swept(cells);
  ASSERT_NE(swept, nullptr);
  for (const Problem& problem : edge_cases()) expect_swept("lemke", cells, problem, *swept);
  const auto set = open_set("paper/monotone/exp5-1e10");
  for (std::int64_t trial = 0; trial < 20; ++trial) expect_swept("lemke", cells, set->generate(3, trial), *swept);
  TimedRequest no_time;
  no_time.time_limit_s = 0;
  expect_swept("lemke", cells, set->generate(3, 0), *swept, no_time);
}

TEST(SweptLemkeTest, SweepsTolerancesOfTheKernelEngineOnly) {
  const auto make = find_solver("lemke").definition.make_swept;
  const auto untested = [](Options options) {
    options.emplace_back("test", "none");
    return options;
  };
  const Options one = untested({{"pivot_tolerance", "1e-20"}});
  const Options dense = untested({{"engine", "dense"}});
  EXPECT_NE(make({one, untested({{"zero_tolerance", "0"}}), one}), nullptr);
  EXPECT_NE(make({untested({{"cap", "3n"}}), untested({{"cap", "3n"}, {"zero_tolerance", "0"}})}), nullptr);
  EXPECT_EQ(make({one, untested({{"cap", "3n"}})}), nullptr);
  EXPECT_EQ(make({one, untested({{"update", "incremental"}})}), nullptr);
  EXPECT_EQ(make({dense, untested({{"engine", "dense"}, {"zero_tolerance", "0"}})}), nullptr);
  EXPECT_EQ(make({{{"pivot_tolerance", "1e-20"}}, {{"zero_tolerance", "0"}}}), nullptr);  // their answers are tested
  EXPECT_EQ(make({}), nullptr);
  EXPECT_THROW(make({one, {{"zero_tolerance", "-1"}}}), InputError);
}

/// Cells of `regularized` with these settings, its inner lemke at each of `inner`.
std::vector<Options> regularized_cells(const Cells& inner, const Options& settings) {
  std::vector<Options> cells;
  for (const LemkeSettings& each : inner) {
    cells.push_back(settings);
    cells.back().emplace_back("solver", Spec{"lemke", changed_settings(each)}.text());
  }
  return cells;
}

class SweptRegularizedTest : public ::testing::TestWithParam<const char*> {
 protected:
  static void expect_same_on(const Options& settings, const Cells& inner, const std::vector<Problem>& problems) {
    const auto cells = regularized_cells(inner, settings);
    const auto swept = find_solver("regularized").definition.make_swept(cells);
    ASSERT_NE(swept, nullptr);
    for (const Problem& problem : problems) expect_swept("regularized", cells, problem, *swept);
  }
};

INSTANTIATE_TEST_SUITE_P(Tests, SweptRegularizedTest, ::testing::Values("tried", "original", "residual"),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(SweptRegularizedTest, GivesEachCellItsOwnAnswer) {
  std::vector<Problem> problems = edge_cases();
  for (const char* name : {"paper/monotone/exp3", "paper/monotone/exp4", "paper/monotone/exp5-1e10"}) {
    const auto set = open_set(name);
    for (std::int64_t trial = 0; trial < 12; ++trial) problems.push_back(set->generate(4, trial));
  }
  for (const LemkeUpdate update : {LemkeUpdate::kResolve, LemkeUpdate::kIncremental}) {
    expect_same_on({{"test", GetParam()}}, paper_grid({.update = update}), problems);
  }
  expect_same_on({{"test", GetParam()}, {"first", "1e-8"}, {"factor", "10"}}, scattered_cells({}), problems);
  expect_same_on({{"test", GetParam()}, {"last", "0"}}, paper_grid(), problems);
}

TEST_P(SweptRegularizedTest, GivesEachCellItsOwnAnswerWithFriction) {
  std::vector<Problem> problems;
  const auto set = open_set("paper/copositive/exp5-1e8");
  for (std::int64_t trial = 0; problems.size() < 6; ++trial) {
    Problem problem = set->generate(4, trial);
    if (problem.size() <= 120) problems.push_back(std::move(problem));
  }
  expect_same_on({{"test", GetParam()}}, paper_grid({.cap = LemkeCap::k3n}), problems);
}

TEST(SweptRegularizedRulesTest, SweepsTolerancesOfAnInnerLemkeOnly) {
  const auto make = find_solver("regularized").definition.make_swept;
  const auto cell_of = [](const char* solver, const char* last = "10") {
    return Options{{"solver", solver}, {"last", last}};
  };
  const char* plain = "lemke{test=none}";
  EXPECT_NE(make({cell_of(plain), cell_of("lemke{test=none,zero_tolerance=0}")}), nullptr);
  EXPECT_EQ(make({cell_of(plain), cell_of("lemke{test=none,zero_tolerance=0}", "1")}), nullptr);
  EXPECT_EQ(make({cell_of(plain), cell_of("lemke{test=none,update=incremental}")}), nullptr);
  EXPECT_EQ(make({cell_of("lemke{engine=dense}"), cell_of("lemke{engine=dense,zero_tolerance=0}")}), nullptr);
  EXPECT_EQ(make({cell_of("lemke"), cell_of("lemke{zero_tolerance=0}")}), nullptr);
  EXPECT_EQ(make({cell_of("primal_dual"), cell_of("primal_dual")}), nullptr);
  EXPECT_EQ(make({}), nullptr);
  EXPECT_THROW(make({cell_of("nobody")}), InputError);
}

TEST(SweptRegularizedRulesTest, EndsWhenTheTimeIsOver) {
  const auto cells = regularized_cells(paper_grid(), {});
  const auto swept = find_solver("regularized").definition.make_swept(cells);
  TimedRequest no_time;
  no_time.time_limit_s = 0;
  for (const Problem& problem : edge_cases()) expect_swept("regularized", cells, problem, *swept, no_time);
}

}  // namespace
}  // namespace lcpbench
