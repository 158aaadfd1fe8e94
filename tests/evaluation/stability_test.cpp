// Changes whose effect on the physical answer is known: a solver with an absolute tolerance is named where a sound one
// is not.

#include "study/stability/stability.h"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "generators/sets.h"
#include "study/run/open_solver.h"
#include "study/stability/physical_answer.h"
#include "study/stability/stability_output.h"
#include "study/output/text_table.h"
#include "tests/support/program_run.h"
#include "tests/support/study_support.h"

namespace lcpbench::stability_test {
namespace {

/// A particle of `mass` kg against three walls.
ContactProblem corner(double mass) {
  ContactProblem problem;
  problem.v.resize(3);
  problem.v << -1, -0.5, -0.25;
  problem.N = Matrix(Matrix::Identity(3, 3));
  problem.D = Matrix(3, 0);
  problem.edges = {0, 0, 0};
  problem.mu = Vector::Zero(3);
  problem.inertia = DenseInertia{mass * Matrix::Identity(3, 3)};
  return problem;
}

/// One sweep of Gauss-Seidel: exact for walls that do not know of each other, and for the same wall twice. What it does
/// wrong is the test's choice.
class Walls : public Solver {
 public:
  struct Fault {
    double smallest_pivot = 0;  ///< absolute: entries of M below it count as zero
    double noise = 0;           ///< relative error of the first impulse
  };
  explicit Walls(Fault fault) : fault_(fault) {}
  const Capabilities& capabilities() const override { return capabilities_; }

 protected:
  void on_load(const Problem& problem) override { lcp_ = make_lcp(problem); }
  void on_solve(const SolveRequest&, Answer& answer) override {
    answer.claim = Claim::kSolved;
    for (Index i = 0; i < lcp_.size(); ++i) {
      const double pivot = lcp_.M(i, i);
      const double velocity = lcp_.q(i) + lcp_.M.row(i).head(i).dot(answer.z.head(i));
      answer.z(i) = pivot > fault_.smallest_pivot ? std::max(0.0, -velocity / pivot) : 0.0;
    }
    if (lcp_.q(0) != -1) answer.z(0) *= 1 + fault_.noise;
  }

