// Mixed and boxed LCPs: what a solver that knows z >= 0 alone makes of them by way of the reduction, against the exact
// enumeration of every row's state, and against the states of the diodes of bridge rectifiers.

#include "core/answer/lcp_error.h"
#include "core/mixed_lcp.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "core/registry.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench::mixed_lcp_test {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

enum class State { kLower, kUpper, kBetween };

/// The data are small integers, so that what is no solution misses by more, and rounding by less.
constexpr double kTolerance = 1e-10;

bool is_solution(const Lcp& lcp, const std::vector<State>& states, const Vector& z) {
  const Vector w = lcp.M * z + lcp.q;
  for (Index i = 0; i < z.size(); ++i) {
    const int of = lcp.bounds.friction_of[static_cast<std::size_t>(i)];
    const double limit = of >= 0 ? lcp.bounds.mu(i) * z(of) : 0;
    const double lower = of >= 0 ? -limit : lcp.bounds.lower(i), upper = of >= 0 ? limit : lcp.bounds.upper(i);
    if (z(i) < lower - kTolerance || z(i) > upper + kTolerance) return false;
    if (upper - lower <= kTolerance) continue;  // both bounds are one: w is anything
    const State state = states[static_cast<std::size_t>(i)];
    if ((state == State::kLower && w(i) < -kTolerance) || (state == State::kUpper && w(i) > kTolerance)) return false;
  }
  return true;
}

/// Every isolated solution, with a flag where some combination of states has a singular system: then there may be more.
struct Solutions {
  std::vector<Vector> all;
  bool complete = true;
};

Solutions enumerated(const Lcp& lcp) {
  Solutions found;
  std::vector<State> states(static_cast<std::size_t>(lcp.size()));
  int combinations = 1;
  for (Index i = 0; i < lcp.size(); ++i) combinations *= 3;
  for (int number = 0; number < combinations; ++number) {
    Matrix A = lcp.M;
    Vector c = -lcp.q;
    int rest = number;
    for (Index i = 0; i < lcp.size(); ++i, rest /= 3) {
      const State state = states[static_cast<std::size_t>(i)] = static_cast<State>(rest % 3);
      if (state == State::kBetween) continue;
      const int of = lcp.bounds.friction_of[static_cast<std::size_t>(i)];
      A.row(i) = Vector::Unit(lcp.size(), i).transpose();
      if (of >= 0) A(i, of) = state == State::kLower ? lcp.bounds.mu(i) : -lcp.bounds.mu(i);
      c(i) = of >= 0 ? 0 : state == State::kLower ? lcp.bounds.lower(i) : lcp.bounds.upper(i);
    }
    if (!c.allFinite()) continue;  // a row at a bound that it does not have
    const Eigen::FullPivLU<Matrix> factors(A);
    found.complete = found.complete && factors.isInvertible();
    const Vector z = factors.solve(c);
    if (factors.isInvertible() && is_solution(lcp, states, z)) found.all.push_back(z);
  }
  return found;
}

enum class Kind { kDefinite, kFriction, kAny };

Lcp drawn(Kind kind, std::mt19937_64& random) {
  const auto integer = [&](int low, int high) {
    return low + static_cast<int>(random() % static_cast<std::uint64_t>(high - low + 1));
  };
  const Index n = integer(2, 5);
  Lcp lcp{Matrix::Zero(n, n), Vector::Zero(n), LcpBounds::nonnegative(n)};
  for (double& entry : lcp.M.reshaped()) entry = integer(-3, 3);
  if (kind != Kind::kAny) {
    const Matrix turn = kind == Kind::kFriction ? Matrix(Matrix::Zero(n, n)) : Matrix(lcp.M - lcp.M.transpose());
    lcp.M = Matrix(lcp.M * lcp.M.transpose() + Matrix::Identity(n, n) + turn);
  }
  for (double& entry : lcp.q) entry = integer(-9, 9);
  for (Index i = 0; i < n; ++i) {
    const int what = integer(0, 4);
    if (what == 0) lcp.bounds.lower(i) = -kNone;  // free
    if (what == 1) lcp.bounds.lower(i) = integer(-3, 3);
    if (what == 2) {
      lcp.bounds.lower(i) = -kNone;
      lcp.bounds.upper(i) = integer(-3, 3);
    }
    if (what >= 3) {
      lcp.bounds.lower(i) = integer(-3, 2);
      lcp.bounds.upper(i) = lcp.bounds.lower(i) + integer(0, 3);
    }
  }
  if (kind == Kind::kFriction) {
    lcp.bounds.lower(0) = 0;
    lcp.bounds.upper(0) = kNone;
    for (Index i = 1; i < std::min<Index>(n, 3); ++i) {
      lcp.bounds.lower(i) = -kNone;
      lcp.bounds.upper(i) = kNone;
      lcp.bounds.friction_of[static_cast<std::size_t>(i)] = 0;
      lcp.bounds.mu(i) = 0.5 * integer(0, 3);
    }
  }
  return lcp;
}

