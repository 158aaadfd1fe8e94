#include <cmath>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/registry.h"
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

  static Answer solve(const Lcp& lcp, const std::string& settings) {
    const auto solver = make_solver(parse_spec("regularized{" + settings + "}"));
    solver->load(Problem("case", lcp));
    Answer answer;
    solver->solve({}, answer);
    return answer;
  }
  static Lcp one(double m, double q) { return {testing::matrix_of(1, {m}), testing::vector_of({q})}; }
};

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

TEST_F(RegularizedTest, TheToleranceIsRelativeToTheData) {
  for (const double scale : {1e-12, 1.0, 1e12}) {
    script.works_from = 1e300;
    script.bad_answer = 1.5 * (1 + 1e-7);  // w = 1e-7 max|q|
    const Lcp problem = one(2 * scale, -3 * scale);
    EXPECT_EQ(solve(problem, "solver=scripted,last=0,test=original").claim, Claim::kSolved) << scale;
    EXPECT_EQ(solve(problem, "solver=scripted,last=0").claim, Claim::kSolved) << scale;  // its error is 5e-8
    script.bad_answer = 1.5 * (1 + 1e-5);
    EXPECT_EQ(solve(problem, "solver=scripted,last=0,test=original").claim, Claim::kNumericalFailure) << scale;
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
