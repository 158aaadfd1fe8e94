#include <cmath>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/registry.h"
#include "generators/sets.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench {
SolverDefinition lcpbench_solver_lemke();
SolverDefinition lcpbench_solver_regularized();

namespace {

/// What the scripted solver saw and does: it claims `claim` for every problem, and answers with the solution of a
/// diagonal M once M_00 is at least `works_from`, else with `bad_answer`.
struct Script {
  double works_from = 0;
  Claim claim = Claim::kSolved;
  double bad_answer = 0;
  Vector answer;  // when not empty, instead of all the above
  double cost_s = 0;
  std::vector<double> diagonals_seen;
};
Script script;

struct NoSettings {
  void visit(auto&&) {}
};

class Scripted final : public Solver {
 public:
  explicit Scripted(const NoSettings&) {}
  const Capabilities& capabilities() const override {
    static const Capabilities capabilities{.max_size = 3};
    return capabilities;
  }

 protected:
  void on_load(const Problem& problem) override { lcp_ = make_lcp(problem); }
  void on_solve(const SolveRequest&, Answer& answer) override {
    const double diagonal = lcp_.M(0, 0);
    script.diagonals_seen.push_back(diagonal);
    answer.claim = script.claim;
    answer.z.setConstant(script.bad_answer);
    if (diagonal >= script.works_from) answer.z = (-lcp_.q.array() / lcp_.M.diagonal().array()).max(0.0);
    if (script.answer.size() > 0) answer.z = script.answer;
    answer.counters = {.iterations = 2, .pivots = 3, .factorizations = -1};
  }

 private:
  Lcp lcp_;
};

SolverDefinition scripted() { return define_solver<Scripted, NoSettings>({.name = "scripted"}); }

}  // namespace

// The registry of this test: what `regularized` can wrap here.
const std::vector<RegisteredSolver>& registered_solvers() {
  static const std::vector<RegisteredSolver> solvers{
      {scripted(), "native", "", "", ""},
      {lcpbench_solver_lemke(), "native", "", "", ""},
      {lcpbench_solver_regularized(), "native", "", "", ""},
      {with_settings<NoSettings>({.name = "foreign"}), "L", "", "w", ""}};
  return solvers;
}

namespace {

class RegularizedTest : public ::testing::Test {
 protected:
  void SetUp() override { script = Script{}; }