struct Solved {
  Answer answer;
  Errors errors;
};

Solved solved(const Problem& problem, const char* spec = "auto") {
  Solved result;
  const std::unique_ptr<Solver> solver = make_solver(parse_spec(spec));
  solver->load(problem);
  solver->solve({.time_limit_s = 5}, result.answer);
  result.errors = Evaluator(problem).errors(result.answer);
  return result;
}

/// Relative to the larger of 1 and the numbers themselves.
double distance(const Vector& a, const Vector& b) {
  return (a - b).cwiseAbs().maxCoeff() / std::max(1.0, b.cwiseAbs().maxCoeff());
}

// The seed, 75, was named before the first run.
TEST(MixedLcpTest, TwoHundredAgreeWithTheEnumerationOfAllStates) {
  std::mt19937_64 random(75);
  int with_solution = 0;
  for (int number = 0; number < 200;) {
    const Kind kind = static_cast<Kind>(number % 3);
    const Lcp lcp = drawn(kind, random);
    const Solutions expected = enumerated(lcp);
    // A singular system may hide a continuum; with definite M there is none, and whatever is found is all.
    if (!expected.complete && kind == Kind::kAny) continue;
    SCOPED_TRACE("problem " + std::to_string(number));
    const Problem problem("drawn", lcp);
    if (kind == Kind::kDefinite) {
      EXPECT_EQ(Evaluator(problem).truth() == Truth::kSolvable, true);
    }
    for (const char* spec : {"auto", "lemke", "principal_pivoting"}) {
      const Solved result = solved(problem, spec);
      const bool claims = result.answer.claim == Claim::kSolved;
      const bool must = spec == std::string("auto") && (kind != Kind::kAny || !expected.all.empty());
      EXPECT_TRUE(claims || !must) << spec << ": " << to_string(result.answer.claim) << ", " << result.answer.detail
                                   << "\nM\n"
                                   << lcp.M << "\nq " << lcp.q.transpose() << "\nlower " << lcp.bounds.lower.transpose()
                                   << "\nupper " << lcp.bounds.upper.transpose();
      EXPECT_FALSE(result.answer.claim == Claim::kUnsolvable && !expected.all.empty()) << spec;
      if (!claims) continue;
      EXPECT_TRUE(result.errors.solved) << spec << ": " << result.errors.backward_row_norm;
      double nearest = kNone;
      for (const Vector& z : expected.all) nearest = std::min(nearest, distance(result.answer.z, z));
      if (kind != Kind::kFriction || expected.complete) {
        EXPECT_LT(nearest, 1e-9) << spec << ": " << result.answer.z.transpose();
      }
    }
    with_solution += expected.all.empty() ? 0 : 1;
    ++number;
  }
  EXPECT_GT(with_solution, 150);
}

TEST(MixedLcpTest, TheMeasureIsThatOfTheBounds) {
  Lcp lcp{Matrix::Identity(2, 2), Vector{{-1, 3}}, LcpBounds::nonnegative(2)};
  lcp.bounds.lower(1) = -kNone;
  lcp.bounds.friction_of = {-1, 0};
  lcp.bounds.mu = Vector{{0, 0.5}};
  const auto backward = [&](double normal, double friction) {
    return lcp_error(lcp, std::vector<double>{normal, friction}).backward;
  };
  EXPECT_EQ(backward(1, -0.5), 0);
  EXPECT_DOUBLE_EQ(backward(1, 0.5), 1 / 3.5);        // at the wrong bound: friction pushes on; w = 3.5, z - lower = 1
  EXPECT_DOUBLE_EQ(backward(1, -0.75), 0.25 / 3.75);  // beyond its bound
  EXPECT_DOUBLE_EQ(backward(1, 0), 0.5 / 3);          // not at its bound
  EXPECT_DOUBLE_EQ(backward(0, 0), 1);                // the normal row approaches
  EXPECT_EQ(backward(std::nan(""), 0), kNone);
  EXPECT_EQ(lcp_error(lcp, std::vector<double>{1, 0.5}).row, 1);
  EXPECT_EQ(solved({"box friction", lcp}).answer.z, (Vector{{1, -0.5}}));
}

