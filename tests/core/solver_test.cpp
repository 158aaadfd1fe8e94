#include "core/solver.h"

#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <thread>
#include <utility>

#include <gtest/gtest.h>

#include "core/timed_solve.h"

namespace lcpbench::solver_test {
namespace {

// Answers z = q so that tests can see which data reached it; counts its calls.
class Echo final : public Solver {
 public:
  explicit Echo(Capabilities capabilities = {}) : capabilities_(capabilities) {}
  const Capabilities& capabilities() const override { return capabilities_; }
  int loads = 0;
  int solves = 0;

 protected:
  void on_load(const Problem& problem) override {
    ++loads;
    q_ = make_lcp(problem).q;
  }
  void on_solve(const SolveRequest&, Answer& answer) override {
    ++solves;
    answer.z = q_;
    answer.claim = Claim::kSolved;
  }

 private:
  Capabilities capabilities_;
  Vector q_;
};

class Throws final : public Solver {
 public:
  const Capabilities& capabilities() const override { return capabilities_; }

 protected:
  void on_load(const Problem&) override { throw std::runtime_error("out of ideas"); }
  void on_solve(const SolveRequest&, Answer&) override {}

 private:
  Capabilities capabilities_;
};

/// Finds out at the solve only that it cannot, and leaves what it has.
class RefusesLate final : public Solver {
 public:
  const Capabilities& capabilities() const override { return capabilities_; }

 protected:
  void on_load(const Problem&) override {}
  void on_solve(const SolveRequest&, Answer& answer) override {
    answer.claim = Claim::kUnsupported;
    answer.velocity = Vector::Zero(2);
    answer.farkas = Vector::Zero(4);
    answer.detail = "not this one";
  }

 private:
  Capabilities capabilities_;
};

Problem frictional_particle() {
  ContactProblem contact;
  contact.v = Vector{{1.0, -1.0}};
  contact.N = Matrix{{0.0}, {1.0}};
  contact.D = Matrix{{1.0, -1.0}, {0.0, 0.0}};
  contact.edges = {2};
  contact.mu = Vector{{0.5}};
  contact.inertia = DenseInertia{Matrix::Identity(2, 2)};
  return Problem("particle", contact);
}

/// Claims that a given z solves.
class Claims final : public Solver {
 public:
  explicit Claims(Vector z, const Capabilities& capabilities = {}) : capabilities_(capabilities), z_(std::move(z)) {}
  const Capabilities& capabilities() const override { return capabilities_; }

 protected:
  void on_load(const Problem&) override {}
  void on_update(const Vector&) override {}
  void on_solve(const SolveRequest&, Answer& answer) override {
    answer.z = z_;
    answer.claim = Claim::kSolved;
  }