  static Answer solve(const Lcp& lcp, const std::string& settings, const SolveRequest& request = {}) {
    const auto solver = make_solver(parse_spec("regularized{" + settings + "}"));
    solver->load(Problem("case", lcp));
    Answer answer;
    solver->solve(request, answer);
    return answer;
  }
  static Lcp one(double m, double q) { return {testing::matrix_of(1, {m}), testing::vector_of({q})}; }
};

TEST_F(RegularizedTest, TakesAGoodPlainAnswerAndTriesNothingElse) {
  const Answer answer = solve(one(2, -3), "solver=scripted");
  EXPECT_EQ(answer.claim, Claim::kSolved);
  EXPECT_EQ(answer.z(0), 1.5);
  EXPECT_EQ(answer.detail, "passed without regularization");
  EXPECT_EQ(script.diagonals_seen, std::vector<double>{2});
}

TEST_F(RegularizedTest, ClimbsTheWrittenLadderAndTellsTheStage) {
  script.works_from = 0.1;
  const Answer answer = solve(one(0, -3), "solver=scripted,first=0.03125,factor=2,last=1,test=tried");
  EXPECT_EQ(answer.claim, Claim::kSolved);
  EXPECT_EQ(script.diagonals_seen, (std::vector<double>{0, 0.03125, 0.0625, 0.125}));
  EXPECT_EQ(answer.detail, "passed with eps = 0.125, try 4");
  EXPECT_EQ(answer.counters.iterations, 8);  // all tries count
  EXPECT_EQ(answer.counters.pivots, 12);
  EXPECT_EQ(answer.counters.factorizations, -1);
}

TEST_F(RegularizedTest, DefaultLadderIsThePublishedOne) {
  script.works_from = 1e9;
  solve(one(0, -3), "solver=scripted");
  ASSERT_EQ(script.diagonals_seen.size(), 7u);
  for (std::size_t i = 1; i < 7; ++i) {
    EXPECT_NEAR(std::log10(script.diagonals_seen[i]), -24.0 + 4.0 * static_cast<double>(i), 1e-9);
  }
}

TEST_F(RegularizedTest, RejectsEachKindOfWrongAnswer) {
  const double infinity = std::numeric_limits<double>::infinity();
  script.works_from = 1e9;
  for (const double wrong : {0.0 /* w < 0 */, 5.0 /* z'w > 0 */, -1.0 /* z < 0 */, std::nan(""), infinity}) {
    script.bad_answer = wrong;
    const Answer answer = solve(one(2, -3), "solver=scripted,last=0");
    EXPECT_EQ(answer.claim, Claim::kNumericalFailure) << wrong;
  }
}

TEST_F(RegularizedTest, NeverTurnsAFailureIntoAClaim) {
  script.claim = Claim::kIterationLimit;  // though the answer would pass the test
  const Answer answer = solve(one(2, -3), "solver=scripted");
  EXPECT_EQ(answer.claim, Claim::kIterationLimit);
  EXPECT_EQ(script.diagonals_seen.size(), 7u);
}

// M = -1, q = -1 has no solution; M + 10 I has z = 1/9. The wrapper's own test is content with it, that of the original
// problem is not: why a verdict is never taken from a wrapper.
TEST_F(RegularizedTest, TheTestOnTheTriedProblemAcceptsWhatTheOriginalRefuses) {
  const std::string ladder = "solver=lemke,first=10,last=10";
  const Answer tried = solve(one(-1, -1), ladder + ",test=tried");
  EXPECT_EQ(tried.claim, Claim::kSolved);
  EXPECT_NEAR(tried.z(0), 1.0 / 9, 1e-15);
  const Answer original = solve(one(-1, -1), ladder);
  EXPECT_EQ(original.claim, Claim::kUnsolvable);
}

TEST_F(RegularizedTest, TheToleranceIsRelativeToTheData) {
  for (const double scale : {1e-12, 1.0, 1e12}) {
    script.works_from = 1e300;
    script.bad_answer = 1.5 * (1 + 1e-7);  // w = 1e-7 max|q|
    const Lcp problem = one(2 * scale, -3 * scale);
    EXPECT_EQ(solve(problem, "solver=scripted,last=0,test=original").claim, Claim::kSolved) << scale;
    EXPECT_EQ(solve(problem, "solver=scripted,last=0").claim, Claim::kNumericalFailure) << scale;
    script.bad_answer = 1.5 * (1 + 1e-5);
    EXPECT_EQ(solve(problem, "solver=scripted,last=0,test=original").claim, Claim::kNumericalFailure) << scale;
  }
}

// The ball between closing plates: M + eps I is solved by forces of 1 / eps, next to which a velocity of -1 is
// relatively small. The test must not be taken in by them.
TEST_F(RegularizedTest, LargeInnerForcesExcuseNoPenetration) {
  const Lcp crushed{testing::matrix_of(2, {1, -1, -1, 1}), testing::vector_of({-1, -1})};
  EXPECT_EQ(solve(crushed, "solver=lemke,test=tried").claim, Claim::kSolved);
  EXPECT_EQ(solve(crushed, "solver=lemke").claim, Claim::kUnsolvable);
}

// A separating contact of a right answer may carry a friction impulse of the size of rounding and no normal impulse.
// Its cone is then violated by all that its row holds, and by nothing that counts.
TEST_F(RegularizedTest, RoundingNoiseInAnEmptyFrictionConeIsExcused) {
  const Lcp sliding{testing::matrix_of(3, {2, 0, 0, 0, 1, 1, 0.5, -1, 0}), testing::vector_of({1, -1, 0})};
  script.answer = testing::vector_of({0, 1e-17, 1});
  EXPECT_EQ(solve(sliding, "solver=scripted,last=0").claim, Claim::kSolved);
  script.answer = testing::vector_of({0, 1e-3, 1 - 1e-3});
  EXPECT_EQ(solve(sliding, "solver=scripted,last=0").claim, Claim::kNumericalFailure);
}

TEST_F(RegularizedTest, PassesOnRefusalsAndLimits) {
  const Answer refused = solve({Matrix::Identity(4, 4), -testing::ones(4)}, "solver=scripted");
  EXPECT_EQ(refused.claim, Claim::kUnsupported);
  EXPECT_TRUE(script.diagonals_seen.empty());
  script.claim = Claim::kTimeLimit;
  EXPECT_EQ(solve(one(2, -3), "solver=scripted").claim, Claim::kTimeLimit);
}

TEST_F(RegularizedTest, WrapsContactProblemsAsBareMatrices) {
  ContactProblem ball;
  ball.v = testing::vector_of({-1});
  ball.N = Matrix(Matrix::Ones(1, 1));
  ball.D = Matrix(1, 0);
  ball.edges = {0};
  ball.mu = Vector::Zero(1);
  ball.inertia = DenseInertia{4 * Matrix::Identity(1, 1)};
  const auto solver = make_solver(parse_spec("regularized{solver=lemke}"));
  solver->load(Problem("ball", ball));
  Answer answer;
  solver->solve({}, answer);
  EXPECT_EQ(answer.claim, Claim::kSolved);
  EXPECT_EQ(answer.z, testing::vector_of({4}));
}

TEST_F(RegularizedTest, ASecondSolveStartsFromTheProblemAsGiven) {
  script.works_from = 0.1;
  const auto solver = make_solver(parse_spec("regularized{solver=scripted,first=0.125,test=tried}"));
  solver->load(Problem("case", one(0, -3)));
  Answer answer;
  for (int repeat = 0; repeat < 2; ++repeat) {
    solver->solve({}, answer);
    EXPECT_EQ(answer.claim, Claim::kSolved);
    EXPECT_EQ(answer.detail, "passed with eps = 0.125, try 2");
    EXPECT_EQ(answer.counters.iterations, 4);
  }
  EXPECT_EQ(script.diagonals_seen, (std::vector<double>{0, 0.125, 0, 0.125}));
}

TEST_F(RegularizedTest, DeclaresNoMoreThanItsInnerSolverKeepsWhenLoadedAnew) {
  const auto declares = [](const char* settings) {
    return make_solver(parse_spec("regularized" + std::string(settings)))->capabilities().allocation_free;
  };
  EXPECT_TRUE(declares(""));
  EXPECT_FALSE(declares("{solver=lemke{engine=dense}}"));
  EXPECT_FALSE(declares("{solver=scripted}"));
  EXPECT_FALSE(declares("{solver=regularized}"));
}

// Whether M passes, some M + eps I does, or none.
TEST_F(RegularizedTest, AllocatesNothingOnAnyStageOfTheLadder) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "allocations cannot be counted in this build";
  const Problem none("no solution", Lcp{Matrix::Zero(30, 30), -testing::ones(30)});
  const Problem singular_inertia = open_set("paper/copositive/exp3")->generate(1, 0);
  const Problem regular = open_set("paper/copositive/exp2")->generate(1, 0);
  for (const std::string inner : {"{test=none}", "{test=residual}", "{update=incremental}"}) {
    for (const std::string test : {"tried", "original", "residual"}) {
      const auto solver = make_solver(parse_spec("regularized{solver=lemke" + inner + ",test=" + test + "}"));
      ASSERT_TRUE(solver->capabilities().allocation_free) << inner;
      for (const Problem& problem : {none, singular_inertia, regular}) {
        solver->load(problem);
        Answer answer;
        answer.reserve(problem);
        for (int repeat = 0; repeat < 2; ++repeat) {
          EXPECT_EQ(testing::count_allocations([&] { solver->solve({}, answer); }), 0)
              << inner << " " << test << " " << problem.name() << ": " << answer.detail;
        }
      }
    }
  }
}

TEST_F(RegularizedTest, TheInnerSpecIsCheckedAndCanonical) {
  EXPECT_EQ(canonical_solver_spec(parse_spec("regularized{solver=scripted{}}")).text(), "regularized{solver=scripted}");
  EXPECT_EQ(canonical_solver_spec(parse_spec("regularized{solver=regularized{solver=scripted{},first=1e-20}}")).text(),
            "regularized{solver=regularized{solver=scripted}}");
  for (const char* bad : {"regularized{solver=nobody}", "regularized{solver=foreign}",
                          "regularized{solver=scripted{}x}", "regularized{solver=scripted{unknown=1}}"}) {
    EXPECT_THROW(canonical_solver_spec(parse_spec(bad)), InputError) << bad;
    EXPECT_THROW(make_solver(parse_spec(bad)), InputError) << bad;
  }
}

}  // namespace
}  // namespace lcpbench