/// `count` bridge rectifiers of four diodes in a chain: three free unknowns each, and their equations first. In the
/// order of Siconos' diode bridge, equations and unknowns do not belong together.
Lcp coupled_bridges(Index count) {
  const Index free = 3 * count;
  Lcp lcp{Matrix::Zero(7 * count, 7 * count), Vector::Zero(7 * count), LcpBounds::nonnegative(7 * count)};
  lcp.bounds.lower.head(free).setConstant(-kNone);
  for (Index b = 0; b < count; ++b) {
    const Index v = 3 * b;
    const Index d = free + 4 * b;
    const bool last = b + 1 == count;
    lcp.M(v, v + 1) = last ? -0.002 : -0.001;
    lcp.M(v, v + 2) = 0.002;
    if (!last) lcp.M(v, v + 4) = -0.001;
    lcp.M(v, d + 1) = lcp.M(v, d + 3) = 1;
    lcp.M(v + 1, v + 1) = 0.002;
    lcp.M(v + 1, v + 2) = -0.002;
    lcp.M(v + 1, d) = lcp.M(v + 1, d + 2) = -1;
    lcp.M(v + 2, v) = -1.005;
    lcp.M(v + 2, d + 2) = 20;
    lcp.M(v + 2, d + 3) = -20;
    lcp.q(v + 2) = 0.995 - 1.1 * static_cast<double>(b) * 1.9;
    lcp.M(d, v + 2) = -1;
    lcp.M(d + 1, v + 1) = 1;
    lcp.M(d + 2, v) = 1;
    lcp.M(d + 2, v + 2) = -1;
    lcp.M(d + 3, v) = -1;
    lcp.M(d + 3, v + 1) = 1;
  }
  return lcp;
}

/// Every free unknown as the difference of two, as who has only z >= 0 writes it.
Lcp split(const Lcp& mixed, Index free) {
  const Index others = mixed.size() - free;
  Lcp lcp{Matrix(mixed.size() + free, mixed.size() + free), Vector(mixed.size() + free)};
  Matrix to = Matrix::Zero(mixed.size(), mixed.size() + free);
  to.topLeftCorner(free, free).setIdentity();
  to.block(0, free, free, free) = -Matrix::Identity(free, free);
  to.bottomRightCorner(others, others).setIdentity();
  lcp.M = to.transpose() * mixed.M * to;
  lcp.q = to.transpose() * mixed.q;
  return lcp;
}

/// The only state of the diodes with currents and voltages >= 0, by trying all.
Vector by_states(const Lcp& lcp, Index free) {
  const Index diodes = lcp.size() - free;
  std::vector<Vector> found;
  for (Index state = 0; state < Index{1} << diodes; ++state) {
    Matrix A = lcp.M;
    Vector c = -lcp.q;
    for (Index d = 0; d < diodes; ++d) {
      if ((state >> d & 1) != 0) continue;  // conducts: its row is w = 0
      A.row(free + d) = Vector::Unit(lcp.size(), free + d).transpose();
      c(free + d) = 0;
    }
    const Eigen::FullPivLU<Matrix> factors(A);
    if (!factors.isInvertible()) continue;
    const Vector z = factors.solve(c);
    const Vector w = lcp.M * z + lcp.q;
    if (z.tail(diodes).minCoeff() < -1e-12 || w.tail(diodes).minCoeff() < -1e-12) continue;
    bool is_new = true;
    for (const Vector& other : found) is_new = is_new && (other - z).cwiseAbs().maxCoeff() > 1e-9;
    if (is_new) found.push_back(z);
  }
  EXPECT_EQ(found.size(), 1u);
  return found.empty() ? Vector() : found.front();
}

