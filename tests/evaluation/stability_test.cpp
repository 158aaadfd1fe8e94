// Transformations whose effect on the physical answer is known: that they are what they say, that they can be undone
// bit for bit, and that a solver with an absolute tolerance is named where a sound one is not.

#include "study/stability/stability.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/problem_io.h"
#include "generators/sets.h"
#include "study/run/open_solver.h"
#include "study/stability/physical_answer.h"
#include "study/stability/stability_output.h"
#include "study/output/text_table.h"
#include "tests/support/program_run.h"
#include "tests/support/study_support.h"

namespace lcpbench {
namespace {

using Kind = TransformationKind;

TrialKey key(std::uint64_t trial = 0) { return {stream_id("stability/test"), 7, trial}; }

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

/// A body of 4 kg and 2 kg m^2 on two points, arms of 1/2 and -1/4 m, with friction of four edges at the first.
ContactProblem body() {
  ContactProblem problem;
  problem.v.resize(6);
  problem.v << 0.5, 0.25, -1, 0.125, -0.5, 0.75;
  Matrix N(6, 2);
  N.col(0) << 0, 0, 1, 0.5, -0.25, 0;
  N.col(1) << 0, 0, 1, -0.25, 0.5, 0;
  Matrix D(6, 4);
  D.setZero();
  D.col(0) << 1, 0, 0, 0, -0.5, 0.25;
  D.col(1) << 0, 1, 0, 0.5, 0, 0.5;
  D.rightCols(2) = -D.leftCols(2);
  problem.N = N;
  problem.D = D;
  problem.edges = {4, 0};
  problem.mu.resize(2);
  problem.mu << 0.5, 0;
  Vector diagonal(6);
  diagonal << 4, 4, 4, 2, 2, 2;
  problem.inertia = BlockInertia{{Matrix(diagonal.asDiagonal())}};
  return problem;
}

/// The problem as a contact problem where the other, made from it, is no scene any more.
Problem in_the_form_of(const Problem& other, const Problem& problem) {
  const bool lost_scene = problem.scene() != nullptr && other.scene() == nullptr;
  return lost_scene ? Problem(problem.name(), *problem.contact()) : problem;
}

TEST(TransformationTest, UndoneItIsTheSameProblemBitForBit) {
  for (const char* name : {"paper/monotone/exp2", "paper/monotone/exp3", "paper/copositive/exp2", "rigid/exp1",
                           "rigid/frictional/exp1", "planted/definite"}) {
    const std::unique_ptr<ProblemSet> set = open_set(name);
    for (std::uint64_t trial = 0; trial < 4; ++trial) {
      const Problem problem = set->generate(3, static_cast<std::int64_t>(trial));
      for (const Kind kind : kAllTransformations) {
        if (kind == Kind::kMassUnit || kind == Kind::kLengthUnit) continue;  // rounded products
        const auto transformation = draw_transformation(kind, problem, key(trial), 0);
        if (!transformation) continue;
        const Problem changed = transformation->apply(problem);
        const Problem before = in_the_form_of(changed, problem);
        EXPECT_EQ(problem_hash(transformation->undo(changed)), problem_hash(before)) << name << " " << to_string(kind);
        if (kind == Kind::kPermutation) continue;  // may be the identity
        EXPECT_NE(problem_hash(changed), problem_hash(before)) << name << " " << to_string(kind);
      }
    }
  }
}

TEST(TransformationTest, ASceneStaysOneWhereTheChangeIsOneOfScenes) {
  RigidScene with_offsets = *open_set("rigid/frictional/exp1")->generate(3, 1).scene();
  for (RigidContact& contact : with_offsets.contacts) contact.b = contact.point.x();
  const Problem scene("scene", with_offsets);
  int checked = 0;
  for (const Kind kind : kAllTransformations) {
    const auto transformation = draw_transformation(kind, scene, key(), 0);
    if (!transformation) continue;
    ++checked;
    const Problem changed = transformation->apply(scene);
    const bool of_columns = kind == Kind::kContactScaling || kind == Kind::kDirectionOrder;
    EXPECT_EQ(changed.scene() == nullptr, of_columns) << to_string(kind);
    if (kind == Kind::kOneUlp || kind == Kind::kNearDuplicate || of_columns) continue;
    // The scene's change and that of its contact problem are the same.
    const Problem contact("contact", *scene.contact());
    const Lcp expected = draw_transformation(kind, contact, key(), 0)->apply(contact).lcp();
    const double scale = expected.M.cwiseAbs().maxCoeff();
    EXPECT_LE((changed.lcp().M - expected.M).cwiseAbs().maxCoeff(), 1e-12 * scale) << to_string(kind);
    EXPECT_LE((changed.lcp().q - expected.q).cwiseAbs().maxCoeff(), 1e-12 * expected.q.cwiseAbs().maxCoeff());
  }
  EXPECT_EQ(checked, 8) << "all but the scalings of rows and of columns of a bare LCP";
}

TEST(TransformationTest, UnitsAreUndoneWhereTheProductsAreExact) {
  const Problem problem("body", body());
  for (const Kind kind : {Kind::kMassUnit, Kind::kLengthUnit}) {
    const auto transformation = draw_transformation(kind, problem, key(), 0);
    ASSERT_TRUE(transformation);
    const Problem changed = transformation->apply(problem);
    EXPECT_NE(problem_hash(changed), problem_hash(problem)) << to_string(kind);
    EXPECT_EQ(problem_hash(transformation->undo(changed)), problem_hash(problem)) << to_string(kind);
  }
}

TEST(TransformationTest, UnitsChangeVelocitiesAndResponsesAsTheyMust) {
  const Problem problem("body", body());
  const Lcp lcp = problem.lcp();
  const Index impulses = 6;
  // In grams the same impulse [g m/s] moves a thousandth; in millimetres [kg mm/s] the same, and speeds are in mm/s.
  const Lcp grams = draw_transformation(Kind::kMassUnit, problem, key(), 0)->apply(problem).lcp();
  EXPECT_TRUE(grams.q == lcp.q);
  EXPECT_TRUE((1000 * grams.M - lcp.M).topLeftCorner(impulses, impulses).cwiseAbs().maxCoeff() < 1e-15);
  const auto length = draw_transformation(Kind::kLengthUnit, problem, key(), 0);
  const Lcp millimetres = length->apply(problem).lcp();
  EXPECT_TRUE((millimetres.q - 1000 * lcp.q).cwiseAbs().maxCoeff() < 1e-12);
  EXPECT_TRUE((millimetres.M - lcp.M).cwiseAbs().maxCoeff() < 1e-15);
  EXPECT_TRUE(length->velocity_back(length->apply(problem).contact()->v) == problem.contact()->v);
}

// Offsets that are a row of N: they stay that row, whatever becomes of it.
TEST(TransformationTest, AnOffsetIsChangedWithItsRow) {
  ContactProblem with_offset = body();
  with_offset.b = to_dense(with_offset.N).row(3).transpose();
  const Problem problem("body", with_offset);
  int checked = 0;
  for (const Kind kind : kAllTransformations) {
    const auto transformation = draw_transformation(kind, problem, key(), 1);
    if (!transformation) continue;
    ++checked;
    SCOPED_TRACE(to_string(kind));
    const Problem changed = transformation->apply(problem);
    const ContactProblem& contact = *changed.contact();
    ASSERT_EQ(contact.b.size(), contact.nc());
    const Vector row = to_dense(contact.N).row(3).transpose();
    EXPECT_TRUE(contact.b.isApprox(row, 0x1p-29)) << contact.b.transpose() << " for " << row.transpose();
    if (kind == Kind::kOneUlp) {
      EXPECT_TRUE((contact.b.array() != with_offset.b.array()).all());
    }
    EXPECT_EQ(problem_hash(transformation->undo(changed)), problem_hash(problem));
  }
  EXPECT_EQ(checked, 8);
}

TEST(TransformationTest, RowsAndColumnsOfABareProblemScaleByPowersOfTwo) {
  // 2 z = 3: whatever the row is multiplied by, z = 3/2; column 2 s: z' = 3/(2 s), taken back 3/2.
  const Problem problem("bare", Lcp{Matrix::Constant(1, 1, 2.0), Vector::Constant(1, -3.0)});
  for (std::uint64_t draw = 0; draw < 8; ++draw) {
    const auto rows = draw_transformation(Kind::kRowScaling, problem, key(), draw);
    const Lcp scaled = rows->apply(problem).lcp();
    const double factor = scaled.M(0, 0) / 2;
    EXPECT_EQ(scaled.q(0), -3 * factor);
    int exponent = 0;
    EXPECT_EQ(std::frexp(factor, &exponent), 0.5);
    EXPECT_LE(std::abs(exponent - 1), 10);

    const auto columns = draw_transformation(Kind::kColumnScaling, problem, key(), draw);
    const Lcp other = columns->apply(problem).lcp();
    EXPECT_EQ(other.q(0), -3);
    EXPECT_EQ(columns->unknowns_back(Vector::Constant(1, 3 / other.M(0, 0)))(0), 1.5);
  }
}

TEST(TransformationTest, APermutationTakesItsAnswerBack) {
  Matrix M = Matrix::Zero(4, 4);
  M.diagonal() << 1, 2, 4, 8;
  const Problem problem("bare", Lcp{M, -Vector::Ones(4)});
  const auto permutation = draw_transformation(Kind::kPermutation, problem, key(), 2);
  const Lcp permuted = permutation->apply(problem).lcp();
  const Vector z = permuted.M.diagonal().cwiseInverse();
  EXPECT_TRUE(permutation->unknowns_back(z) == Vector(M.diagonal().cwiseInverse()));
}

TEST(TransformationTest, ADuplicateIsTheSameContactAndANearOneIsNot) {
  const Problem problem("body", body());
  const auto exact = draw_transformation(Kind::kDuplicate, problem, key(), 0)->apply(problem);
  const Matrix N = to_dense(exact.contact()->N);
  ASSERT_EQ(N.cols(), 3);
  EXPECT_TRUE(N.col(2) == N.col(0) || N.col(2) == N.col(1));
  const auto near = draw_transformation(Kind::kNearDuplicate, problem, key(), 0);
  EXPECT_EQ(near->data_change, 0x1p-30);
  const Matrix close = to_dense(near->apply(problem).contact()->N);
  const double distance = std::min((close.col(2) - close.col(0)).cwiseAbs().maxCoeff(),
                                   (close.col(2) - close.col(1)).cwiseAbs().maxCoeff());
  EXPECT_GT(distance, 0);
  EXPECT_LE(distance, 0x1p-30);
}

TEST(TransformationTest, OneUlpMovesEveryNumberToANeighbour) {
  const ContactProblem before = body();
  const Problem problem("body", before);
  const ContactProblem after = *draw_transformation(Kind::kOneUlp, problem, key(), 0)->apply(problem).contact();
  EXPECT_NO_THROW(problem_json(Problem("body", after)));
  for (Index i = 0; i < 6; ++i) {
    const double up = std::nextafter(before.v(i), std::numeric_limits<double>::infinity());
    const double down = std::nextafter(before.v(i), -std::numeric_limits<double>::infinity());
    EXPECT_TRUE(after.v(i) == up || after.v(i) == down);
  }
  EXPECT_TRUE(to_dense(after.D).leftCols(2) == -to_dense(after.D).rightCols(2));
  const Matrix G = dense_inertia(after.inertia);
  EXPECT_TRUE(G == G.transpose());
  EXPECT_NE(G(0, 0), 4);
}

TEST(TransformationTest, OneUlpOfADenormalIsNoSmallChange) {
  const Problem problem("denormal", Lcp{Matrix::Constant(1, 1, 0x1p-1070), Vector::Constant(1, -0x1p-1070)});
  EXPECT_EQ(draw_transformation(Kind::kOneUlp, problem, key(), 0)->data_change, 0x1p-4);
  const Problem usual("usual", Lcp{Matrix::Constant(1, 1, 1.5), Vector::Constant(1, -1.5)});
  EXPECT_EQ(draw_transformation(Kind::kOneUlp, usual, key(), 0)->data_change, 0x1p-52 / 1.5);
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
    answer.counters.pivots = static_cast<std::int64_t>(10 - 2 * lcp_.q(0));  // depends on who comes first
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

const StabilityCell& cell(const StabilityResult& result, Kind kind, std::size_t solver) {
  const auto found = std::find_if(result.cells.begin(), result.cells.end(), [&](const StabilityCell& each) {
    return each.kind == kind && each.solver == solver;
  });
  return *found;
}

class StabilityTest : public testing::Test {
 protected:
  StabilityResult result_ =
      stability({given({Problem("a", corner(2)), Problem("b", corner(4))})},
                {walls("sound", {}), walls("absolute", {1e-3, 0}), walls("noisy", {0, 0x1p-30})}, {});
};

TEST_F(StabilityTest, ASolverWithAnAbsoluteToleranceIsNamed) {
  // M_ii is 1/2 and 1/4; in grams 1/2000 and 1/4000, below its tolerance: it claims that nothing needs an impulse.
  const StabilityCell& grams = cell(result_, Kind::kMassUnit, 1);
  EXPECT_EQ(grams.solved, 2);
  EXPECT_EQ(grams.kept, 0);
  EXPECT_EQ(grams.turned_false, 2);
  EXPECT_TRUE(grams.breaks());
  EXPECT_EQ(grams.examples.at(0), "given trial 0");
  EXPECT_FALSE(cell(result_, Kind::kLengthUnit, 1).breaks());
  EXPECT_FALSE(cell(result_, Kind::kPermutation, 1).breaks());
  const std::string text = stability_text(result_, kUnlimited);
  EXPECT_NE(text.find("absolute under kg_to_g: 2 of 2 solved problems lost"), std::string::npos) << text;
  EXPECT_EQ(text.find("sound under"), std::string::npos) << text;
}

TEST_F(StabilityTest, ASoundSolverIsNotNamed) {
  std::int64_t solved = 0;
  for (const StabilityCell& each : result_.cells) {
    if (each.solver != 0) continue;
    solved += each.solved;
    EXPECT_FALSE(each.breaks()) << to_string(each.kind);
    EXPECT_FALSE(each.moves_too_far()) << to_string(each.kind);
    EXPECT_EQ(each.kept, each.solved) << to_string(each.kind);
  }
  EXPECT_GE(solved, 2 * 6) << "both problems, under all that changes frictionless contacts";
}

TEST_F(StabilityTest, AmplificationIsTheChangeOverWhatConditioningAllows) {
  // A permutation that puts another wall first: that impulse is off by 2^-30, so v+ by 2^-30 times the wall's speed.
  // The matrices are multiples of the identity: condition 1, allowance eps.
  const StabilityCell& noisy = cell(result_, Kind::kPermutation, 2);
  ASSERT_EQ(noisy.amplifications.size(), 2U);
  const double speed = std::sqrt(1 + 0.25 + 0.0625);
  EXPECT_NEAR(noisy.largest_amplification(), 0x1p-30 * 0.5 / speed / 0x1p-52, 0.01 * 0x1p22);
  EXPECT_TRUE(noisy.moves_too_far());
  EXPECT_EQ(noisy.farthest.substr(0, 12), "given trial ");
  EXPECT_FALSE(noisy.breaks());
  EXPECT_NE(stability_text(result_, kUnlimited).find("noisy under permutation"), std::string::npos);
}

TEST_F(StabilityTest, PivotsSpreadOverThePermutations) {
  // 12, 11 or 10 pivots as the wall of 1, 1/2 or 1/4 m/s comes first; five permutations of two problems show all three.
  const StabilityCell& sound = cell(result_, Kind::kPermutation, 0);
  ASSERT_EQ(sound.pivot_spreads.size(), 2U);
  for (const double spread : sound.pivot_spreads) {
    EXPECT_GE(spread, 12.0 / 11);
    EXPECT_LE(spread, 1.2);
  }
}

TEST_F(StabilityTest, CountsAddUp) {
  for (const StabilityCell& each : result_.cells) {
    EXPECT_LE(each.kept, each.solved);
    EXPECT_LE(each.solved, each.asked);
    EXPECT_LE(each.turned_false, each.honest);
    EXPECT_LE(each.honest, each.asked);
    EXPECT_EQ(each.residuals.size(), static_cast<std::size_t>(each.kept));
    EXPECT_EQ(each.amplifications.size() + each.distances.size(), each.residuals.size());
  }
  const nlohmann::ordered_json rows = stability_json(result_);
  EXPECT_EQ(rows.size(), 3U * 7);  // scaling, two units, permutation, two duplicates, ulp; no friction, no bare LCP
  for (const auto& row : rows) EXPECT_EQ(row["asked"], 2);
}

TEST(StabilityOfSolversTest, FrictionHasDistancesInsteadOfAmplifications) {
  const StudySolver lemke = given_solver("lemke", [] { return open_solver({"lemke", {}}); });
  const StabilityResult result = stability({given({Problem("body", body())})}, {lemke}, {});
  const StabilityCell& shifted = cell(result, Kind::kDirectionOrder, 0);
  EXPECT_EQ(shifted.kept, 1);
  EXPECT_TRUE(shifted.amplifications.empty());
  ASSERT_EQ(shifted.distances.size(), 1U);
  EXPECT_GE(shifted.distances[0], 0);
  EXPECT_EQ(stability_text(result, 100).find("amplification, median"), std::string::npos) << "a table without rows";
}

TEST(StabilityOfSolversTest, ProblemsThatAPerturbationMayMakeUnsolvableAreNotPerturbed) {
  ContactProblem flat = corner(1);
  flat.inertia = FactoredInertia{Matrix(Matrix::Identity(3, 3).leftCols(2)), Vector::Ones(2)};
  flat.v(2) = 0;
  const StudySolver lemke = given_solver("lemke", [] { return open_solver({"lemke", {}}); });
  const StabilityResult result = stability({given({Problem("flat", flat)})}, {lemke}, {});
  EXPECT_EQ(cell(result, Kind::kPermutation, 0).asked, 1);
  EXPECT_EQ(cell(result, Kind::kOneUlp, 0).asked, 0);
  EXPECT_EQ(cell(result, Kind::kNearDuplicate, 0).asked, 0);
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

class StabilityCommandTest : public testing::Test {
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
  EXPECT_NE(text("out").find("still solved"), std::string::npos);
  EXPECT_EQ(run("--set nosuch"), 2);
  EXPECT_EQ(run("--solver nosuch"), 2);
  EXPECT_EQ(run("--trials 0"), 2);
}

}  // namespace
}  // namespace lcpbench
