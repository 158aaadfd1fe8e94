// What `inspect` says before a solver is blamed: every warning on a problem made for it, with the number behind it, and
// none about the data on problems that are what they should be.

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/problem_io.h"
#include "generators/sets.h"
#include "study/inspect/inspection.h"
#include "study/inspect/spectra.h"
#include "tests/support/program_run.h"
#include "tests/support/study_support.h"

namespace lcpbench::inspect_test {
namespace {

Problem bare(const Matrix& M, const Vector& q) { return Problem("bare", Lcp{M, q}); }

Matrix matrix(std::initializer_list<std::initializer_list<double>> rows) { return Matrix(rows); }

Vector vector(std::initializer_list<double> entries) {
  Vector v(static_cast<Index>(entries.size()));
  std::copy(entries.begin(), entries.end(), v.begin());
  return v;
}

ContactProblem contact(const Vector& v, const Matrix& N, Inertia inertia) {
  ContactProblem problem;
  problem.v = v;
  problem.N = N;
  problem.D = Matrix(v.size(), 0);
  problem.edges.assign(static_cast<std::size_t>(N.cols()), 0);
  problem.mu = Vector::Zero(N.cols());
  problem.inertia = std::move(inertia);
  return problem;
}

/// A particle of 2 kg that meets two walls and the floor, at three speeds.
ContactProblem corner() {
  return contact(vector({-1, -0.5, -0.25}), Matrix::Identity(3, 3), DenseInertia{2 * Matrix::Identity(3, 3)});
}

/// The same on the floor only, with a pyramid of four edges.
ContactProblem sliding_particle(double mu) {
  ContactProblem problem = contact(vector({3, 1, -4}), matrix({{0}, {0}, {1}}), DenseInertia{Matrix::Identity(3, 3)});
  problem.D = matrix({{1, 0, -1, 0}, {0, 1, 0, -1}, {0, 0, 0, 0}});
  problem.edges = {4};
  problem.mu = vector({mu});
  return problem;
}

Problem of(ContactProblem problem) { return Problem("contact", std::move(problem)); }

const Warning* find(const Inspection& inspection, const std::string& code) {
  const auto found = std::find_if(inspection.warnings.begin(), inspection.warnings.end(),
                                  [&](const Warning& warning) { return warning.code == code; });
  return found == inspection.warnings.end() ? nullptr : &*found;
}

std::string all_codes(const Inspection& inspection) {
  std::string codes;
  for (const Warning& warning : inspection.warnings) codes += warning.code + " ";
  return codes;
}

void expect_warning(const Problem& problem, const std::string& code, const std::string& concern, double value,
                    double within) {
  const Inspection inspection = inspect(problem);
  const Warning* warning = find(inspection, code);
  ASSERT_NE(warning, nullptr) << code << " is not among: " << all_codes(inspection);
  EXPECT_EQ(warning->concern, concern) << code;
  EXPECT_NEAR(warning->value, value, within) << code;
  EXPECT_GT(warning->text.size(), 20U) << code;
  EXPECT_EQ(warning->text.find('\n'), std::string::npos) << code;
}

void expect_data(const Problem& problem, const std::string& code, double value, double within = 0) {
  expect_warning(problem, code, "data", value, within);
}

void expect_difficulty(const Problem& problem, const std::string& code, double value, double within = 0) {
  expect_warning(problem, code, "difficulty", value, within);
}

void expect_absent(const Problem& problem, const std::string& code) {
  const Inspection inspection = inspect(problem);
  EXPECT_EQ(find(inspection, code), nullptr) << all_codes(inspection);
}

void expect_silent(const Problem& problem) {
  const Inspection inspection = inspect(problem);
  EXPECT_TRUE(inspection.warnings.empty()) << problem.name() << ": " << all_codes(inspection);
}

TEST(InspectTest, CleanProblemsGiveNoWarning) {
  expect_silent(bare(matrix({{2, -1}, {-1, 2}}), vector({-1, 0.5})));
  expect_silent(bare(matrix({{2, 1}, {-1, 2}}), vector({-1, -0.5})));
  expect_silent(of(corner()));
  expect_silent(of(sliding_particle(0.5)));
}

TEST(InspectTest, AnEmptyProblemGivesNoWarning) {
  expect_silent(bare(Matrix(0, 0), Vector(0)));
  expect_silent(of(contact(Vector(0), Matrix(0, 0), DenseInertia{Matrix(0, 0)})));
}

TEST(InspectTest, AMatrixOfTheWrongSignIsNamed) {
  const Problem negated = bare(matrix({{-2, 1}, {1, -2}}), vector({-1, 3}));
  expect_data(negated, "negative_semidefinite", -1, 1e-15);
  expect_absent(negated, "negative_diagonal");                                               // one slip, one warning
  expect_absent(bare(matrix({{0, 1}, {-1, 0}}), vector({-1, 1})), "negative_semidefinite");  // skew: no sign at all
}

TEST(InspectTest, ANegativeDiagonalIsNamed) {
  expect_data(bare(matrix({{2, 1}, {1, -3}}), vector({-1, 1})), "negative_diagonal", -3);
}

TEST(InspectTest, AQThatMakesTheProblemTrivialIsNamed) {
  expect_data(bare(matrix({{2, 0}, {0, 2}}), vector({0.25, 1})), "trivial", 0.25);
  expect_absent(bare(matrix({{2, 0}, {0, 2}}), vector({-1e-300, 1})), "trivial");
  ContactProblem separating = corner();
  separating.v = -separating.v;
  expect_data(of(separating), "trivial", 0.25);
}

TEST(InspectTest, ATransposedMatrixIsNamedWhereItMakesARowImpossible) {
  // Pang's isolated solution, as a public copy prints it: read by rows what was stored by columns.
  const Matrix printed = matrix({{0, 1, -1}, {-1, 0, 0}, {-1, 0, 0}});
  const Vector q = vector({0, -1, 1});
  expect_data(bare(printed, q), "transposed", 1);
  expect_data(bare(printed, q), "impossible_rows", 1);
  expect_absent(bare(printed.transpose(), q), "transposed");
}

TEST(InspectTest, ARowThatNothingCanSatisfyIsNamed) {
  expect_data(bare(matrix({{0}}), vector({-1})), "impossible_rows", 1);
  expect_data(bare(matrix({{-1, -2}, {0, 1}}), vector({-1, -1})), "impossible_rows", 1);
  expect_absent(bare(matrix({{0}}), vector({0})), "impossible_rows");
}

TEST(InspectTest, LostSymmetryIsToldFromAnotherMatrix) {
  expect_data(bare(matrix({{2, 1 + 0x1p-40}, {1, 2}}), vector({-1, 1})), "nearly_symmetric", 0x1p-41);
  expect_absent(bare(matrix({{2, 1}, {-1, 2}}), vector({-1, 1})), "nearly_symmetric");
}

TEST(InspectTest, ABareMatrixThatRoundingMadeIndefiniteIsNamed) {
  const double above = 1 + 0x1p-52;
  expect_difficulty(bare(matrix({{1, above}, {above, 1}}), vector({-1, -2})), "rounded_indefinite", -0x1p-52, 1e-24);
  expect_absent(bare(matrix({{1, 2}, {2, 1}}), vector({-1, -2})), "rounded_indefinite");  // truly indefinite
}

TEST(InspectTest, TheMatrixFormedFromSoundDataMayBeIndefinite) {
  // Ginv = fl(1/3), N = [1 3]: M rounds to [fl(1/3) 1; 1 3], whose determinant is 3 fl(1/3) - 1 = -2^-54.
  const Problem problem = of(contact(vector({-1}), matrix({{1, 3}}), InverseInertia{matrix({{1.0 / 3}})}));
  expect_difficulty(problem, "rounded_indefinite", -0x1p-54 / (10.0 / 3), 1e-22);
}

TEST(InspectTest, TiesAndZeroQAreCounted) {
  const Problem tied = bare(2 * Matrix::Identity(4, 4), vector({-1, -1, 0, 2}));
  expect_difficulty(tied, "tied_q", 2);
  expect_difficulty(tied, "zero_q", 1);
  expect_absent(bare(2 * Matrix::Identity(2, 2), vector({-1, -2})), "tied_q");
}

TEST(InspectTest, ScalingAndMagnitudeAreMeasured) {
  expect_difficulty(bare(matrix({{1, 0}, {0, 0x1p-40}}), vector({-1, -1})), "scaling_spread", 0x1p40);
  expect_absent(bare(matrix({{1, 0}, {0, 0x1p-20}}), vector({-1, -2})), "scaling_spread");
  expect_difficulty(bare(matrix({{0x1p-1000}}), vector({-1})), "extreme_magnitude", 0x1p-1000);
  expect_difficulty(bare(matrix({{0x1p1000}}), vector({-1})), "extreme_magnitude", 0x1p1000);
}

TEST(InspectTest, ConditioningIsThatOfTheMatrixWithUnitDiagonal) {
  const double off = 1 - 0x1p-30;
  expect_difficulty(bare(matrix({{1, off}, {off, 1}}), vector({-1, -2})), "ill_conditioned_matrix", (1 + off) / 0x1p-30,
                    1);
  expect_absent(bare(matrix({{0x1p60, 0}, {0, 1}}), vector({-1, -2})), "ill_conditioned_matrix");  // only units
}

// The square roots of 3 and 27 are irrational; rounded in double they would leave an eigenvalue of 1e-16.
TEST(InspectTest, ASingularMatrixWithUnitDiagonalStaysSingular) {
  const Matrix singular = matrix({{3, 9}, {9, 27}});
  EXPECT_NEAR(inspect(bare(singular, vector({-1, -3}))).facts["matrix"]["condition"].get<double>(), 1, 1e-14);
  const Problem problem = of(contact(vector({-1, -2}), Matrix::Identity(2, 2), InverseInertia{singular}));
  EXPECT_NEAR(inspect(problem).facts["contact"]["inertia_condition_scaled"].get<double>(), 1, 1e-14);
}

// The nonzero eigenvalues of X X' are those of X'X = diag(14, 1.25); scaled, of X'D^-1 X: trace 3, determinant 22/17.
TEST(InspectTest, FactorsOfReducedRankHaveTheConditionOfTheirRange) {
  const FactoredInertia factors{matrix({{1, 1}, {2, -0.5}, {3, 0}}), vector({0.1, 0.1})};
  const Inspection found = inspect(of(contact(vector({-1, 0, 0}), matrix({{1}, {0}, {0}}), factors)));
  EXPECT_NEAR(found.facts["contact"]["inertia_condition"].get<double>(), 14 / 1.25, 1e-12);
  const double root = std::sqrt(65.0 / 17);
  EXPECT_NEAR(found.facts["contact"]["inertia_condition_scaled"].get<double>(), (3 + root) / (3 - root), 1e-12);
}

TEST(InspectTest, SpeedsThatNoImpactHasAreNamed) {
  ContactProblem fast = corner();
  fast.v *= 2048;
  expect_data(of(fast), "fast_impact", 2048);
  ContactProblem slow = corner();
  slow.v *= 0x1p-12;
  expect_difficulty(of(slow), "slow_impact", 0x1p-12);
}

/// A rod of 1 kg and 2 m along x, one end on the floor.
ContactProblem rod(bool inverted) {
  Vector diagonal = vector({1, 1, 1, 0x1p-10, 0.33, 0.33});
  if (inverted) diagonal = diagonal.cwiseInverse();
  const Matrix N = matrix({{0}, {0}, {1}, {0}, {-1}, {0}});
  return contact(vector({0, 0, -1, 0, 0, 0}), N, BlockInertia{{Matrix(diagonal.asDiagonal())}});
}

TEST(InspectTest, AnInverseGivenAsTheInertiaIsNamedByItsMoments) {
  expect_silent(of(rod(false)));
  expect_data(of(rod(true)), "inertia_inverted", 1);
  ContactProblem inverse = rod(true);
  inverse.inertia = InverseInertia{std::get<BlockInertia>(inverse.inertia).blocks[0]};
  expect_absent(of(inverse), "inertia_inverted");
  inverse.inertia = InverseInertia{std::get<BlockInertia>(rod(false).inertia).blocks[0]};
  expect_data(of(inverse), "inertia_inverted", 1);
}

TEST(InspectTest, AnInverseGivenAsTheInertiaIsNamedByItsLeverArms) {
  // A cube of 8 kg and edge 2 cm: moments m a^2 / 6 each, in either reading a mass distribution that exists.
  const double moment = 8 * 0.02 * 0.02 / 6;
  const Vector diagonal = vector({8, 8, 8, moment, moment, moment});
  const Matrix N = matrix({{0}, {0}, {1}, {0.01}, {-0.01}, {0}});
  const Vector v = vector({0, 0, -1, 0, 0, 0});
  expect_silent(of(contact(v, N, BlockInertia{{Matrix(diagonal.asDiagonal())}})));
  expect_data(of(contact(v, N, BlockInertia{{Matrix(diagonal.cwiseInverse().asDiagonal())}})), "inertia_inverted", 1);
}

/// The ball of the tutorial: 1 kg, radius 0.1 m, lengths times `unit`, its moments inverted or not.
Problem ball(double unit, bool inverted, double mass = 1) {
  RigidScene scene;
  RigidBody body;
  body.mass = mass;
  const double moment = 0.4 * mass * 0.01 * unit * unit;
  body.inertia = (inverted ? 1 / moment : moment) * Eigen::Matrix3d::Identity();
  body.position = {0, 0, 0.1 * unit};
  body.linear_velocity = {0.3 * unit, 0, -unit};
  scene.bodies = {body};
  RigidContact floor;
  floor.body_a = 0;
  floor.body_b = RigidContact::kWorld;
  floor.normal = {0, 0, 1};
  floor.tangent = {1, 0, 0};
  floor.mu = 0.5;
  floor.edges = 4;
  scene.contacts = {floor};
  return Problem("ball", std::move(scene));
}

TEST(InspectTest, MillimetresAndAnInvertedInertiaOfTheTutorialsBallAreNamed) {
  for (const double mass : {0.1, 1.0, 3.0}) {
    expect_absent(ball(1, false, mass), "length_units");
    expect_absent(ball(1, false, mass), "inertia_inverted");
    expect_data(ball(1000, false, mass), "length_units", 1);
    expect_absent(ball(1000, false, mass), "inertia_inverted");
    expect_data(ball(1, true, mass), "inertia_inverted", 1);
  }
  expect_absent(ball(1, true), "length_units");  // one slip, one warning
  expect_data(ball(1000, false), "fast_impact", 1000);
}

// Positions in millimetres beside moments in kg m^2: the contacts act far outside of the body.
TEST(InspectTest, LeverArmsInOtherUnitsThanTheInertiaAreNamed) {
  for (const Index axis : {3, 4, 5}) {
    ContactProblem problem = rod(false);
    std::get<Matrix>(problem.N)(axis, 0) = -1000;
    expect_data(of(problem), "length_units", 1);
  }
}

TEST(InspectTest, ASingularInertiaIsNamed) {
  const FactoredInertia flat{matrix({{1, 0}, {0, 1}, {0, 0}}), vector({2, 3})};
  const Problem problem = of(contact(vector({-1, -0.5, -0.25}), Matrix::Identity(3, 3), flat));
  expect_difficulty(problem, "singular_inertia", 2);
  expect_absent(of(corner()), "singular_inertia");
}

TEST(InspectTest, AnIllConditionedInertiaIsNamedUnlessItIsOnlyUnits) {
  const double off = 1 - 0x1p-30;
  expect_difficulty(of(contact(vector({-1, -2}), Matrix::Identity(2, 2), DenseInertia{matrix({{1, off}, {off, 1}})})),
                    "ill_conditioned_inertia", (1 + off) / 0x1p-30, 0x1p10);  // eigenvalues in double: eps / 2^-30
  expect_absent(
      of(contact(vector({-1, -2}), Matrix::Identity(2, 2), DenseInertia{matrix({{0x1p20, 0}, {0, 0x1p-20}})})),
      "ill_conditioned_inertia");
}

TEST(InspectTest, TheSpreadOfMassesIsThatOfTheBodies) {
  const auto body = [](double mass) { return Matrix(vector({mass, mass, mass, mass, mass, mass}).asDiagonal()); };
  Matrix N = Matrix::Zero(12, 1);
  N(2, 0) = 1;
  N(8, 0) = -1;
  N(3, 0) = 1;
  N(9, 0) = -1;
  Vector v = Vector::Zero(12);
  v(2) = -1;
  expect_difficulty(of(contact(v, N, BlockInertia{{body(0x1p21), body(1)}})), "mass_ratio", 0x1p21);
  expect_silent(of(contact(v, N, BlockInertia{{body(1000), body(1)}})));
}

TEST(InspectTest, RedundantContactsAreCounted) {
  // A box on its four corners: normal, roll, pitch.
  const Matrix N = matrix({{1, 1, 1, 1}, {1, 1, -1, -1}, {1, -1, 1, -1}});
  const Problem box = of(contact(vector({-1, 0.25, 0.5}), N, DenseInertia{Matrix::Identity(3, 3)}));
  expect_difficulty(box, "redundant_contacts", 1);
  expect_absent(box, "nearly_redundant_contacts");
  expect_absent(of(corner()), "redundant_contacts");
}

TEST(InspectTest, NearAndExactDuplicatesAndOpposedContactsAreToldApart) {
  const DenseInertia unit{Matrix::Identity(2, 2)};
  const Vector v = vector({-1, -0.5});
  const Problem near = of(contact(v, matrix({{1, 1}, {0, 0x1p-30}}), unit));
  expect_difficulty(near, "near_duplicate_contacts", 0x1p-30, 1e-16);
  expect_difficulty(near, "nearly_redundant_contacts", 1);
  expect_absent(near, "duplicate_contacts");
  expect_absent(near, "redundant_contacts");

  const Problem twice = of(contact(v, matrix({{1, 3}, {0.1, 3 * 0.125}}), unit));
  expect_absent(twice, "duplicate_contacts");
  const Problem exact = of(contact(v, matrix({{1, 3}, {0.125, 0.375}}), unit));
  expect_difficulty(exact, "duplicate_contacts", 1);
  expect_absent(exact, "near_duplicate_contacts");

  const Problem opposed = of(contact(v, matrix({{1, -1}, {0, 0}}), unit));
  expect_difficulty(opposed, "opposed_contacts", 1);
  expect_absent(opposed, "duplicate_contacts");
}

/// A coordinate in other units is the same problem: with v and 1 / N 2^10 times as large, G is 2^-20 times as large.
TEST(InspectTest, NearDuplicatesDoNotDependOnUnits) {
  for (const double unit : {1.0, 0x1p-10, 0x1p10}) {
    const Matrix N = matrix({{1, 1}, {0, 0x1p-14 / unit}});
    const Matrix G = matrix({{1, 0}, {0, 1 / (unit * unit)}});
    for (const Inertia& inertia : {Inertia(DenseInertia{G}), Inertia(InverseInertia{G.inverse()})}) {
      const Problem problem = of(contact(vector({-1, 0.5 * unit}), N, inertia));
      expect_difficulty(problem, "near_duplicate_contacts", 0x1p-14, 1e-12);
      expect_absent(problem, "nearly_redundant_contacts");
    }
  }
}

/// Compliance is on the diagonal of M: what yields has one impulse, and pushes against nothing freely.
TEST(InspectTest, SoftContactsDependOnNoOthers) {
  const Matrix N = matrix({{1, 1, -1}, {0, 0x1p-40, 0}});
  ContactProblem soft = contact(vector({-1, 0.5}), N, DenseInertia{Matrix::Identity(2, 2)});
  expect_difficulty(of(soft), "redundant_contacts", 1);
  soft.compliance_n = vector({0.5, 0.25, 0.125});
  for (const char* code : {"redundant_contacts", "nearly_redundant_contacts", "opposed_contacts"}) {
    expect_absent(of(soft), code);
  }
  expect_absent(of(soft), "ill_conditioned_matrix");
  soft.compliance_n = vector({0, 0.25, 0});  // the other two are as rigid as before
  expect_difficulty(of(soft), "redundant_contacts", 1);
  expect_difficulty(of(soft), "opposed_contacts", 1);
  expect_absent(of(soft), "nearly_redundant_contacts");
}

TEST(InspectTest, ContactsThatPushNothingAreNamed) {
  ContactProblem problem = corner();
  std::get<Matrix>(problem.N).col(1).setZero();
  expect_data(of(problem), "zero_normals", 1);
  expect_absent(of(problem), "tiny_normals");
  problem.N = Matrix(1e-17 * to_dense(problem.N));
  expect_data(of(problem), "tiny_normals", 1e-17, 1e-20);
}

TEST(InspectTest, OddFrictionIsNamed) {
  expect_difficulty(of(sliding_particle(0)), "frictionless_edges", 1);
  expect_data(of(sliding_particle(30)), "huge_friction", 30);
  ContactProblem lame = sliding_particle(0.5);
  lame.D = matrix({{1, 0, -1, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}});
  expect_data(of(lame), "zero_directions", 2);
}

TEST(InspectTest, FactsOfASmallProblemAreThoseOfTheTextbook) {
  // The two contacts of corner() in x and y alone do not know of each other, and the third separates.
  ContactProblem problem = corner();
  problem.v = vector({-1, 0, 0.25});
  const auto facts = inspect(of(problem)).facts;
  EXPECT_EQ(facts["problem"]["n"], 3);
  EXPECT_EQ(facts["contact"]["islands"], 3);
  EXPECT_EQ(facts["contact"]["rank_N"]["exact"], 3);
  EXPECT_DOUBLE_EQ(facts["contact"]["inertia_condition"].get<double>(), 1);
  EXPECT_DOUBLE_EQ(facts["contact"]["condition"].get<double>(), 1);
  EXPECT_DOUBLE_EQ(facts["matrix"]["spectrum"]["smallest"].get<double>(), 0.5);
  EXPECT_EQ(facts["matrix"]["spectrum"]["definiteness"], "positive definite");
  EXPECT_EQ(facts["velocity"]["negative"], 1);
  EXPECT_EQ(facts["velocity"]["zero"], 1);
}

TEST(InspectTest, NothingIsSaidOfTheSpectrumOfAMatrixThatOverflows) {
  const auto facts = inspect(of(contact(vector({-1}), matrix({{1e200}}), DenseInertia{matrix({{1}})}))).facts;
  EXPECT_TRUE(facts["matrix"]["spectrum"]["definiteness"].is_null());
  EXPECT_TRUE(facts["matrix"]["spectrum"]["rank"].is_null());
}

TEST(InspectTest, OffsetsCountInTheSpeedsOfTheMessage) {
  ContactProblem problem = contact(vector({-1}), matrix({{1}}), DenseInertia{matrix({{1}})});
  problem.b = vector({1.5});
  const Inspection inspection = inspect(of(problem));
  ASSERT_NE(find(inspection, "trivial"), nullptr);
  EXPECT_NE(find(inspection, "trivial")->text.find("(least N'v + b 0.5 m/s)"), std::string::npos);
}

TEST(InspectTest, RankIsThatOfTheDoublesWhateverTheirExponents) {
  EXPECT_EQ(rank_of_doubles(matrix({{0.1, 0.2}, {0.2, 0.4}})), 1);
  EXPECT_EQ(rank_of_doubles(matrix({{0.1, 0.3}, {0.2, 0.6}})), 1);
  EXPECT_EQ(rank_of_doubles(matrix({{0.1, 0.2}, {0.2, 0.4 + 0x1p-54}})), 2);
  EXPECT_EQ(rank_of_doubles(matrix({{0x1p-1074, 1}, {0, 0x1p1000}})), 2);
  EXPECT_EQ(rank_of_doubles(matrix({{1, -1}, {-1, 1}})), 1);
  EXPECT_EQ(rank_of_doubles(Matrix::Zero(3, 2)), 0);
}

/// 1 / m of a subnormal mass overflows, and M with it. FLINT ends the program at an infinity.
TEST(InspectTest, AMassBelowTheNormalNumbersIsInspected) {
  RigidScene scene;
  scene.bodies = {RigidBody{.mass = 5e-324, .linear_velocity = {0, 0, -1}}};
  scene.contacts = {RigidContact{.mu = 0.5, .edges = 4}};
  const Inspection inspection = inspect(Problem("light", scene));
  EXPECT_TRUE(inspection.facts["matrix"]["rank"]["exact"].is_null());
  EXPECT_EQ(inspection.facts["contact"]["rank_N"]["exact"], 1);
  EXPECT_NE(find(inspection, "extreme_magnitude"), nullptr) << all_codes(inspection);
}

/// Random problems are what they should be: about their data there is nothing to say but that some are trivial.
TEST(InspectTest, RandomSetsRaiseNoDoubtAboutTheirData) {
  for (const char* name :
       {"paper/monotone/exp1", "paper/monotone/exp2", "paper/monotone/exp3", "paper/monotone/exp5-1e10",
        "paper/copositive/exp1", "rigid/exp1", "rigid/exp5-1e8", "rigid/frictional/exp1"}) {
    const std::unique_ptr<ProblemSet> set = open_set(name);
    for (std::int64_t trial = 0; trial < 12; ++trial) {
      const Problem problem = set->generate(1, trial);
      const Inspection inspection = inspect(problem);
      for (const Warning& warning : inspection.warnings) {
        if (warning.code == "trivial" && inspection.facts["velocity"]["negative"] == 0) continue;
        EXPECT_EQ(warning.concern, "difficulty") << name << " trial " << trial << ": " << warning.text;
      }
    }
  }
}

TEST(SpectrumTest, BoundsOfLargeMatricesCoverTheirFormationAndTheRangeOfDoubles) {
  const Matrix unit = Matrix::Identity(kLargestQuad + 1, kLargestQuad + 1);
  EXPECT_GE(spectrum_of(QuadMatrix(unit), 1e-6).rounding, 1e-6);
  for (const double size : {1e-200, 1.0, 1e200}) {
    EXPECT_GT(spectrum_of(size * unit).rounding, 0) << size;
    EXPECT_TRUE(spectrum_of(size * unit).positive_definite()) << size;
  }
}

class InspectCommandTest : public ::testing::Test {
 protected:
  int run(const std::string& arguments) { return run_program(folder_ / "", "inspect " + arguments).exit_code; }
  std::string text(const std::string& name) { return read_file(folder_ / name); }
  ScratchFolder folder_;
};

TEST_F(InspectCommandTest, PrintsAllFilesAndExitsWithTwoWhenOneCannotBeRead) {
  write_problem(bare(matrix({{-1}}), vector({1})), folder_ / "sign.json");
  const std::string sign = (folder_ / "sign.json").string();
  EXPECT_EQ(run("'" + sign + "'"), 0);
  EXPECT_NE(text("out").find("[negative_semidefinite]"), std::string::npos) << text("out");
  EXPECT_EQ(run("/nonexistent '" + sign + "' --format json"), 2);
  EXPECT_NE(text("err").find("/nonexistent"), std::string::npos);
  const nlohmann::json rows = nlohmann::json::parse(text("out"));
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0]["problem"]["n"], 1);
  EXPECT_EQ(rows[0]["warnings"][0]["code"], "negative_semidefinite");
  EXPECT_EQ(rows[0]["warnings"][0]["concern"], "data");
  EXPECT_EQ(rows[0]["matrix"]["spectrum"]["smallest"], -1);
}

TEST_F(InspectCommandTest, EveryWarningIsDocumented) {
  std::ifstream page(LCPBENCH_INSPECT_PAGE);
  const std::string documented{std::istreambuf_iterator<char>(page), {}};
  std::string code;
  for (const char* file : {LCPBENCH_INSPECT_SOURCES "/inspection.cpp", LCPBENCH_INSPECT_SOURCES "/contact_facts.cpp"}) {
    std::ifstream source(file);
    code.append(std::istreambuf_iterator<char>(source), {});
  }
  std::size_t found = 0;
  for (std::size_t at = code.find('"'); at != std::string::npos; at = code.find('"', at + 1)) {
    const std::size_t end = code.find('"', at + 1);
    if (end == std::string::npos) break;
    const std::string word = code.substr(at + 1, end - at - 1);
    at = end;
    const bool is_code = word.find('_') != std::string::npos &&
                         word.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") == std::string::npos;
    if (!is_code) continue;
    ++found;
    EXPECT_NE(documented.find("`" + word + "`"), std::string::npos) << word;
  }
  EXPECT_GE(found, 20U);
}

}  // namespace
}  // namespace lcpbench::inspect_test
