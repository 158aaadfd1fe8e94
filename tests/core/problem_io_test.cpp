// Problem files out and in again: every number keeps its bits, the file is a function of the problem alone, and equal
// data hash alike however they are stored.

#include "core/io/problem_io.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "core/error.h"
#include "core/io/problem_checks.h"
#include "generators/sets.h"

namespace lcpbench::problem_io_test {
namespace {

namespace fs = std::filesystem;

/// A folder of its own per test, removed at the end.
class ProblemIoTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(::testing::TempDir()) / ("problem_io_test-" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write_text(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }

  fs::path folder_;
};

std::string error_of(const fs::path& file) {
  try {
    read_problem(file);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

std::vector<double> numbers_of(const Matrix& matrix) { return {matrix.data(), matrix.data() + matrix.size()}; }

void expect_same_bits(const Matrix& a, const Matrix& b) {
  ASSERT_EQ(a.rows(), b.rows());
  ASSERT_EQ(a.cols(), b.cols());
  const std::vector<double> x = numbers_of(a);
  const std::vector<double> y = numbers_of(b);
  for (std::size_t i = 0; i < x.size(); ++i) {
    EXPECT_EQ(std::bit_cast<std::uint64_t>(x[i]), std::bit_cast<std::uint64_t>(y[i])) << x[i] << " became " << y[i];
  }
}

Problem written_and_read(const Problem& problem) { return parse_problem_json(problem_json(problem), "again.json"); }

void expect_round_trip(const Problem& problem) {
  const Problem again = written_and_read(problem);
  EXPECT_EQ(again.name(), problem.name());
  EXPECT_EQ(again.kind(), problem.kind());
  EXPECT_EQ(problem_json(again), problem_json(problem));
  EXPECT_EQ(problem_hash(again), problem_hash(problem));
}

/// Any finite double, each bit pattern equally likely: half of all exponents are extreme.
double random_bits(std::mt19937_64& random) {
  for (;;) {
    const auto value = std::bit_cast<double>(random());
    if (std::isfinite(value)) return value;
  }
}

Matrix random_matrix(std::mt19937_64& random, Index rows, Index cols) {
  Matrix matrix(rows, cols);
  for (double& entry : matrix.reshaped()) entry = random_bits(random);
  return matrix;
}

ContactProblem frictional_problem() {
  ContactProblem problem;
  problem.v = Vector::LinSpaced(3, -1, 1);
  problem.N = Matrix{{1, 0}, {0.5, 1}, {-0.25, 2}};
  problem.D = Matrix{{1, 0, -1, 0}, {0.25, 1, -0.25, -1}, {3, -0.0, -3, 0}};
  problem.edges = {0, 4};
  problem.mu = Vector{{0, 0.5}};
  problem.inertia = DenseInertia{Matrix{{4, 1, 0}, {1, 3, 0.1}, {0, 0.1, 2}}};
  return problem;
}

ContactProblem frictionless_problem() {
  ContactProblem problem = frictional_problem();
  problem.D = Matrix(3, 0);
  problem.edges = {0, 0};
  problem.mu = Vector::Zero(2);
  return problem;
}

RigidScene scene() {
  RigidScene scene;
  scene.bodies.resize(2);
  scene.bodies[1].mass = 0.1;
  scene.bodies[1].inertia << 2, 0.5, 0, 0.5, 1, 0, 0, 0, 3;
  scene.bodies[1].position << 0.1, -0.0, 2.5;
  scene.bodies[1].angular_velocity << 1e-300, 5e-324, -3;
  RigidContact resting;
  resting.tangent = Eigen::Vector3d::UnitY();
  resting.mu = 0.7;
  resting.edges = 4;
  RigidContact frictionless;
  frictionless.body_a = 1;
  frictionless.body_b = 0;
  frictionless.normal = Eigen::Vector3d(0.6, 0, 0.8);
  scene.contacts = {resting, frictionless};
  return scene;
}

Lcp mixed_problem() {
  Lcp lcp{Matrix{{2, 1, 0}, {1, 2, 0.5}, {0, 0.5, 1}}, Vector{{-5, -6, 7}}, LcpBounds::nonnegative(3)};
  lcp.bounds.lower(2) = -INFINITY;
  lcp.bounds.upper(1) = 0.1;
  lcp.bounds.friction_of = {-1, -1, 0};
  lcp.bounds.mu(2) = 0.25;
  return lcp;
}

/// An equality, a soft brake, a limit, and friction of that.
ContactProblem problem_with_rows() {
  ContactProblem problem = frictional_problem();
  BoundedRows& rows = problem.rows;
  rows.R = Matrix{{1, 0, 0.1, -0.0}, {0, 5e-324, 1, 0}, {-1, 1, 0, 1}};
  rows.bounds = LcpBounds::nonnegative(4);
  rows.bounds.lower = Vector{{-INFINITY, -0.1, 0, -INFINITY}};
  rows.bounds.upper = Vector{{INFINITY, 1e-300, INFINITY, INFINITY}};
  rows.bounds.friction_of[3] = 2;
  rows.bounds.mu(3) = 0.3;
  rows.b = Vector{{0.5, -0.0, 0, 1}};
  rows.compliance = Vector{{0, 0.001, 0, 0}};
  rows.is_angle = {0, 1, 1, 0};
  rows.names = {"weld", "", "limit \"a\"", "screw"};
  return problem;
}

std::vector<Problem> problems_of_every_kind() {
  std::vector<Problem> problems;
  problems.emplace_back("lcp", Lcp{Matrix{{2, 1}, {1, 2}}, Vector{{-5, -6}}});
  problems.emplace_back("mixed", mixed_problem());
  problems.emplace_back("frictional", frictional_problem());
  problems.emplace_back("frictionless", frictionless_problem());
  ContactProblem factored = frictional_problem();
  factored.inertia = FactoredInertia{Matrix{{1, 2}, {3, -4}, {0.5, 0.125}}, Vector{{2, 0.1}}};
  problems.emplace_back("factored", factored);
  ContactProblem inverse = frictional_problem();
  inverse.inertia = InverseInertia{Matrix{{1, 1, 0}, {1, 1, 0}, {0, 0, 2}}};
  problems.emplace_back("inverse", inverse);
  problems.emplace_back("scene", scene());
  problems.emplace_back("rows", problem_with_rows());
  ContactProblem offset = frictional_problem();
  offset.b = Vector{{0.1, -0.0}};
  problems.emplace_back("offset", offset);
  RigidScene gap = scene();
  gap.contacts[0].b = 0.25;
  gap.contacts[1].b = -1e-300;
  problems.emplace_back("scene with offsets", gap);
  return problems;
}

TEST_F(ProblemIoTest, EveryKindComesBackEqual) {
  for (const Problem& problem : problems_of_every_kind()) {
    SCOPED_TRACE(problem.name());
    expect_round_trip(problem);
  }
}

TEST_F(ProblemIoTest, EveryGeneratedProblemComesBackEqual) {
  for (const SetInfo& set : list_sets()) {
    SCOPED_TRACE(set.name);
    const auto problems = open_set(set.name);
    const std::int64_t trials = std::min<std::int64_t>(3, problems->count().value_or(3));
    for (std::int64_t trial = 0; trial < trials; ++trial) expect_round_trip(problems->generate(1, trial));
  }
}

TEST_F(ProblemIoTest, AnOffsetOfZeroIsNone) {
  ContactProblem contact = frictional_problem();
  const Problem without("contact", contact);
  contact.b = Vector{{0.0, -0.0}};
  EXPECT_EQ(problem_json(Problem("contact", contact)), problem_json(without));
  EXPECT_EQ(problem_hash(Problem("contact", contact)), problem_hash(without));
  contact.b(1) = 1e-300;
  EXPECT_NE(problem_hash(Problem("contact", contact)), problem_hash(without));
  std::string text = problem_json(without);
  text.insert(text.rfind("\n}"), ",\n  \"b\": [0, 0]");
  EXPECT_FALSE(parse_problem_json(text, "zero.json").contact()->has_offset());

  RigidScene bodies = scene();
  const Problem touching("scene", bodies);
  EXPECT_FALSE(touching.contact()->has_offset());
  bodies.contacts[1].b = 0.5;
  const Problem apart("scene", bodies);
  EXPECT_EQ(apart.contact()->b, (Vector{{0, 0.5}}));
  EXPECT_NE(problem_hash(apart), problem_hash(touching));
}

/// A dense G of this order would exceed kMaxNumbers; its one factor does not.
TEST_F(ProblemIoTest, BoundsOfEveryLcpAreNone) {
  const std::string plain = problem_json(Problem("p", Lcp{Matrix{{1, 0}, {0, 1}}, Vector{{-1, -2}}}));
  const auto with = [&](const std::string& fields) {
    return parse_problem_json(plain.substr(0, plain.rfind('}')) + fields + "}", "p.json");
  };
  for (const char* fields :
       {R"(,"lower":[0,0])", R"(,"upper":[null,null])", R"(,"friction_of":[null,-1],"mu":[0,null])"}) {
    EXPECT_EQ(problem_json(with(fields)), plain) << fields;
  }
  const Lcp free = with(R"(,"lower":[null,0])").lcp();
  EXPECT_TRUE(free.is_mixed());
  EXPECT_TRUE(free.bounds.is_free(0) && !free.bounds.is_free(1));
  const Lcp friction = with(R"(,"friction_of":[null,0],"mu":[null,0.5])").lcp();
  EXPECT_EQ(friction.bounds.lower(1), -INFINITY);
  EXPECT_EQ(friction.bounds.mu, (Vector{{0, 0.5}}));
}

TEST_F(ProblemIoTest, BoundedRowsComeBackDenseAndSparse) {
  ContactProblem sparse = problem_with_rows();
  sparse.rows.R = SparseMatrix(to_dense(sparse.rows.R).sparseView(0, 0));
  for (const bool dense : {true, false}) {
    const Problem given("rows", dense ? problem_with_rows() : sparse);
    const Problem again = parse_problem_json(problem_json_line(given, dense), "line");
    const BoundedRows &rows = again.contact()->rows, &expected = given.contact()->rows;
    EXPECT_EQ(std::holds_alternative<Matrix>(rows.R), dense);
    EXPECT_EQ(to_dense(rows.R), to_dense(expected.R));
    EXPECT_EQ(rows.bounds.lower, expected.bounds.lower);
    EXPECT_EQ(rows.bounds.upper, expected.bounds.upper);
    EXPECT_EQ(rows.bounds.friction_of, expected.bounds.friction_of);
    EXPECT_EQ(rows.bounds.mu, expected.bounds.mu);
    EXPECT_EQ(rows.b, expected.b);
    EXPECT_EQ(rows.compliance, expected.compliance);
    EXPECT_EQ(rows.is_angle, expected.is_angle);
    EXPECT_EQ(rows.names, expected.names);
    EXPECT_EQ(again.size(), given.size());
  }
}

TEST_F(ProblemIoTest, RowsWithoutOptionalFieldsAreInMetres) {
  const auto with = [](const std::string& rows) {
    return parse_problem_json(
        R"({"format":"lcpbench-problem","version":1,"name":"p","kind":"contact","v":[1],"N":[[]],"G":[[1]],"rows":)" +
            rows + "}",
        "p.json");
  };
  const BoundedRows rows = with(R"({"R":[[1,2]],"lower":[-1e20,-1],"upper":[null,1e20],"b":[0,0],"compliance":[0,-0]})")
                               .contact()
                               ->rows;
  EXPECT_TRUE(rows.bounds.is_free(0));
  EXPECT_EQ(rows.bounds.upper(1), INFINITY);
  EXPECT_EQ(rows.is_angle, (std::vector<char>{0, 0}));
  EXPECT_EQ(rows.b.size() + rows.compliance.size(), 0);
  EXPECT_TRUE(rows.names.empty());
  const std::string none = problem_hash(with(R"({"R":[[]],"lower":[],"upper":[]})"));
  ContactProblem alone;
  alone.v = Vector{{1}};
  alone.N = alone.D = Matrix(1, 0);
  alone.inertia = DenseInertia{Matrix{{1}}};
  EXPECT_EQ(none, problem_hash(Problem("p", alone)));
}

/// As OSQP and Siconos write infinity.
TEST_F(ProblemIoTest, BoundsOf1e20AreNone) {
  const auto with = [&](const std::string& bounds) {
    return parse_problem_json(
        R"({"format":"lcpbench-problem","version":1,"name":"p","kind":"lcp","M":[[2,1],[1,2]],"q":[-5,6])" + bounds + "}",
        "p.json");
  };
  const Lcp lcp = with(R"(,"lower":[-1e20,-1e30],"upper":[1e20,9e19])").lcp();
  EXPECT_TRUE(lcp.bounds.is_free(0));
  EXPECT_EQ(lcp.bounds.lower(1), -INFINITY);
  EXPECT_EQ(lcp.bounds.upper(1), 9e19);
  EXPECT_EQ(lcp.dropped_bounds, 3);
  EXPECT_FALSE(with(R"(,"lower":[0,0],"upper":[1e20,1e20])").lcp().is_mixed());
}

TEST_F(ProblemIoTest, FactorsOfALargeInertiaAreWrittenDense) {
  constexpr Index kOrder = kMaxDenseOrder + 1;
  ContactProblem contact;
  contact.v = Vector::Zero(kOrder);
  contact.N = Matrix::Identity(kOrder, 1);
  contact.D = Matrix(kOrder, 0);
  contact.edges = {0};
  contact.mu = Vector::Zero(1);
  contact.inertia = FactoredInertia{Matrix::Identity(kOrder, 1), Vector::Ones(1)};
  const std::string line = problem_json_line(Problem("factored", contact), true);
  EXPECT_EQ(parse_problem_json(line, "line").contact()->ngc(), kOrder);
}

TEST_F(ProblemIoTest, InertiaKeepsItsForm) {
  const auto form = [](const Problem& problem) { return problem.contact()->inertia.index(); };
  for (const Problem& problem : problems_of_every_kind()) {
    if (problem.contact() == nullptr) continue;
    EXPECT_EQ(form(written_and_read(problem)), form(problem)) << problem.name();
  }
}

/// Each is L L' of a matrix of integers with dependent rows, where Cholesky factors with pivoting break down or do not.
TEST_F(ProblemIoTest, AnInverseThatIsExactlySemidefiniteIsRead) {
  for (const char* inverse : {"[[2, 0, 0], [0, 3, -3], [0, -3, 3]]", "[[1, 3, 7], [3, 9, 21], [7, 21, 49]]",
                              "[[5, 1, 4], [1, 2, -1], [4, -1, 5]]", "[[0, 0, 0], [0, 0, 0], [0, 0, 0]]"}) {
    const std::string text = R"({"format": "lcpbench-problem", "version": 1, "name": "x", "kind": "contact",)"
                             R"( "v": [-1, 0, 0], "N": [[1], [0], [0]], "Ginv": )" +
                             std::string(inverse) + "}";
    EXPECT_EQ(parse_problem_json(text, "x.json").contact()->ngc(), 3) << inverse;
  }
}

TEST_F(ProblemIoTest, EveryBitPatternSurvives) {
  using Limits = std::numeric_limits<double>;
  std::mt19937_64 random(20240607);
  for (int trial = 0; trial < 20; ++trial) {
    Lcp lcp{random_matrix(random, 20, 20), random_matrix(random, 20, 1)};
    lcp.q.head(6) << 0.0, -0.0, Limits::denorm_min(), -Limits::denorm_min(), Limits::max(), Limits::lowest();
    const Problem again = written_and_read(Problem("bits", lcp));
    expect_same_bits(again.lcp().M, lcp.M);
    expect_same_bits(again.lcp().q, lcp.q);
  }
}

TEST_F(ProblemIoTest, DecimalsOfOtherProgramsAreReadCorrectlyRounded) {
  const std::string text =
      R"({"format": "lcpbench-problem", "version": 1, "name": "decimals", "kind": "lcp", "M": [)"
      R"([0,0,0,0,0,0,0],[0,0,0,0,0,0,0],[0,0,0,0,0,0,0],[0,0,0,0,0,0,0],[0,0,0,0,0,0,0],[0,0,0,0,0,0,0],[0,0,0,0,0,0,0]],)"
      R"( "q": [-0, 9007199254740993, 18446744073709551617, 1e-999, 2.2250738585072011e-308,)"
      R"( 1.00000000000000011102230246251565404236316680908203125,)"
      R"( 1.00000000000000011102230246251565404236316680908203126]})";
  const Vector expected{
      {-0.0, 9007199254740992.0, 18446744073709551616.0, 0.0, 0x0.fffffffffffffp-1022, 1.0, 0x1.0000000000001p0}};
  expect_same_bits(parse_problem_json(text, "decimals.json").lcp().q, expected);
}

TEST_F(ProblemIoTest, EmptyProblemsAreLegal) {
  expect_round_trip(Problem("no unknowns", Lcp{Matrix(0, 0), Vector(0)}));
  expect_round_trip(Problem("nothing", RigidScene{}));
  ContactProblem problem;
  problem.N = Matrix(0, 0);
  problem.D = Matrix(0, 0);
  problem.inertia = DenseInertia{Matrix(0, 0)};
  expect_round_trip(Problem("no coordinates", problem));

  problem.N = Matrix(0, 2);
  problem.edges = {0, 0};
  problem.mu = Vector::Zero(2);
  expect_round_trip(Problem("contacts without coordinates", problem));
  EXPECT_EQ(written_and_read(Problem("contacts without coordinates", problem)).contact()->nc(), 2);

  ContactProblem free = frictionless_problem();
  free.N = Matrix(3, 0);
  free.edges.clear();
  free.mu.resize(0);
  expect_round_trip(Problem("no contacts", free));
}

TEST_F(ProblemIoTest, TheLayoutIsForPeople) {
  EXPECT_EQ(problem_json(Problem("two \"quoted\"", Lcp{Matrix{{2, 1}, {-0.0, 0.1}}, Vector{{-5, 1e300}}})),
            "{\n"
            "  \"format\": \"lcpbench-problem\",\n"
            "  \"version\": 1,\n"
            "  \"name\": \"two \\\"quoted\\\"\",\n"
            "  \"kind\": \"lcp\",\n"
            "  \"M\": [\n"
            "    [2, 1],\n"
            "    [-0.0, 0.1]\n"
            "  ],\n"
            "  \"q\": [-5, 1e+300]\n"
            "}\n");
}

TEST_F(ProblemIoTest, WhatCouldNotBeReadBackIsNotWritten) {
  const auto error_of_writing = [](const Problem& problem) -> std::string {
    try {
      problem_json(problem);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(error_of_writing(Problem("bad", Lcp{Matrix{{nan}}, Vector{{1}}})),
            "bad: M: entry (0, 0) is nan, expected a finite number");
  EXPECT_EQ(error_of_writing(Problem("bad", Lcp{Matrix{{1}}, Vector{{INFINITY}}})),
            "bad: q[0] is inf, expected a finite number");
  ContactProblem rows = problem_with_rows();
  rows.rows.is_angle.pop_back();
  EXPECT_EQ(error_of_writing(Problem("bad", rows)), "bad: rows.unit: 3 entries, expected 4");
  rows = problem_with_rows();
  rows.rows.bounds.upper(0) = nan;
  EXPECT_EQ(error_of_writing(Problem("bad", rows)), "bad: rows.upper[0] (weld) is nan, expected at least 0");
  rows = problem_with_rows();
  rows.rows.names[1] = "\xff";
  EXPECT_EQ(error_of_writing(Problem("bad", rows)), "bad: rows.names[1]: not UTF-8");
  EXPECT_EQ(error_of_writing(Problem("", Lcp{Matrix{{1}}, Vector{{1}}})), "unnamed problem: name: empty");
  EXPECT_EQ(error_of_writing(Problem("\xff", Lcp{Matrix{{1}}, Vector{{1}}})), "?: name: not UTF-8");
}

TEST_F(ProblemIoTest, TheHashSeesEveryNumberAndShape) {
  const Problem original("p", frictional_problem());
  const std::string hash = problem_hash(original);
  EXPECT_EQ(hash.size(), 32u);
  EXPECT_EQ(hash, problem_hash(Problem("another name", frictional_problem())));

  const auto differs = [&](auto&& change) {
    ContactProblem changed = frictional_problem();
    change(changed);
    return problem_hash(Problem("p", changed)) != hash;
  };
  EXPECT_TRUE(differs([](ContactProblem& p) { p.v(0) = std::nextafter(p.v(0), 1); }));
  EXPECT_TRUE(differs([](ContactProblem& p) { std::get<Matrix>(p.N)(0, 1) = -0.0; }));
  EXPECT_TRUE(differs([](ContactProblem& p) { std::get<Matrix>(p.D)(0, 0) = 2; }));
  EXPECT_TRUE(differs([](ContactProblem& p) { p.mu(1) = 0.25; }));
  EXPECT_TRUE(differs([](ContactProblem& p) { p.edges = {4, 0}; }));
  EXPECT_TRUE(differs([](ContactProblem& p) { std::get<DenseInertia>(p.inertia).G(0, 0) = 5; }));
  EXPECT_TRUE(differs([](ContactProblem& p) { p.inertia = InverseInertia{std::get<DenseInertia>(p.inertia).G}; }));

  const std::string of_mixed = problem_hash(Problem("p", mixed_problem()));
  const auto mixed_differs = [&](auto&& change) {
    Lcp changed = mixed_problem();
    change(changed.bounds);
    return problem_hash(Problem("p", changed)) != of_mixed;
  };
  EXPECT_TRUE(mixed_differs([](LcpBounds& bounds) { bounds = {}; }));
  EXPECT_TRUE(mixed_differs([](LcpBounds& bounds) { bounds.lower(0) = -1; }));
  EXPECT_TRUE(mixed_differs([](LcpBounds& bounds) { bounds.upper(1) = 0.2; }));
  EXPECT_TRUE(mixed_differs([](LcpBounds& bounds) { bounds.friction_of[2] = 1; }));
  EXPECT_TRUE(mixed_differs([](LcpBounds& bounds) { bounds.mu(2) = 0.5; }));

  const std::string of_rows = problem_hash(Problem("p", problem_with_rows()));
  EXPECT_NE(of_rows, hash);
  const auto rows_differ = [&](auto&& change) {
    ContactProblem changed = problem_with_rows();
    change(changed.rows);
    return problem_hash(Problem("p", changed)) != of_rows;
  };
  EXPECT_TRUE(rows_differ([](BoundedRows& rows) { std::get<Matrix>(rows.R)(0, 0) = 2; }));
  EXPECT_TRUE(rows_differ([](BoundedRows& rows) { rows.bounds.lower(1) = -1; }));
  EXPECT_TRUE(rows_differ([](BoundedRows& rows) { rows.bounds.upper(2) = 1; }));
  EXPECT_TRUE(rows_differ([](BoundedRows& rows) { rows.bounds.friction_of[3] = -1; }));
  EXPECT_TRUE(rows_differ([](BoundedRows& rows) { rows.bounds.mu(3) = 0.5; }));
  EXPECT_TRUE(rows_differ([](BoundedRows& rows) { rows.b(0) = 0; }));
  EXPECT_TRUE(rows_differ([](BoundedRows& rows) { rows.compliance.resize(0); }));
  EXPECT_TRUE(rows_differ([](BoundedRows& rows) { std::swap(rows.b, rows.compliance); }));
  EXPECT_TRUE(rows_differ([](BoundedRows& rows) { rows.is_angle[0] = 1; }));
  EXPECT_FALSE(rows_differ([](BoundedRows& rows) { rows.names.clear(); }));
  EXPECT_FALSE(rows_differ([](BoundedRows& rows) { rows.names[0] = "joint"; }));
  EXPECT_FALSE(rows_differ([](BoundedRows& rows) { rows.b(1) = 0; }));

  const Matrix zeros = Matrix::Zero(2, 2);
  EXPECT_NE(problem_hash(Problem("p", Lcp{zeros, Vector::Zero(2)})),
            problem_hash(Problem("p", Lcp{Matrix::Zero(1, 1), Vector::Zero(1)})));
}

TEST_F(ProblemIoTest, TheHashIsTheSameOnEveryMachine) {
  EXPECT_EQ(problem_hash(Problem("lcp", Lcp{Matrix{{2, 1}, {1, 2}}, Vector{{-5, -6}}})),
            "8697c7ded0555d6add8be16b7d3463cc");
  EXPECT_EQ(problem_hash(Problem("scene", scene())), "246b85ab7e9cb572b9172871b069210f");
  EXPECT_EQ(problem_hash(Problem("contact", frictional_problem())), "35c2f2686fc92dfe191539276bc7de39");
  EXPECT_EQ(problem_hash(Problem("rows", problem_with_rows())), "e7acc8f12bdaec48ec85c2d09ae8703e");
}

TEST_F(ProblemIoTest, TheHashDoesNotSeeHowMatricesAreStored) {
  ContactProblem dense = frictional_problem();
  Matrix G = Matrix::Zero(3, 3);
  G.topLeftCorner(2, 2) << 4, 1, 1, 3;
  G(2, 2) = 2;
  dense.inertia = DenseInertia{G};
  ContactProblem sparse = dense;
  sparse.inertia = BlockInertia{{G.topLeftCorner(2, 2), G.bottomRightCorner(1, 1)}};
  sparse.N = SparseMatrix(to_dense(dense.N).sparseView());
  dense.rows = problem_with_rows().rows;
  sparse.rows = dense.rows;
  SparseMatrix R = to_dense(dense.rows.R).sparseView(0, 0);
  R.coeffRef(0, 3) = -0.0;  // which sparseView() leaves out
  sparse.rows.R = R;
  EXPECT_EQ(problem_hash(Problem("p", sparse)), problem_hash(Problem("p", dense)));
  expect_round_trip(Problem("p", sparse));
}

TEST_F(ProblemIoTest, FilesAreWrittenWhole) {
  const fs::path file = folder_ / "two.json";
  const Problem problem("two", Lcp{Matrix{{2, 1}, {1, 2}}, Vector{{-5, -6}}});
  write_problem(problem, file);
  write_problem(problem, file);
  EXPECT_EQ(problem_hash(read_problem(file)), problem_hash(problem));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1) << "a temporary file is left";
  EXPECT_THROW(write_problem(problem, folder_ / "no such folder" / "two.json"), InputError);
}

TEST_F(ProblemIoTest, ASparseFileOfTenGigabytesIsRefusedAtOnce) {
  const fs::path file = write_text("zeros.json", "");
  fs::resize_file(file, std::uintmax_t{10'000'000'000});
  EXPECT_EQ(error_of(file), file.string() + ": 10000000000 bytes, at most 2147483648 are read");
  fs::resize_file(file, std::uintmax_t{2'000'000'000});
  EXPECT_EQ(error_of(file), file.string() + ": has NUL bytes: not a text file");
}

TEST_F(ProblemIoTest, WhatIsNoFileIsNamed) {
  EXPECT_EQ(error_of(folder_), folder_.string() + ": is a folder, expected a problem file");
  EXPECT_EQ(error_of(folder_ / "none.json"), (folder_ / "none.json").string() + ": no such file");
  EXPECT_EQ(error_of("/dev/null"), "/dev/null: is not a regular file");
  EXPECT_EQ(error_of(write_text("empty.json", "")), (folder_ / "empty.json").string() + ": empty file");
  for (const char* name : {"word.txt", "arrays.npz", "arrays.mat"}) {
    EXPECT_EQ(error_of(write_text(name, name[0] == 'w' ? "hello" : std::string("PK\3\4\0", 5))),
              (folder_ / name).string() +
                  ": no format that is read: a problem in JSON ('{' first), Siconos' text of an LCP or MLCP (a number "
                  "first), NAME.M.mtx with NAME.q.mtx, NAME.scenes#STEP; numpy's .npz and .mat are read by lcpbench.load "
                  "in Python");
  }
}

TEST_F(ProblemIoTest, JsonIsKnownByItsFirstByteToo) {
  const std::string text = problem_json(Problem("two", Lcp{Matrix{{2, 1}, {1, 2}}, Vector{{-5, -6}}}));
  EXPECT_EQ(read_problem(write_text("problem", "\n " + text)).name(), "two");
  EXPECT_EQ(read_problem(write_text("with-mark", "\xEF\xBB\xBF" + text)).name(), "two");
}

}  // namespace
}  // namespace lcpbench::problem_io_test
