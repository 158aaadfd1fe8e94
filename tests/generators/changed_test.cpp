// Problems of other sets, changed: that each change is what it says, and that the physical answer is the same.

#include "generators/changed.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/io/problem_checks.h"
#include "core/io/problem_io.h"
#include "core/registry.h"
#include "generators/sets.h"

namespace lcpbench::changed_test {
namespace {

std::string changed_set(const std::string& of, const std::string& by) { return "changed{of=" + of + ",by=" + by + "}"; }

DrawnChange drawn(Change change, std::int64_t draw = 0) { return {change, "test", 7, 0, draw}; }
Problem changed(const Problem& problem, Change change, std::int64_t draw = 0) {
  return drawn(change, draw).apply(problem, problem.name());
}

/// A body of 4 kg and 2 kg m^2 on two points, arms of 1/2 and -1/4 m, with friction of four edges at the first. Its
/// offsets are the fourth row of N.
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
  problem.b = N.row(3).transpose();
  return problem;
}

bool are_opposite(const ContactProblem& contact) {
  const Matrix D = to_dense(contact.D);
  const ContactLayout layout = contact_layout(contact);
  for (std::size_t i = 0; i < contact.edges.size(); ++i) {
    const Index half = contact.edges[i] / 2;
    const Index begin = layout.friction_begin[i];
    if (D.middleCols(begin, half) != -D.middleCols(begin + half, half)) return false;
  }
  return true;
}

/// The velocity after the impact, to 113 bits, or z of a bare LCP.
Vector answer_to(const Problem& problem, const char* contacts_by = "contact_lemke{precision=quad}") {
  const auto solver = make_solver(parse_spec(problem.contact() == nullptr ? "auto" : contacts_by));
  Answer answer;
  solver->load(problem);
  solver->solve({}, answer);
  EXPECT_EQ(answer.claim, Claim::kSolved) << problem.name() << ": " << answer.detail;
  return problem.contact() == nullptr ? answer.z : post_impact_velocity(*problem.contact(), answer.z);
}

TEST(ChangedTest, ThePhysicalAnswerIsTheSame) {
  for (const std::string of : {"planted/definite", "planted/definite{form=lcp}", "paper/monotone/exp1", "rigid/exp1",
                               "paper/monotone/exp1{matrix=literal}", "hard/contact/box-tilted"}) {
    const std::unique_ptr<ProblemSet> set = open_set(of);
    for (const auto& [name, change] : all_changes().values) {
      const std::unique_ptr<ProblemSet> changed = open_set(changed_set(of, name));
      for (std::int64_t trial = 0; trial < std::min<std::int64_t>(3, set->count().value_or(3)); ++trial) {
        const Problem problem = set->generate(3, trial);
        if (!applies(change, problem)) continue;
        const Vector expected = answer_to(problem);
        const Vector answer = DrawnChange(change, set->name(), 3, trial, 0)
                                  .take_back(problem, answer_to(changed->generate(3, trial)));
        const double allowed = data_change(change) > 0 ? 1e-4 : 1e-12;
        EXPECT_LE((answer - expected).lpNorm<Eigen::Infinity>(), allowed * (1 + expected.lpNorm<Eigen::Infinity>()))
            << of << " " << name << " " << trial;
      }
    }
  }
}

TEST(ChangedTest, ScalingAndUnitsChangeNoDigit) {
  const Problem problem("body", body());
  const Lcp lcp = problem.lcp();
  const Index impulses = 6;
  const Lcp units = changed(problem, Change::kUnits).lcp();
  EXPECT_TRUE(units.q == 1024 * lcp.q);
  EXPECT_TRUE((1024 * units.M).topLeftCorner(impulses, impulses) == lcp.M.topLeftCorner(impulses, impulses));
  const ContactProblem scaled = *changed(problem, Change::kScaling).contact();
  for (Index i = 0; i < 2; ++i) {
    const double factor = to_dense(scaled.N)(2, i);
    int exponent = 0;
    EXPECT_EQ(std::frexp(factor, &exponent), 0.5);
    EXPECT_LE(std::abs(exponent - 1), 10);
    EXPECT_TRUE(to_dense(scaled.N).col(i) == factor * to_dense(problem.contact()->N).col(i));
    if (i == 0) {
      EXPECT_TRUE(to_dense(scaled.D) == factor * to_dense(problem.contact()->D));
    }
  }
  const Problem bare("bare", Lcp{Matrix::Constant(1, 1, 2.0), Vector::Constant(1, -3.0)});  // z = 3/2
  for (std::int64_t draw = 0; draw < 8; ++draw) {
    const Lcp other = changed(bare, Change::kScaling, draw).lcp();
    EXPECT_EQ(drawn(Change::kScaling, draw).take_back(bare, Vector::Constant(1, -other.q(0) / other.M(0, 0)))(0), 1.5);
  }
  EXPECT_FALSE(applies(Change::kScaling, Problem("denormal", Lcp{Matrix::Constant(1, 1, 0x1p-1060), Vector::Ones(1)})));
}

TEST(ChangedTest, AnOffsetIsChangedWithItsRow) {
  const Problem problem("body", body());
  for (const auto& [name, change] : all_changes().values) {
    const ContactProblem contact = *changed(problem, change, 1).contact();
    ASSERT_EQ(contact.b.size(), contact.nc());
    const Vector row = (change == Change::kUnits ? 1024 : 1) * to_dense(contact.N).row(3).transpose();
    EXPECT_TRUE(contact.b.isApprox(row, 0x1p-29)) << name << ": " << contact.b.transpose();
    EXPECT_TRUE(are_opposite(contact)) << name;
  }
}

/// The body without friction at its contacts, with a coupler, a brake that slides, a soft stop and friction on another.
ContactProblem body_with_rows() {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  ContactProblem problem = body();
  problem.D = Matrix(6, 0);
  problem.edges = {0, 0};
  problem.mu.setZero();
  Matrix R = Matrix::Zero(6, 5);
  R(0, 0) = 1, R(1, 0) = -2;    // equality
  R(5, 1) = 1;                  // brake
  R(3, 2) = 1;                  // soft stop
  R(2, 3) = -1, R(4, 3) = 0.5;  // bears friction
  R(1, 4) = 1, R(5, 4) = 1;     // that friction
  BoundedRows& rows = problem.rows;
  rows.R = R;
  rows.bounds = LcpBounds::nonnegative(5);
  rows.bounds.lower << -kNone, -0.25, -kNone, 0, -kNone;
  rows.bounds.upper << kNone, 0.5, 0, kNone, kNone;
  rows.bounds.friction_of = {-1, -1, -1, -1, 3};
  rows.bounds.mu(4) = 0.375;
  rows.b = Vector::Zero(5);
  rows.b << 0, 0, 0.5, -0.75, 0;
  rows.compliance = Vector::Unit(5, 2) / 8;
  rows.is_angle = {0, 1, 1, 0, 0};
  return problem;
}

TEST(ChangedTest, BoundedRowsKeepTheirMotion) {
  const Problem problem("rows", body_with_rows());
  constexpr const char* kByAnyRows = "lemke";  // others take no two rows of friction with one load
  const Vector expected = answer_to(problem, kByAnyRows);
  EXPECT_GT((expected - problem.contact()->v).norm(), 0.1);
  for (const auto& [name, change] : all_changes().values) {
    if (!applies(change, problem)) continue;
    for (std::int64_t draw = 0; draw < 8; ++draw) {
      const Problem other = changed(problem, change, draw);
      EXPECT_NO_THROW(check_contact(*other.contact(), name)) << name;
      const Vector answer = drawn(change, draw).take_back(problem, answer_to(other, kByAnyRows));
      EXPECT_LE((answer - expected).lpNorm<Eigen::Infinity>(), data_change(change) > 0 ? 1e-6 : 1e-10) << name << draw;
      EXPECT_NE(problem_hash(other), problem_hash(problem)) << name << draw;
      const bool is_twice = change == Change::kDuplicate || change == Change::kNearDuplicate;
      EXPECT_EQ(other.contact()->rows.size(), is_twice ? 6 : 5) << name;
    }
  }
}

TEST(ChangedTest, LastDigitsMoveEveryNumberToANeighbour) {
  const ContactProblem before = body();
  const ContactProblem after = *changed(Problem("body", before), Change::kLastDigits).contact();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto are_neighbours = [](double a, double b) {
    return a == 0 ? b == 0 : b == std::nextafter(a, kInfinity) || b == std::nextafter(a, -kInfinity);
  };
  const auto all_neighbours = [&](const Matrix& a, const Matrix& b) {
    for (Index i = 0; i < a.size(); ++i) {
      if (!are_neighbours(a(i), b(i))) return false;
    }
    return true;
  };
  EXPECT_TRUE(all_neighbours(before.v, after.v));
  EXPECT_TRUE(all_neighbours(to_dense(before.N), to_dense(after.N)));
  EXPECT_TRUE(all_neighbours(to_dense(before.D), to_dense(after.D)));
  EXPECT_TRUE(all_neighbours(before.mu, after.mu));
  EXPECT_TRUE(all_neighbours(before.b, after.b));
  const Matrix G = dense_inertia(after.inertia);
  EXPECT_TRUE(all_neighbours(dense_inertia(before.inertia), G));
  EXPECT_TRUE(G == G.transpose());
  const Problem denormal("denormal", Lcp{Matrix::Constant(1, 1, 0x1p-1070), Vector::Constant(1, -1)});
  EXPECT_EQ(changed(denormal, Change::kLastDigits).lcp().M(0, 0), 0x1p-1070);
  constexpr double kLargest = std::numeric_limits<double>::max();
  const Problem largest("largest", Lcp{Matrix::Constant(1, 1, kLargest), Vector::Constant(1, -kLargest)});
  for (std::int64_t draw = 0; draw < 10; ++draw) {
    const Problem moved = changed(largest, Change::kLastDigits, draw);
    EXPECT_TRUE(moved.lcp().M.allFinite() && moved.lcp().q.allFinite()) << draw;
  }
}

TEST(ChangedTest, HardContactsHaveNoSoftness) {
  ContactProblem soft = body();
  soft.compliance_n = Vector::Constant(2, 0.25);
  soft.compliance_t = Vector::Unit(2, 0);
  soft.offset_t = Vector::Unit(4, 1);
  EXPECT_EQ(problem_hash(changed(Problem("soft", soft), Change::kHard)), problem_hash(Problem("hard", body())));
  EXPECT_FALSE(applies(Change::kHard, Problem("hard", body())));
}

TEST(ChangedTest, ASceneStaysOneExceptWhereItsColumnsAreScaled) {
  const Problem scene = open_set("rigid/frictional/exp1")->generate(3, 1);
  for (const auto& [name, change] : all_changes().values) {
    const Problem other = changed(scene, change);
    EXPECT_EQ(other.scene() == nullptr, change == Change::kScaling) << name;
    EXPECT_EQ(problem_hash(other) == problem_hash(scene), !applies(change, scene)) << name;
  }
  const Vector v = changed(scene, Change::kUnits).contact()->v;
  EXPECT_TRUE(drawn(Change::kUnits).take_back(scene, v) == scene.contact()->v);
}

std::string error_of(const std::string& set) {
  try {
    open_set(set);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(ChangedSetTest, IsASetLikeAllOthers) {
  const auto set = open_set("changed{by=units,draw=0,of=paper/monotone/exp2{redundancy=multiple}}");
  EXPECT_EQ(set->name(), "changed{of=paper/monotone/exp2,by=units}");
  EXPECT_EQ(set->generate(1, 3).name(), "changed{of=paper/monotone/exp2,by=units} seed 1 trial 3");
  EXPECT_EQ(open_set("changed{of=scene/box/ode}")->count(), open_set("scene/box/ode")->count());
  EXPECT_EQ(expand_sets("changed{of=*/exp1,by=duplicate}"),
            (std::vector<std::string>{"changed{of=paper/monotone/exp1,by=duplicate}",
                                      "changed{of=paper/copositive/exp1,by=duplicate}",
                                      "changed{of=rigid/exp1,by=duplicate}",
                                      "changed{of=rigid/frictional/exp1,by=duplicate}"}));
  EXPECT_NE(problem_hash(open_set("changed{of=paper/monotone/exp2}")->generate(1, 0)),
            problem_hash(open_set("changed{of=paper/monotone/exp2,draw=1}")->generate(1, 0)));
  const Problem bare = open_set("planted/definite{form=lcp}")->generate(1, 0);
  EXPECT_EQ(problem_hash(open_set("changed{of=planted/definite{form=lcp},by=duplicate}")->generate(1, 0)),
            problem_hash(bare));
  EXPECT_EQ(error_of("changed{of=nosuch}"), "unknown problem set 'nosuch'; `lcpbench sets` lists them");
  EXPECT_NE(error_of("changed{by=units,draw=-1}").find("draw = '-1'"), std::string::npos);
}

// The same bits on every machine: frozen with the random stream.
TEST(ChangedSetTest, HasTheBitsThatItHad) {
  for (const auto& [by, hash] : std::vector<std::pair<const char*, const char*>>{
           {"scaling", "a9265674de02fb663fa07838c990f0d5"},
           {"units", "c040babed2901117d0f9e10a3ad897c7"},
           {"order", "30d698bb21afb3c4e58be70f4b271c96"},
           {"duplicate", "24538cf3b70bd6b8dd8372c8d8e4ec0d"},
           {"near_duplicate", "b7b1ae549445c96e9149f09bc6edf0c3"},
           {"last_digits", "7d2def8bbd09fa9469bd449aa74f26ba"}}) {
    EXPECT_EQ(problem_hash(open_set(changed_set("paper/copositive/exp2", by))->generate(1, 0)), hash) << by;
  }
}

}  // namespace
}  // namespace lcpbench::changed_test