 private:
  Fault fault_;
  Capabilities capabilities_;
  Lcp lcp_;
};

StudySolver walls(const std::string& name, Walls::Fault fault) {
  return given_solver(name, [fault] { return in_process(std::make_unique<Walls>(fault)); });
}

StudySet given(std::vector<Problem> problems) {
  const auto trials = static_cast<std::int64_t>(problems.size());
  return {std::make_shared<GivenProblems>("given", std::move(problems)), trials};
}

const StabilityCell& cell(const StabilityResult& result, Change change, std::size_t solver) {
  const auto found = std::find_if(result.cells.begin(), result.cells.end(), [&](const StabilityCell& each) {
    return each.change == change && each.solver == solver;
  });
  return *found;
}

class StabilityTest : public ::testing::Test {
 protected:
  StabilityResult result_ =
      stability({given({Problem("a", corner(2)), Problem("b", corner(4))})},
                {walls("sound", {}), walls("absolute", {1e-3, 0}), walls("noisy", {0, 0x1p-30})}, {});
};

TEST_F(StabilityTest, ASolverWithAnAbsoluteToleranceIsNamed) {
  // M_ii is 1/2 and 1/4; in other units 1/2048 and 1/4096, below its tolerance: it claims that no impulse is needed.
  const StabilityCell& units = cell(result_, Change::kUnits, 1);
  EXPECT_EQ(units.solved, 2);
  EXPECT_EQ(units.kept, 0);
  EXPECT_EQ(units.turned_false, 2);
  EXPECT_TRUE(units.breaks());
  EXPECT_EQ(units.examples.at(0), "given trial 0");
  EXPECT_FALSE(cell(result_, Change::kOrder, 1).breaks());
  const std::string text = stability_text(result_, false, kUnlimited);
  EXPECT_NE(text.find("absolute  units        2 of 2        2 of 2"), std::string::npos) << text;
  EXPECT_EQ(text.find("sound"), std::string::npos) << text;
  EXPECT_NE(stability_text(result_, true, kUnlimited).find("sound"), std::string::npos);
}

TEST_F(StabilityTest, ASoundSolverIsNotNamed) {
  std::int64_t solved = 0;
  for (const StabilityCell& each : result_.cells) {
    if (each.solver != 0) continue;
    solved += each.solved;
    EXPECT_FALSE(each.breaks()) << to_string(each.change);
    EXPECT_FALSE(each.moves_too_far()) << to_string(each.change);
    EXPECT_EQ(each.kept, each.solved) << to_string(each.change);
  }
  EXPECT_EQ(solved, 2 * 6) << "both problems, under all changes";
}

TEST_F(StabilityTest, AmplificationIsTheChangeOverWhatConditioningAllows) {
  // An order that puts another wall first: that impulse is off by 2^-30, so v+ by 2^-30 times the wall's speed.
  // The matrices are multiples of the identity: condition 1, allowance eps.
  const StabilityCell& noisy = cell(result_, Change::kOrder, 2);
  ASSERT_EQ(noisy.amplifications.size(), 2U);
  const double speed = std::sqrt(1 + 0.25 + 0.0625);
  EXPECT_NEAR(noisy.largest_amplification(), 0x1p-30 * 0.5 / speed / 0x1p-52, 0.01 * 0x1p22);
  EXPECT_TRUE(noisy.moves_too_far());
  EXPECT_EQ(noisy.farthest.substr(0, 12), "given trial ");
  EXPECT_FALSE(noisy.breaks());
  EXPECT_NE(stability_text(result_, false, kUnlimited).find("noisy     order        0 of 2"), std::string::npos);
}

TEST_F(StabilityTest, CountsAddUp) {
  for (const StabilityCell& each : result_.cells) {
    EXPECT_LE(each.kept, each.solved);
    EXPECT_LE(each.solved, each.asked);
    EXPECT_LE(each.turned_false, each.honest);
    EXPECT_LE(each.honest, each.asked);
    EXPECT_EQ(each.amplifications.size(), static_cast<std::size_t>(each.kept));
  }
  const nlohmann::ordered_json rows = stability_json(result_);
  EXPECT_EQ(rows.size(), 3U * 6);
  for (const auto& row : rows) EXPECT_EQ(row["asked"], 2);
}

TEST(StabilityOfSolversTest, WhatFrictionLeavesOpenIsNoMove) {
  const Problem frictional = open_set("hard/contact/box-sliding")->generate(1, 0);
  ASSERT_TRUE(frictional.contact()->frictional());
  const StudySolver lemke = given_solver("lemke", [] { return open_solver({"lemke", {}}); });
  const StabilityResult result = stability({given({frictional})}, {lemke}, {});
  const StabilityCell& ordered = cell(result, Change::kOrder, 0);
  EXPECT_EQ(ordered.kept, 1);
  EXPECT_TRUE(ordered.amplifications.empty());
  EXPECT_FALSE(ordered.moves_too_far());
  EXPECT_TRUE(stability_json(result)[0]["amplification"]["max"].is_null());
}

TEST(StabilityOfSolversTest, AConeSolverIsJudgedByTheCone) {
  const Problem frictional = open_set("rigid/frictional/exp1{nc_max=2}")->generate(1, 0);
  StudySolver cone = given_solver("cone", [] { return open_solver(parse_spec("cone_ipm{cone=true}")); });
  const StabilityCell of_pyramid = cell(stability({given({frictional})}, {cone}, {}), Change::kOrder, 0);
  EXPECT_EQ(of_pyramid.solved, 0) << "else the two models agree here, and nothing is tested";
  cone.row.friction = FrictionModel::kCone;
  const StabilityCell of_cone = cell(stability({given({frictional})}, {cone}, {}), Change::kOrder, 0);
  EXPECT_EQ(of_cone.solved, 1);
  EXPECT_EQ(of_cone.honest, 1);
}

/// Raises a flag in one of its solves, as a signal does.
class InterruptedWalls : public Walls {
 public:
  InterruptedWalls(int at, int& solves, volatile std::sig_atomic_t& flag)
      : Walls({}), at_(at), solves_(solves), flag_(flag) {}

 private:
  void on_solve(const SolveRequest& request, Answer& answer) override {
    Walls::on_solve(request, answer);
    if (++solves_ == at_) flag_ = 1;
  }