 private:
  Capabilities capabilities_;
  Vector z_;
};

/// The rigid equivalent has the speed of a belt among its velocities, a millionth of which is more than a contact
/// approaches by: its answers need not be those of the problem. A claim that is false by itself stays the solver's own.
TEST(SolverTest, WhatSolvesTheRigidEquivalentAloneIsNotClaimed) {
  ContactProblem belt = *frictional_particle().contact();
  belt.offset_t = Vector{{0.8, 0}};
  const auto claim = [&](double speed, const Vector& z) {
    Claims solver(z);
    belt.v = Vector{{0, -1}};
    solver.load(Problem("belt", belt));
    solver.update(Vector{{0, -speed}});
    Answer answer;
    solver.solve({}, answer);
    return answer.claim;
  };
  const Vector none{{0, 0, 0, 0.8}};
  EXPECT_EQ(claim(5e-11, none), Claim::kNumericalFailure);
  EXPECT_EQ(claim(5e-11, Vector{{5e-11, 0, 2.5e-11, 0.8 - 2.5e-11}}), Claim::kSolved);
  EXPECT_EQ(claim(-5e-11, none), Claim::kSolved);
  EXPECT_EQ(claim(5e-11, Vector{{1, 0, 0, 0.8}}), Claim::kSolved) << "false by itself";
}

TEST(SolverTest, RefusedProblemsAreAnsweredUnsupportedWithTheReason) {
  Answer answer;
  Echo scenes({.needs = Needs::kScene});
  scenes.load(frictional_particle());
  scenes.solve({}, answer);
  EXPECT_EQ(answer.claim, Claim::kUnsupported);
  EXPECT_EQ(answer.detail, "needs a rigid-body scene");
  EXPECT_EQ(answer.z.size(), 0);
  EXPECT_EQ(scenes.solves, 0);

  Echo small({.max_size = 3});
  small.load(frictional_particle());
  small.solve({}, answer);
  EXPECT_EQ(answer.detail, "n = 4 is over its limit of 3");
  // Two coordinates times three normals, coordinates and half of the directions.
  for (const Index entries : {7, 8}) {
    Echo few_coordinates({.max_size = 3, .max_entries = entries, .compliance = true});
    ContactProblem contact = *frictional_particle().contact();
    few_coordinates.load(Problem("hard", contact));
    few_coordinates.solve({}, answer);
    EXPECT_EQ(few_coordinates.solves, entries - 7);
    contact.compliance_n = Vector::Ones(1);
    few_coordinates.load(Problem("soft", contact));
    few_coordinates.solve({}, answer);
    EXPECT_EQ(answer.claim, Claim::kUnsupported) << "what yields adds coordinates";
  }

  Echo symmetric({.frictionless_only = true});
  symmetric.load(frictional_particle());
  symmetric.solve({}, answer);
  EXPECT_EQ(answer.claim, Claim::kUnsupported);
  EXPECT_EQ(answer.detail, "needs a symmetric M: frictionless contacts only");

  Echo round({.frictionless_only = true, .friction_setting = "cone=true"});
  round.load(frictional_particle());
  round.solve({}, answer);
  EXPECT_EQ(answer.claim, Claim::kUnsupported);
  EXPECT_EQ(answer.detail,
            "has a round friction cone, which is another problem than this pyramid: cone=true solves that one");
}

TEST(SolverTest, WithoutAProblemTheAnswerIsUnsupported) {
  Echo echo;
  Answer answer;
  answer.z = Vector::Ones(2);
  echo.solve({}, answer);
  EXPECT_EQ(answer.claim, Claim::kUnsupported);
  EXPECT_EQ(answer.detail, "nothing was loaded");
  EXPECT_EQ(answer.z.size(), 0);
}

// Zeros are right for bodies that separate: an answer that nobody gave would be verified.
TEST(SolverTest, RefusalsAtTheSolveHoldNoAnswer) {
  RefusesLate solver;
  Answer answer;
  solver.load(frictional_particle());
  solver.solve({}, answer);
  EXPECT_EQ(answer.claim, Claim::kUnsupported);
  EXPECT_EQ(answer.detail, "not this one");
  EXPECT_EQ(answer.z.size(), 0);
  EXPECT_EQ(answer.velocity.size(), 0);
  EXPECT_EQ(answer.farkas.size(), 0);
}

struct BoundedRow {
  double R = 1, b = 0, compliance = 0, mu = 0;
};

ContactProblem particle_with(const BoundedRow& row) {
  ContactProblem problem = *frictional_particle().contact();
  problem.rows.R = Matrix::Constant(problem.ngc(), 1, row.R);
  problem.rows.bounds = LcpBounds::nonnegative(1);
  problem.rows.bounds.mu(0) = row.mu;
  problem.rows.b = Vector::Constant(1, row.b);
  problem.rows.compliance = Vector::Constant(1, row.compliance);
  problem.rows.is_angle = {0};
  return problem;
}

TEST(SolverTest, NaNAndInfinityAreRefused) {
  Echo echo;
  Answer answer;
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    echo.load(Problem("bad", Lcp{Matrix::Constant(1, 1, bad), Vector::Ones(1)}));
    echo.solve({}, answer);
    EXPECT_EQ(answer.claim, Claim::kUnsupported);
    EXPECT_EQ(answer.detail, "the data hold NaN or infinity");
    for (double BoundedRow::* field : {&BoundedRow::R, &BoundedRow::b, &BoundedRow::compliance, &BoundedRow::mu}) {
      BoundedRow row;
      row.*field = bad;
      echo.load(Problem("bad", particle_with(row)));
      echo.solve({}, answer);
      EXPECT_EQ(answer.detail, "the data hold NaN or infinity");
    }
  }
}

/// One coordinate of inertia 1 that moves at -1 m/s, and a row along it with this lower bound and no upper one: f = 1.
Problem stopped_by_a_row(double lower) {
  ContactProblem problem;
  problem.v = Vector{{-1.0}};
  problem.N = problem.D = Matrix(1, 0);
  problem.inertia = DenseInertia{Matrix::Identity(1, 1)};
  problem.rows.R = Matrix::Identity(1, 1);
  problem.rows.bounds = LcpBounds::nonnegative(1);
  problem.rows.bounds.lower(0) = lower;
  problem.rows.is_angle = {0};
  return Problem("row", problem);
}

/// The contact in the place of a row with the lower bound -4 begins from -5 m/s, which is its scale; that of the row is
/// 1 m/s.
TEST(SolverTest, WhatSolvesTheContactsInThePlaceOfRowsAloneIsNotClaimed) {
  const auto claim = [](double impulse_of_contact) {
    Claims solver(Vector{{impulse_of_contact}}, {.needs = Needs::kFactored, .compliance = true});
    solver.load(stopped_by_a_row(-4));
    Answer answer;
    solver.solve({}, answer);
    return answer.claim;
  };
  EXPECT_EQ(claim(5), Claim::kSolved);
  EXPECT_EQ(claim(5 + 4e-4), Claim::kNumericalFailure);
  EXPECT_EQ(claim(5.01), Claim::kSolved) << "false by itself";
}

TEST(SolverTest, AFalseClaimOnTheMixedLcpOfRowsStaysTheSolversOwn) {
  Claims solver(Vector{{0.5}}, {.boxed = true});
  solver.load(stopped_by_a_row(0));
  Answer answer;
  solver.solve({}, answer);
  EXPECT_EQ(answer.claim, Claim::kSolved);
}

TEST(SolverTest, UpdateReplacesTheVelocityOnly) {
  Echo echo;
  Answer answer;
  echo.load(frictional_particle());
  echo.update(Vector{{0.25, -2.0}});
  echo.solve({}, answer);
  EXPECT_EQ(answer.z, (Vector{{-2.0, 0.25, -0.25, 0.0}}));
  EXPECT_THROW(echo.update(Vector::Zero(3)), std::invalid_argument);
}

TEST(TimedSolveTest, RepeatsShortSolvesAndReportsTheMedianOfThreeMeans) {
  Echo echo;
  TimedAnswer timed;
  timed_solve(echo, frictional_particle(), {.repeat_until_s = 10.0, .max_repeats = 6}, timed);
  EXPECT_EQ(timed.times.repeats, 6);
  EXPECT_EQ(echo.solves, 7);
  EXPECT_GT(timed.times.setup_wall_s, 0);
  EXPECT_EQ(timed.answer.claim, Claim::kSolved);
}

// Works hard in the first solve after a load only, as one that keeps a fallback it has found.
class Remembers final : public Solver {
 public:
  const Capabilities& capabilities() const override { return capabilities_; }