TEST(MixedLcpTest, CoupledDiodeBridgesAreSolvedInEveryForm) {
  for (const Index count : {2, 3}) {
    SCOPED_TRACE(count);
    const Lcp mixed = coupled_bridges(count);
    const Index free = 3 * count;
    const Vector state = by_states(mixed, free);
    ASSERT_EQ(state.size(), mixed.size());
    const Solved as_mixed = solved({"mixed", mixed});
    EXPECT_EQ(as_mixed.answer.claim, Claim::kSolved) << as_mixed.answer.detail;
    EXPECT_TRUE(as_mixed.errors.solved);
    EXPECT_LT(distance(as_mixed.answer.z, state), 1e-9);
    // Equations paired with unknowns in another order: the first row of each bridge last.
    Lcp reordered = mixed;
    for (Index b = 0; b < count; ++b) {
      for (Index k = 0; k < 3; ++k) {
        reordered.M.row(3 * b + k) = mixed.M.row(3 * b + (k + 2) % 3);
        reordered.q(3 * b + k) = mixed.q(3 * b + (k + 2) % 3);
      }
    }
    EXPECT_LT(distance(solved({"reordered", reordered}).answer.z, state), 1e-9);
    for (const Lcp& each : {mixed, reordered}) {
      const Solved as_bare = solved({"split", split(each, free)});
      EXPECT_EQ(as_bare.answer.claim, Claim::kSolved) << as_bare.answer.detail;
      EXPECT_TRUE(as_bare.errors.solved);
      Vector z = as_bare.answer.z.tail(mixed.size());
      z.head(free) = as_bare.answer.z.head(free) - as_bare.answer.z.segment(free, free);
      EXPECT_LT(distance(z, state), 1e-9);
    }
  }
}

TEST(MixedLcpTest, UnsolvableIsSaidOnlyWhereNothingWasRounded) {
  // z_0 free, w_0 = z_0 + 1, w_1 = -1 whatever z is.
  Lcp lcp{Matrix{{1, 0}, {0, 0}}, Vector{{1, -1}}, LcpBounds::nonnegative(2)};
  lcp.bounds.lower(0) = -kNone;
  EXPECT_EQ(solved({"free", lcp}).answer.claim, Claim::kNumericalFailure);
  lcp.bounds.lower(0) = 0;
  lcp.bounds.upper(0) = 3;
  EXPECT_EQ(solved({"boxed", lcp}).answer.claim, Claim::kUnsolvable);
  EXPECT_EQ(solved({"boxed", lcp}).answer.farkas.size(), 0);  // it would be one of the reduced problem
}

/// Row 0 holds what row 1 presses: friction by mu, row 1 from `lower` to `upper`.
Lcp with_friction(const Matrix& M, const Vector& q, double mu, double lower, double upper) {
  Lcp lcp{M, q, LcpBounds::nonnegative(2)};
  lcp.bounds.lower = Vector{{-kNone, lower}};
  lcp.bounds.upper = Vector{{kNone, upper}};
  lcp.bounds.friction_of[0] = 1;
  lcp.bounds.mu(0) = mu;
  return lcp;
}

TEST(MixedLcpTest, WhatNativeSolversClaimIsTrueOfTheMixedProblem) {
  const Problem problems[] = {
      // Products of these numbers are no doubles.
      {"tiny", with_friction(1e-90 * Matrix{{3, -1}, {-1, 4}}, 1e-90 * Vector{{-2, 0}}, 0, 0, 1e-300)},
      {"tinier", with_friction(1e-200 * Matrix{{3, -1}, {-1, 4}}, 1e-200 * Vector{{-2, -3}}, 0.5, 0, 1e-150)},
      // The limit's last digit is larger than anything in its row.
      {"far limit", with_friction(Matrix{{0, 0}, {0, 1}}, Vector{{3, -1}}, 49152.1, 5e8 / 3, kNone)},
      {"far free", with_friction(Matrix{{0x1p-60, 0}, {0, 1}}, Vector{{-3, -1e9}}, 1.1e9, 0, kNone)}};
  for (const Problem& problem : problems) {
    for (const RegisteredSolver& solver : registered_solvers()) {
      if (!solver.native()) continue;
      const Solved result = solved(problem, solver.definition.name.c_str());
      if (result.answer.claim != Claim::kSolved) continue;
      EXPECT_TRUE(result.errors.solved) << solver.definition.name << ", " << problem.name();
    }
  }
}

TEST(MixedLcpTest, APartOfTheRowsKeepsItsBounds) {
  LcpBounds bounds = LcpBounds::nonnegative(3);
  bounds.friction_of = {-1, 0, 0};
  bounds.lower.tail(2).setConstant(-kNone);
  bounds.mu = Vector{{0, 1, 2}};
  const LcpBounds turned = bounds.of_rows({2, 0});
  EXPECT_EQ(turned.friction_of, (std::vector<int>{1, -1}));
  EXPECT_EQ(turned.mu(0), 2);
  const LcpBounds alone = bounds.of_rows({1});
  EXPECT_EQ(alone.friction_of, std::vector<int>{-1});
  EXPECT_EQ(alone.lower(0), 0);
  EXPECT_EQ(alone.upper(0), 0);
}

}  // namespace
}  // namespace lcpbench::mixed_lcp_test