  int at_;
  int& solves_;
  volatile std::sig_atomic_t& flag_;
};

TEST(StabilityOfSolversTest, AnInterruptedProblemCountsUnderNoChange) {
  volatile std::sig_atomic_t flag = 0;
  int solves = 0;
  const std::vector<StudySet> sets{given({Problem("a", corner(2)), Problem("b", corner(4))})};
  const auto run = [&](int interrupted_at) {
    solves = 0;
    flag = 0;
    StabilityOptions options;
    options.stop = &flag;
    const auto open = [&, interrupted_at] {
      return in_process(std::make_unique<InterruptedWalls>(interrupted_at, solves, flag));
    };
    return stability(sets, {given_solver("walls", open)}, options);
  };
  EXPECT_EQ(run(0).problems, 2);
  const int all = solves;
  const StabilityResult result = run(all);
  EXPECT_EQ(solves, all);
  EXPECT_EQ(result.problems, 1);
  for (const StabilityCell& each : result.cells) EXPECT_EQ(each.asked, 1) << to_string(each.change);
  EXPECT_EQ(run(1).problems, 0);
  EXPECT_EQ(solves, 1);
}

TEST(StabilityOfSolversTest, ProblemsThatAPerturbationMayMakeUnsolvableAreNotPerturbed) {
  ContactProblem flat = corner(1);
  flat.inertia = FactoredInertia{Matrix(Matrix::Identity(3, 3).leftCols(2)), Vector::Ones(2)};
  flat.v(2) = 0;
  const StudySolver lemke = given_solver("lemke", [] { return open_solver({"lemke", {}}); });
  const StabilityResult result = stability({given({Problem("flat", flat)})}, {lemke}, {});
  EXPECT_EQ(cell(result, Change::kOrder, 0).asked, 1);
  EXPECT_EQ(cell(result, Change::kLastDigits, 0).asked, 0);
  EXPECT_EQ(cell(result, Change::kNearDuplicate, 0).asked, 0);
}

TEST(StabilityOfSolversTest, ConditionIsThatOfTheMatrixWithUnitDiagonal) {
  Matrix A(2, 2);
  A << 1, 0.5, 0.5, 1;
  EXPECT_NEAR(scaled_condition(A), 3, 1e-14);
  Vector units(2);
  units << 1e6, 1e-6;
  EXPECT_NEAR(scaled_condition(units.asDiagonal() * A * units.asDiagonal()), 3, 1e-12);
  EXPECT_NEAR(scaled_condition(Matrix::Ones(3, 3)), 1, 1e-14);  // zero eigenvalues are no part of it
  A(0, 1) = A(1, 0) = 1 - 0x1p-53;
  EXPECT_NEAR(scaled_condition(A), 0x1p54, 0x1p4);  // but those that double arithmetic takes for zero are
}

TEST(StabilityOfSolversTest, WhatOffsetsMoveFromRestChangesByAShareOfItsAnswer) {
  ContactProblem pushed = corner(2);
  pushed.v.setZero();
  pushed.b = Vector::Constant(3, -1);
  const Problem problem("pushed", pushed);
  const Vector answer = Vector::Ones(3);
  EXPECT_NEAR(PhysicalAnswers(problem).change(answer, (1 + 1e-9) * answer), 1e-9, 1e-15);
}

class StabilityCommandTest : public ::testing::Test {
 protected:
  int run(const std::string& arguments) { return run_program(folder_ / "", "stability " + arguments).exit_code; }
  std::string text(const std::string& name) { return read_file(folder_ / name); }
  ScratchFolder folder_;
};

TEST_F(StabilityCommandTest, GivesTheSameTableTwiceAndRefusesWhatItDoesNotKnow) {
  const std::string arguments =
      "--set planted/definite --set paper/monotone/exp1 --solver lemke --trials 2 --format json";
  ASSERT_EQ(run(arguments), 0) << text("err");
  const nlohmann::json first = nlohmann::json::parse(text("out"));
  EXPECT_EQ(first["problems"], 4);
  EXPECT_FALSE(first["cells"].empty());
  EXPECT_TRUE(first["provenance"].is_object());
  ASSERT_EQ(run(arguments), 0);
  EXPECT_EQ(nlohmann::json::parse(text("out"))["cells"], first["cells"]);
  EXPECT_EQ(run("--set planted/definite --solver lemke --trials 1"), 0);
  EXPECT_NE(text("out").find("1 problem of 1 set: 0 of 1 solver break"), std::string::npos) << text("out");
  EXPECT_EQ(run("--set planted/definite --solver lemke --trials 1 --long"), 0);
  EXPECT_NE(text("out").find("last_digits     0 of 1"), std::string::npos) << text("out");
  EXPECT_EQ(run("--set nosuch"), 2);
  EXPECT_EQ(run("--solver nosuch"), 2);
  EXPECT_EQ(run("--trials 0"), 2);
}

}  // namespace
}  // namespace lcpbench::stability_test