 protected:
  void on_load(const Problem&) override { known_ = false; }
  void on_solve(const SolveRequest&, Answer&) override {
    ++(known_ ? easy_solves : hard_solves);
    known_ = true;
  }

 public:
  int hard_solves = 0;
  int easy_solves = 0;

 private:
  Capabilities capabilities_;
  bool known_ = false;
};

TEST(TimedSolveTest, NoSolveGainsFromTheOneBefore) {
  Remembers remembers;
  TimedAnswer timed;
  timed_solve(remembers, frictional_particle(), {.repeat_until_s = 10.0, .max_repeats = 6}, timed);
  EXPECT_EQ(timed.times.repeats, 6);
  EXPECT_EQ(remembers.hard_solves, 7);
  EXPECT_EQ(remembers.easy_solves, 0);
}

/// The first solve of a process fetches what later ones find in caches: here 60 times as slow.
class ColdAtFirst final : public Solver {
 public:
  const Capabilities& capabilities() const override { return capabilities_; }

 protected:
  void on_load(const Problem&) override {}
  void on_solve(const SolveRequest&, Answer& answer) override {
    const double until_s = thread_cpu_clock_s() + (first_ ? 3e-3 : 5e-5);
    first_ = false;
    while (thread_cpu_clock_s() < until_s) continue;
    answer.claim = Claim::kSolved;
  }

 private:
  Capabilities capabilities_;
  bool first_ = true;
};

TEST(TimedSolveTest, AColdFirstSolveIsNotTheTime) {
  constexpr double kOfTheFirst = 1e-3;
  for (const double repeat_until_s : {1e-3, 4e-4}) {
    ColdAtFirst solver;
    TimedAnswer timed;
    timed_solve(solver, frictional_particle(), {.repeat_until_s = repeat_until_s}, timed);
    EXPECT_LT(timed.times.solve_cpu_s, kOfTheFirst);
    EXPECT_GT(timed.times.solve_cpu_s, 0);
  }
}

TEST(TimedSolveTest, AnExceptionBecomesARowNotACrash) {
  TimedAnswer timed;
  in_process(std::make_unique<Throws>())->run(frictional_particle(), {}, timed);
  EXPECT_EQ(timed.answer.claim, Claim::kNumericalFailure);
  EXPECT_EQ(timed.answer.detail, "out of ideas");
}

TEST(ClaimTest, WordsReadBack) {
  for (const Claim claim : {Claim::kSolved, Claim::kUnsolvable, Claim::kIterationLimit, Claim::kTimeLimit,
                            Claim::kNumericalFailure, Claim::kUnsupported, Claim::kCrashed}) {
    EXPECT_EQ(parse_claim(to_string(claim)), claim);
  }
}

}  // namespace
}  // namespace lcpbench::solver_test
