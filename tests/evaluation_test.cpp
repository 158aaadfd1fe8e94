#include "study/evaluation/evaluation.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/scene.h"
#include "study/evaluation/backward_error.h"

namespace lcpbench {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// splitmix64, so that the tests draw the same numbers everywhere.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits() {
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t x = state_;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }
  double uniform() { return static_cast<double>(bits() >> 52) * 0x1p-11 - 1.0; }  // multiples of 2^-11 in [-1, 1)
  Matrix matrix(Index rows, Index cols) {
    Matrix A(rows, cols);
    for (Index j = 0; j < cols; ++j) {
      for (Index i = 0; i < rows; ++i) A(i, j) = uniform();
    }
    return A;
  }
  Vector vector(Index size) { return matrix(size, 1); }

 private:
  std::uint64_t state_;
};

Vector vec(std::initializer_list<double> values) {
  Vector x(static_cast<Index>(values.size()));
  std::copy(values.begin(), values.end(), x.begin());
  return x;
}

Answer answer(Vector z, Claim claim = Claim::kSolved) {
  Answer result;
  result.claim = claim;
  result.z = std::move(z);
  return result;
}

Errors evaluate(const Problem& problem, const Vector& z) { return Evaluator(problem).errors(answer(z)); }

ContactProblem frictionless(Vector v, Matrix N, Inertia inertia) {
  ContactProblem problem;
  problem.v = std::move(v);
  problem.edges.assign(static_cast<std::size_t>(N.cols()), 0);
  problem.mu = Vector::Zero(N.cols());
  problem.D = Matrix(N.rows(), 0);
  problem.N = std::move(N);
  problem.inertia = std::move(inertia);
  return problem;
}

// A particle of mass 1 in the plane that meets the ground y = 0, friction along x.
// z = [f_n; f_+, f_-; lambda], w = [v+_y; lambda + v+_x, lambda - v+_x; mu f_n - f_+ - f_-].
Problem particle(double vx, double vy, double mu) {
  ContactProblem problem;
  problem.v = vec({vx, vy});
  problem.N = Matrix(vec({0, 1}));
  Matrix D(2, 2);
  D << 1, -1, 0, 0;
  problem.D = D;
  problem.edges = {2};
  problem.mu = vec({mu});
  problem.inertia = DenseInertia{Matrix::Identity(2, 2)};
  return Problem("particle", problem);
}

Problem sliding_particle() { return particle(2, -1, 0.5); }
Vector sliding_answer() { return vec({1, 0, 0.5, 1.5}); }

// A flat square plate of mass 1 that lands on its four corners while it slides along x.
RigidScene plate(int copies = 1) {
  RigidScene scene;
  for (int b = 0; b < copies; ++b) {
    RigidBody body;
    body.linear_velocity = {2, 0, -1};
    body.position = {4.0 * b, 0, 0};
    scene.bodies.push_back(body);
    for (const double x : {-1.0, 1.0}) {
      for (const double y : {-1.0, 1.0}) {
        RigidContact contact;
        contact.body_a = b;
        contact.point = body.position + Eigen::Vector3d(x, y, 0);
        contact.mu = 0.5;
        contact.edges = 4;
        scene.contacts.push_back(contact);
      }
    }
  }
  return scene;
}

// Each corner takes a quarter of the impulse and half of that as friction against the sliding, which goes on at 1.5
// m/s.
Vector plate_answer(int copies = 1) {
  const Index contacts = 4 * copies;
  Vector z = Vector::Zero(6 * contacts);
  for (Index c = 0; c < contacts; ++c) {
    z(c) = 0.25;
    z(contacts + 4 * c + 2) = 0.125;
    z(5 * contacts + c) = 1.5;
  }
  return z;
}

void expect_exact(const Errors& errors) {
  EXPECT_TRUE(errors.usable);
  EXPECT_TRUE(errors.solved);
  EXPECT_EQ(errors.velocity_residual_m_per_s, 0);
  EXPECT_EQ(errors.velocity_residual_relative, 0);
  EXPECT_EQ(errors.natural_residual, 0);
  EXPECT_EQ(errors.backward_componentwise, 0);
  EXPECT_EQ(errors.backward_row_norm, 0);
  EXPECT_EQ(errors.violation_m_per_s, 0);
  EXPECT_EQ(errors.complementarity_j, 0);
  EXPECT_EQ(errors.cone_violation, 0);
}

void expect_no_measure(const Errors& errors) {
  EXPECT_FALSE(errors.usable);
  EXPECT_FALSE(errors.solved);
  EXPECT_FALSE(errors.criterion);
  for (const double measure :
       {errors.velocity_residual_m_per_s, errors.velocity_residual_relative, errors.natural_residual,
        errors.backward_componentwise, errors.backward_row_norm, errors.forward_velocity, errors.violation_m_per_s,
        errors.work_gain_j, errors.complementarity_j, errors.cone_violation, errors.min_z, errors.velocity_mismatch}) {
    EXPECT_TRUE(std::isnan(measure));
  }
}

TEST(EvaluationTest, ExactAnswersHaveNoError) {
  expect_exact(evaluate(sliding_particle(), sliding_answer()));
  expect_exact(evaluate(particle(0.25, -1, 0.5), vec({1, 0, 0.25, 0})));       // sticks
  expect_exact(evaluate(particle(0.25, -1, 0.5), vec({1, 0.125, 0.375, 0})));  // the same velocity, another z
  expect_exact(evaluate(particle(3, -4, 0.75), vec({4, 0, 3, 0})));            // exactly at the friction angle
  expect_exact(evaluate(particle(1, 1, 0.5), vec({0, 0, 0, 1})));              // leaves the ground
  expect_exact(evaluate(Problem("plate", plate()), plate_answer()));
}

TEST(EvaluationTest, SlidingParticleLosesTheWorkWorkedOutByHand) {
  const Errors errors = evaluate(sliding_particle(), sliding_answer());
  EXPECT_EQ(errors.work_gain_j, -1.375);  // from 1/2 (4 + 1) to 1/2 (1.5^2)
  EXPECT_EQ(errors.work_gain_relative, -0.55);
  EXPECT_EQ(errors.min_z, 0);
  EXPECT_TRUE(errors.criterion);
}

TEST(EvaluationTest, AnExactAnswerWithFullInertiaLeavesAtMostQuadRounding) {
  // N = G K makes G^-1 N = K exact, and v = -K f makes f = (1, 2) stop both contacts.
  Matrix G(3, 3);
  G << 4, 1, -2, 1, 5, 3, -2, 3, 7;
  Matrix K(3, 2);
  K << 1, -1, 0, 2, 3, 1;
  const Errors errors =
      evaluate(Problem("exact", frictionless(-(K * vec({1, 2})), G * K, DenseInertia{G})), vec({1, 2}));
  EXPECT_LE(errors.velocity_residual_m_per_s, 1e-30);
  EXPECT_LE(errors.backward_componentwise, 1e-30);
  EXPECT_LE(errors.violation_m_per_s, 1e-30);
}

TEST(EvaluationTest, ASmallErrorIsMeasuredExactly) {
  for (const double d : {0x1p-30, -0x1p-30, 0x1p-10, -0x1p-10}) {
    const Errors errors = evaluate(particle(0, -2, 0.5), vec({2 + d, 0, 0, 0}));  // w_n = d, max|q| = 2
    EXPECT_EQ(errors.velocity_residual_m_per_s, std::abs(d));
    EXPECT_EQ(errors.velocity_residual_relative, std::abs(d) / 2);
    EXPECT_EQ(errors.solved, std::abs(d) / 2 <= kSolvedVelocityResidual);
    EXPECT_EQ(errors.violation_m_per_s, std::max(0.0, -d));
    EXPECT_EQ(errors.violation_relative, std::max(0.0, -d) / 2);
    EXPECT_EQ(errors.complementarity_j, (2 + d) * d);
    EXPECT_EQ(errors.complementarity_relative, d > 0 ? 1 : -1);
  }
}

TEST(EvaluationTest, TheResidualComparesVelocitiesWithVelocities) {
  // Mass 4: M_ii = 1/4. Friction row: f_+ = 1/2 too much while w = 3.5: M_ii z_i = 1/8 m/s is the smaller velocity.
  ContactProblem problem = *sliding_particle().contact();
  problem.inertia = DenseInertia{4 * Matrix::Identity(2, 2)};
  const Vector exact = vec({4, 0, 2, 1.5});
  expect_exact(evaluate(Problem("heavy", problem), exact));
  Vector z = exact;
  z(1) += 0.5;  // v+_x = 1.625: rows: f_+ min(1/8, 3.125) = 1/8, f_- min(1/2, -1/8) = -1/8, cone min(1.5, -1/8)
  const Errors errors = evaluate(Problem("heavy", problem), z);
  EXPECT_EQ(errors.velocity_residual_m_per_s, 0.125);
  EXPECT_EQ(errors.natural_residual, 0.5);
  EXPECT_EQ(errors.cone_violation, 0.5);
  EXPECT_EQ(errors.cone_violation_relative, 0.125);
}

TEST(EvaluationTest, FrictionIgnoredPassesThePapersCriterionAndIsNotSolved) {
  for (const double lambda : {0.0, 2.0}) {
    const Errors errors = evaluate(sliding_particle(), vec({1, 0, 0, lambda}));
    EXPECT_TRUE(errors.criterion);
    EXPECT_FALSE(errors.solved);
    EXPECT_EQ(errors.velocity_residual_m_per_s, lambda == 0 ? 2 : 0.5);  // slip row; cone row
    EXPECT_EQ(verdict(Claim::kSolved, errors, Truth::kSolvable), Verdict::kCriterionOnly);
  }
  Vector z = plate_answer();
  z.segment(4, 16).setZero();
  const Errors errors = evaluate(Problem("plate", plate()), z);
  EXPECT_TRUE(errors.criterion);
  EXPECT_FALSE(errors.solved);
}

TEST(EvaluationTest, DoubledImpulsesAreNotSolved) {
  const Errors errors = evaluate(sliding_particle(), 2 * sliding_answer());
  EXPECT_FALSE(errors.solved);
  EXPECT_TRUE(errors.criterion);
  EXPECT_EQ(errors.velocity_residual_m_per_s, 1);  // v+ = (1, 1): normal min(2, 1), slip min(1, 3 - 1)
}

TEST(EvaluationTest, NegativeImpulsesAreNotSolved) {
  const Errors errors = evaluate(particle(0, 1, 0.5), vec({-1, 0, 0, 0}));  // pulls the particle back to rest
  EXPECT_EQ(errors.velocity_residual_m_per_s, 1);
  EXPECT_EQ(errors.min_z, -1);
  EXPECT_FALSE(errors.solved);
  EXPECT_TRUE(errors.criterion);                // the paper's criterion does not look at signs
  EXPECT_EQ(errors.backward_componentwise, 1);  // only tau = 1, which removes every impulse, leaves no negative one
}

TEST(EvaluationTest, WhatIsNoAnswerHasNoMeasure) {
  for (const double value : {kNan, kInf, -kInf}) {
    Vector z = sliding_answer();
    z(2) = value;
    expect_no_measure(evaluate(sliding_particle(), z));
  }
  expect_no_measure(evaluate(sliding_particle(), vec({1, 0, 0.5})));
  expect_no_measure(evaluate(sliding_particle(), vec({1, 0, 0.5, 1.5, 0})));
  expect_no_measure(evaluate(sliding_particle(), Vector()));
}

TEST(EvaluationTest, LiesAreWrong) {
  const Errors zeros = evaluate(sliding_particle(), Vector::Zero(4));
  EXPECT_EQ(verdict(Claim::kSolved, zeros, Truth::kSolvable), Verdict::kWrong);
  EXPECT_TRUE(false_claim(Claim::kSolved, Verdict::kWrong));
  const Errors nan = evaluate(sliding_particle(), Vector::Constant(4, kNan));
  EXPECT_EQ(verdict(Claim::kSolved, nan, Truth::kSolvable), Verdict::kWrong);
  const Errors of_another = evaluate(particle(0, -8, 0.5), sliding_answer());
  EXPECT_EQ(verdict(Claim::kSolved, of_another, Truth::kUnknown), Verdict::kWrong);
}

TEST(EvaluationTest, ProblemDataThatAreNotFiniteNeverLookSolved) {
  for (const double value : {kNan, kInf}) {
    ContactProblem problem = *sliding_particle().contact();
    problem.v(0) = value;
    EXPECT_FALSE(evaluate(Problem("v", problem), sliding_answer()).solved);
    problem = *sliding_particle().contact();
    problem.inertia = DenseInertia{Matrix::Constant(2, 2, value)};
    EXPECT_FALSE(evaluate(Problem("G", problem), Vector::Zero(4)).solved);
    EXPECT_EQ(Evaluator(Problem("G", problem)).truth(), Truth::kUnknown);
    problem = *sliding_particle().contact();
    problem.mu(0) = value;
    EXPECT_FALSE(evaluate(Problem("mu", problem), Vector::Zero(4)).solved);
    EXPECT_FALSE(
        Evaluator(Problem("v", frictionless(vec({value}), Matrix::Ones(1, 1), DenseInertia{Matrix::Zero(1, 1)})))
            .check_farkas(vec({1})));
    EXPECT_FALSE(Evaluator(Problem("q", Lcp{Matrix::Zero(1, 1), vec({-value})})).check_farkas(vec({1})));
    EXPECT_FALSE(evaluate(Problem("q", Lcp{Matrix::Identity(1, 1), vec({value})}), vec({0})).solved);
    EXPECT_FALSE(evaluate(Problem("M", Lcp{Matrix::Constant(1, 1, value), vec({1})}), vec({0})).solved ||
                 evaluate(Problem("M", Lcp{Matrix::Constant(1, 1, value), vec({1})}), vec({1})).solved);
  }
}

TEST(EvaluationTest, ZeroVelocityHasNoScale) {
  EXPECT_EQ(evaluate(particle(0, 0, 0.5), Vector::Zero(4)).velocity_residual_relative, 0);
  const Errors errors = evaluate(particle(0, 0, 0.5), vec({1, 0, 0, 0}));
  EXPECT_EQ(errors.velocity_residual_relative, kInf);
  EXPECT_FALSE(errors.solved);
}

TEST(EvaluationTest, TheEmptyProblemIsSolvedByTheEmptyAnswer) {
  const Errors errors = evaluate(
      Problem("free flight", frictionless(vec({1, 2}), Matrix(2, 0), DenseInertia{Matrix::Identity(2, 2)})), Vector());
  expect_exact(errors);
  EXPECT_TRUE(evaluate(Problem("empty", Lcp{Matrix(0, 0), Vector(0)}), Vector()).solved);
}

TEST(EvaluationTest, ExtremeMagnitudesNeitherOverflowNorPass) {
  const auto ball = [](double mass, double speed) {
    return Problem("ball",
                   frictionless(vec({-speed}), Matrix::Identity(1, 1), DenseInertia{Matrix::Constant(1, 1, mass)}));
  };
  expect_exact(evaluate(ball(1, 0x1p1000), vec({0x1p1000})));
  expect_exact(evaluate(ball(0x1p1000, 1), vec({0x1p1000})));
  expect_exact(evaluate(ball(0x1p-1000, 0x1p1000), vec({1})));
  expect_exact(evaluate(ball(1, 0x1p-1070), vec({0x1p-1070})));
  EXPECT_EQ(evaluate(ball(0x1p1000, 0x1p1000), vec({1})).velocity_residual_relative, 1);
  const Errors overflow = evaluate(ball(0x1p-1000, 1), vec({0x1p1000}));  // w = 2^2000
  EXPECT_EQ(overflow.velocity_residual_m_per_s, kInf);
  EXPECT_FALSE(overflow.solved);
  const Matrix lever = Matrix::Constant(1, 1, 0x1p600);  // q = -2^1200, M = 2^1200
  const Problem levered("levered", frictionless(vec({-0x1p600}), lever, DenseInertia{Matrix::Identity(1, 1)}));
  const Errors small_but_unrepresentable = evaluate(levered, vec({1 + 0x1p-20}));  // w = 2^1180
  EXPECT_EQ(small_but_unrepresentable.velocity_residual_relative, 0x1p-20);
  EXPECT_EQ(small_but_unrepresentable.velocity_residual_m_per_s, kInf);
  EXPECT_FALSE(small_but_unrepresentable.solved);
}

TEST(EvaluationTest, AnImpulseThatMovesNothingIsNotJudged) {
  // N in null(G): M = 0. Any z is accepted where w >= 0, none where w < 0: that is the definition.
  const FactoredInertia along_x{Matrix(vec({1, 0})), vec({1})};
  const Matrix N(vec({0, 1}));
  EXPECT_TRUE(evaluate(Problem("parting", frictionless(vec({0, 1}), N, along_x)), vec({5})).solved);
  EXPECT_FALSE(evaluate(Problem("closing", frictionless(vec({0, -1}), N, along_x)), vec({5})).solved);
}

TEST(EvaluationTest, WorkIsTakenWithTheInertiaItselfAlsoWhereItIsSingular) {
  const Matrix N(vec({1, 1}));
  const Vector v = vec({1, -4});  // q = -3; f = 3 stops the contact: v+ = (4, -4)
  const Problem factored("reduced", frictionless(v, N, FactoredInertia{Matrix(vec({1, 0})), vec({1})}));
  const Errors errors = evaluate(factored, vec({3}));
  EXPECT_TRUE(errors.solved);
  EXPECT_EQ(errors.work_gain_j, 7.5);  // 1/2 (4^2 - 1^2)
  EXPECT_FALSE(errors.criterion);      // a correct answer that the paper's criterion rejects

  Matrix Ginv = Matrix::Zero(2, 2);
  Ginv(0, 0) = 1;
  const Errors from_inverse = evaluate(Problem("inverse", frictionless(v, N, InverseInertia{Ginv})), vec({3}));
  EXPECT_TRUE(from_inverse.solved);
  EXPECT_EQ(from_inverse.work_gain_j, -4.5);  // z'q + 1/2 z'M z: all that G* alone tells
  EXPECT_TRUE(std::isnan(from_inverse.work_gain_relative));
}

TEST(EvaluationTest, EveryFormOfTheInertiaGivesTheSameErrors) {
  Draw draw(5);
  const Index ngc = 4;
  const Matrix X = draw.matrix(ngc, ngc);
  const Vector alpha = vec({1, 2, 0.5, 4});
  const Matrix G = X * alpha.asDiagonal() * X.transpose();  // exact: multiples of 2^-23
  const Vector v = draw.vector(ngc);
  const Matrix N = draw.matrix(ngc, 3);
  const Vector z = vec({0.5, 0, 0.25});
  const Errors dense = evaluate(Problem("dense", frictionless(v, N, DenseInertia{G})), z);
  const Errors block = evaluate(Problem("block", frictionless(v, N, BlockInertia{{G}})), z);
  const Errors factored = evaluate(Problem("factored", frictionless(v, N, FactoredInertia{X, alpha})), z);
  const Errors inverse = evaluate(Problem("inverse", frictionless(v, N, InverseInertia{G.inverse()})), z);
  for (const Errors* errors : {&block, &factored}) {
    EXPECT_EQ(errors->velocity_residual_m_per_s, dense.velocity_residual_m_per_s);
    EXPECT_EQ(errors->backward_componentwise, dense.backward_componentwise);
    EXPECT_EQ(errors->work_gain_j, dense.work_gain_j);
  }
  EXPECT_NEAR(inverse.velocity_residual_relative, dense.velocity_residual_relative, 1e-12);
  EXPECT_NEAR(inverse.work_gain_j, dense.work_gain_j, 1e-12 * std::abs(dense.work_gain_j));
}

// The same problem and answer in other units: lengths in 1/length m, masses in 1/mass kg.
struct Rescaled {
  Problem problem;
  Vector z;
};

Rescaled rescaled(const RigidScene& scene, const Vector& z, double length, double mass) {
  ContactProblem problem = contact_problem(scene);
  Vector coordinate(problem.ngc());  // factor of each velocity
  for (Index i = 0; i < problem.ngc(); ++i) coordinate(i) = i % 6 < 3 ? length : 1;
  BlockInertia& inertia = std::get<BlockInertia>(problem.inertia);
  for (std::size_t b = 0; b < inertia.blocks.size(); ++b) {
    inertia.blocks[b] *= b % 2 == 0 ? mass : mass * length * length;
  }
  problem.v = coordinate.asDiagonal() * problem.v;
  const Vector jacobian = length * coordinate.cwiseInverse();
  problem.N = Matrix(jacobian.asDiagonal() * to_dense(problem.N));
  problem.D = Matrix(jacobian.asDiagonal() * to_dense(problem.D));
  const ContactLayout layout = contact_layout(problem);
  Vector other = mass * length * z;
  other.tail(layout.cones) = length * z.tail(layout.cones);
  return {Problem("rescaled", problem), other};
}

TEST(EvaluationTest, UnitsDoNotChangeTheVerdictsMeasure) {
  Draw draw(6);
  const Vector z = plate_answer() + 1e-3 * draw.vector(24).cwiseAbs();
  const Errors reference = evaluate(Problem("plate", plate()), z);
  EXPECT_GT(reference.velocity_residual_relative, 1e-5);
  for (const double length : {1.0, 0x1p10, 0x1p-20}) {
    for (const double mass : {1.0, 0x1p10, 0x1p-30}) {
      const Rescaled other = rescaled(plate(), z, length, mass);
      const Errors errors = evaluate(other.problem, other.z);
      EXPECT_EQ(errors.velocity_residual_m_per_s, length * reference.velocity_residual_m_per_s);
      EXPECT_EQ(errors.velocity_residual_relative, reference.velocity_residual_relative);
      EXPECT_EQ(errors.backward_componentwise, reference.backward_componentwise);
      EXPECT_EQ(errors.work_gain_j, mass * length * length * reference.work_gain_j);
      if (mass == 1) {
        EXPECT_EQ(errors.backward_row_norm, reference.backward_row_norm);
      }
    }
  }
}

// A random frictional problem whose M is exact in double (G a power of two), so that form_lcp spells the same problem.
ContactProblem random_frictional(Draw& draw, Index ngc, Index contacts, int edges) {
  ContactProblem problem;
  problem.v = draw.vector(ngc);
  problem.N = draw.matrix(ngc, contacts);
  Matrix D(ngc, contacts * edges);
  for (Index c = 0; c < contacts; ++c) {
    const Matrix half = draw.matrix(ngc, edges / 2);
    D.middleCols(c * edges, edges) << half, -half;
  }
  problem.D = D;
  problem.edges.assign(static_cast<std::size_t>(contacts), edges);
  problem.mu = draw.vector(contacts).cwiseAbs();
  problem.inertia = DenseInertia{0.25 * Matrix::Identity(ngc, ngc)};
  return problem;
}

// Entries of every kind: large, zero, tiny of either sign.
Vector random_answer(Draw& draw, Index size) {
  Vector z(size);
  for (double& value : z) {
    const std::uint64_t kind = draw.bits() % 4;
    const double magnitude = std::abs(draw.uniform()) + 0x1p-11;
    if (kind == 0) value = 0;
    if (kind == 1) value = magnitude;
    if (kind == 2) value = std::ldexp(magnitude, -static_cast<int>(draw.bits() % 50));
    if (kind == 3) value = std::ldexp(draw.uniform(), -10 - static_cast<int>(draw.bits() % 40));
  }
  return z;
}

Quad plain_quotient(Quad value, Quad scale) {
  if (value == 0) return 0;
  return scale == 0 ? Quad{kInf} : value / scale;
}

// eta(z_tau) as the definition spells it, from the whole of M.
Quad plain_eta(const Lcp& lcp, const Vector& z, Index lambda_offset, Quad tau, BackwardScale kind) {
  const Index n = lcp.size();
  const auto largest = [&](Index begin, Index count) {
    return count == 0 ? 0 : z.segment(begin, count).cwiseAbs().maxCoeff();
  };
  const double impulse = largest(0, lambda_offset);
  const double lambda = largest(lambda_offset, n - lambda_offset);
  std::vector<Quad> kept;
  Quad norm = 0;
  for (Index i = 0; i < n; ++i) {
    const Quad ratio = z(i) == 0 ? Quad{0} : abs(Quad{z(i)}) / (i < lambda_offset ? impulse : lambda);
    kept.push_back(ratio <= tau ? 0 : z(i));
    if (kept.back() < 0) return Quad{kInf};
    norm = std::max(norm, kept.back());
  }
  Quad eta = 0;
  for (Index i = 0; i < n; ++i) {
    Quad w = lcp.q(i);
    Quad scale = abs(Quad{lcp.q(i)});
    for (Index j = 0; j < n; ++j) {
      const Quad entry = lcp.M(i, j);
      const Quad z_j = kept[static_cast<std::size_t>(j)];
      w += entry * z_j;
      scale += abs(entry) * (kind == BackwardScale::kComponentwise ? z_j : norm);
    }
    const Quad violation = kept[static_cast<std::size_t>(i)] > 0 ? abs(w) : std::max(Quad{0}, -w);
    eta = std::max(eta, plain_quotient(violation, scale));
  }
  return eta;
}

enum class Taus { kRatios, kRatiosAndGrid };

Quad plain_mixed_error(const Lcp& lcp, const Vector& z, Index lambda_offset, BackwardScale kind,
                       Taus taus = Taus::kRatiosAndGrid) {
  Quad best = kInf;
  const auto offer = [&](Quad tau) {
    best = std::min(best, std::max(tau, plain_eta(lcp, z, lambda_offset, tau, kind)));
  };
  offer(0);
  for (int step = taus == Taus::kRatios ? 5 : -240; step <= 4; ++step) offer(std::exp2(step / 4.0));
  for (Index i = 0; i < z.size(); ++i) {
    const bool is_impulse = i < lambda_offset;
    const auto block = is_impulse ? z.head(lambda_offset) : z.tail(z.size() - lambda_offset);
    if (z(i) != 0) offer(abs(Quad{z(i)}) / block.cwiseAbs().maxCoeff());
  }
  return best;
}

void expect_close(double found, Quad expected, const std::string& what) {
  const double reference = to_double(expected);
  if (std::isinf(reference)) {
    EXPECT_EQ(found, reference) << what;
  } else {
    EXPECT_NEAR(found, reference, 1e-15 * reference + 1e-30) << what;
  }
}

TEST(BackwardErrorTest, IsTheMinimumOverAFineGridOfTau) {
  Draw draw(7);
  for (int trial = 0; trial < 60; ++trial) {
    const ContactProblem contact = random_frictional(draw, 3, 1 + trial % 3, 4);
    const Problem problem("contact", contact);
    const Lcp lcp = form_lcp(contact);
    const Index impulses = 5 * contact.nc();
    Vector z = random_answer(draw, lcp.size());
    if (trial % 3 == 0) z.head(impulses) = z.head(impulses).cwiseAbs();
    const Errors by_contact = evaluate(problem, z);
    const Errors by_matrix = evaluate(Problem("matrix", lcp), z);
    for (const BackwardScale kind : {BackwardScale::kComponentwise, BackwardScale::kRowNorm}) {
      const bool componentwise = kind == BackwardScale::kComponentwise;
      const std::string what = "trial " + std::to_string(trial) + (componentwise ? " componentwise" : " row norm");
      expect_close(componentwise ? by_contact.backward_componentwise : by_contact.backward_row_norm,
                   plain_mixed_error(lcp, z, impulses, kind), what + " contact");
      expect_close(componentwise ? by_matrix.backward_componentwise : by_matrix.backward_row_norm,
                   plain_mixed_error(lcp, z, lcp.size(), kind), what + " matrix");
    }
    EXPECT_NEAR(by_contact.natural_residual, by_matrix.natural_residual, 1e-15 * by_matrix.natural_residual);
    EXPECT_NEAR(by_contact.complementarity_j, by_matrix.complementarity_j,
                1e-15 * by_matrix.natural_residual * z.lpNorm<1>() + 1e-15 * std::abs(by_matrix.complementarity_j));
  }
}

TEST(BackwardErrorTest, IsTheMinimumOverAllRatiosWhereRowsAreChosenByEstimate) {
  Draw draw(12);
  for (int trial = 0; trial < 3; ++trial) {
    const ContactProblem contact = random_frictional(draw, 5, 10, 8);
    const Lcp lcp = form_lcp(contact);
    const Vector z = random_answer(draw, lcp.size()).cwiseAbs() + Vector::Constant(lcp.size(), 0x1p-60);
    const Errors by_contact = evaluate(Problem("contact", contact), z);
    const Errors by_matrix = evaluate(Problem("matrix", lcp), z);
    const auto expected = [&](Index lambda_offset, BackwardScale kind) {
      return plain_mixed_error(lcp, z, lambda_offset, kind, Taus::kRatios);
    };
    const std::string what = "trial " + std::to_string(trial);
    expect_close(by_contact.backward_componentwise, expected(90, BackwardScale::kComponentwise), what);
    expect_close(by_contact.backward_row_norm, expected(90, BackwardScale::kRowNorm), what);
    expect_close(by_matrix.backward_componentwise, expected(100, BackwardScale::kComponentwise), what);
    expect_close(by_matrix.backward_row_norm, expected(100, BackwardScale::kRowNorm), what);
  }
}

TEST(QuadLcpTest, EveryWayToARowGivesTheSameRow) {
  Draw draw(13);
  const ContactProblem contact = random_frictional(draw, 5, 4, 6);
  const Lcp dense = form_lcp(contact);
  const QuadInertia inertia(contact.inertia);
  ContactQuadLcp lcp(contact, inertia);
  BareQuadLcp bare(dense);
  const Vector answer_z = random_answer(draw, dense.size());
  const QuadVector z(answer_z.begin(), answer_z.end());
  QuadVector u = lcp.response(z);
  const QuadVector w = lcp.all_rows(z, u);
  const QuadVector expected = bare.response(z);
  const std::vector<double> estimated = lcp.estimate_w(z, u);
  const MagnitudeEstimate* estimate = lcp.estimate();
  ASSERT_NE(estimate, nullptr);
  for (std::size_t i = 0; i < lcp.size(); ++i) {
    EXPECT_TRUE(lcp.row(i, z, u) == w[i]);
    EXPECT_LT(std::abs(to_double(w[i] - expected[i])), 1e-30);
    EXPECT_NEAR(estimated[i], to_double(w[i]), 1e-13);
    EXPECT_LT(std::abs(to_double(lcp.diagonal(i) - bare.diagonal(i))), 1e-30);
    EXPECT_LT(std::abs(to_double(lcp.abs_row_sum(i) - bare.abs_row_sum(i))), 1e-28);
    Vector row = Vector::Zero(dense.size());
    for (std::size_t e = estimate->begin[i]; e < estimate->begin[i + 1]; ++e) {
      row(static_cast<Index>(estimate->columns[e])) = estimate->entries[e];
    }
    for (Index j = 0; j < dense.size(); ++j) {
      EXPECT_LE(std::abs(row(j) - std::abs(dense.M(static_cast<Index>(i), j))),
                estimate->row_error[i] * estimate->column_scale[static_cast<std::size_t>(j)]);
    }
  }
  lcp.remove(7, z[7], u);
  QuadVector without = z;
  without[7] = 0;
  const QuadVector again = lcp.response(without);
  for (std::size_t r = 0; r < u.size(); ++r) EXPECT_LT(std::abs(to_double(u[r] - again[r])), 1e-30);
}

TEST(BackwardErrorTest, ForgivesDustAtThePriceOfItsSize) {
  const Lcp lcp{Matrix::Identity(2, 2), vec({-1, 1})};
  const Errors errors = evaluate(Problem("dust", lcp), vec({1, 1e-12}));  // w_2 = 1: not complementary
  EXPECT_EQ(errors.backward_componentwise, 1e-12);
  EXPECT_EQ(errors.backward_row_norm, 1e-12);
  EXPECT_TRUE(errors.solved);
  EXPECT_FALSE(evaluate(Problem("dust", lcp), vec({1, 1e-8})).solved);
  EXPECT_TRUE(evaluate(Problem("dust", lcp), vec({1, -1e-12})).solved);
}

TEST(BackwardErrorTest, ARowWithoutDataForgivesNothing) {
  const Lcp lcp{Matrix::Zero(1, 1), vec({0})};
  EXPECT_EQ(evaluate(Problem("0/0", lcp), vec({3})).backward_componentwise, 0);
  Lcp coupled{Matrix::Zero(2, 2), vec({0, 1})};
  coupled.M(0, 1) = -1;  // z = (0, t): w_0 = -t with s_0 = t
  EXPECT_EQ(evaluate(Problem("-t", coupled), vec({0, 0.5})).backward_componentwise, 1);
}

TEST(EvaluationTest, TheOrderOfTheContactsDoesNotMatter) {
  Draw draw(8);
  const Index contacts = 4;
  const int edges = 4;
  ContactProblem contact = random_frictional(draw, 6, contacts, edges);
  const Matrix B = draw.matrix(6, 6);
  contact.inertia = DenseInertia{Matrix(B * B.transpose() + 0.5 * Matrix::Identity(6, 6))};
  const Vector z = random_answer(draw, contacts * (edges + 2)).cwiseAbs();
  const std::vector<Index> order{2, 0, 3, 1};

  ContactProblem permuted = contact;
  Vector other(z.size());
  Matrix N(6, contacts);
  Matrix D(6, contacts * edges);
  for (Index c = 0; c < contacts; ++c) {
    const Index from = order[static_cast<std::size_t>(c)];
    N.col(c) = to_dense(contact.N).col(from);
    D.middleCols(c * edges, edges) = to_dense(contact.D).middleCols(from * edges, edges);
    permuted.mu(c) = contact.mu(from);
    other(c) = z(from);
    other.segment(contacts + c * edges, edges) = z.segment(contacts + from * edges, edges);
    other(contacts * (edges + 1) + c) = z(contacts * (edges + 1) + from);
  }
  permuted.N = N;
  permuted.D = D;
  const Errors a = evaluate(Problem("a", contact), z);
  const Errors b = evaluate(Problem("b", permuted), other);
  EXPECT_DOUBLE_EQ(a.velocity_residual_relative, b.velocity_residual_relative);
  EXPECT_DOUBLE_EQ(a.backward_componentwise, b.backward_componentwise);
  EXPECT_DOUBLE_EQ(a.backward_row_norm, b.backward_row_norm);
  EXPECT_DOUBLE_EQ(a.work_gain_j, b.work_gain_j);
  EXPECT_DOUBLE_EQ(a.complementarity_j, b.complementarity_j);
}

TEST(EvaluationTest, ContactsWithAndWithoutFrictionMix) {
  // The plate's first corner loses its friction: the others slow it down by mu/4 each.
  RigidScene scene = plate();
  scene.contacts[0].edges = 0;
  scene.contacts[0].mu = 0;
  const ContactProblem contact = contact_problem(scene);
  const Problem problem("mixed", scene);
  const ContactLayout layout = contact_layout(contact);
  ASSERT_EQ(layout.size(), 4 + 12 + 3);
  Draw draw(9);
  const Vector z = random_answer(draw, layout.size()).cwiseAbs();
  const Lcp lcp = form_lcp(contact);
  const Errors errors = evaluate(problem, z);
  const Vector w = lcp.M * z + lcp.q;
  EXPECT_NEAR(errors.natural_residual, z.cwiseMin(w).cwiseAbs().maxCoeff(), 1e-14);
  Vector scaled = z;
  for (Index i = 0; i < 16; ++i) scaled(i) *= lcp.M(i, i);
  Vector v_w = w;
  for (Index c = 0; c < 3; ++c) v_w(16 + c) *= lcp.M(c + 1, c + 1);
  EXPECT_NEAR(errors.velocity_residual_m_per_s, scaled.cwiseMin(v_w).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(EvaluationTest, ManyBodiesAreEvaluatedWithoutFormingTheMatrix) {
  const int copies = 500;  // n = 12,000: a dense 113-bit M would take 2.3 GB
  const Problem problem("plates", plate(copies));
  Evaluator evaluator(problem);
  expect_exact(evaluator.errors(answer(plate_answer(copies))));
  EXPECT_EQ(evaluator.truth(), Truth::kSolvable);
  Vector z = plate_answer(copies);
  z(0) += 0x1p-12;
  const Errors errors = evaluator.errors(answer(z));
  EXPECT_GT(errors.velocity_residual_m_per_s, 0x1p-13);
  EXPECT_GT(errors.backward_row_norm, 1e-6);
  const Errors alone = evaluate(Problem("plate", plate()), [&] {
    Vector one = plate_answer();
    one(0) += 0x1p-12;
    return one;
  }());
  EXPECT_EQ(errors.velocity_residual_m_per_s, alone.velocity_residual_m_per_s);
  EXPECT_EQ(errors.backward_componentwise, alone.backward_componentwise);
  EXPECT_EQ(errors.backward_row_norm, alone.backward_row_norm);
}

TEST(EvaluationTest, AnEvaluatorRemembersNothingOfEarlierAnswers) {
  Draw draw(10);
  const Problem problem("contact", random_frictional(draw, 4, 3, 4));
  Evaluator reused(problem);
  for (int trial = 0; trial < 20; ++trial) {
    const Vector z = random_answer(draw, problem.size());
    const Errors fresh = evaluate(problem, z);
    const Errors again = reused.errors(answer(z));
    EXPECT_EQ(again.velocity_residual_relative, fresh.velocity_residual_relative);
    EXPECT_EQ(again.backward_componentwise, fresh.backward_componentwise);
    EXPECT_EQ(again.backward_row_norm, fresh.backward_row_norm);
  }
}

TEST(ReturnedVelocityTest, IsComparedWithWhatZImplies) {
  Answer given = answer(sliding_answer());
  given.velocity = vec({1.5, 0});
  EXPECT_EQ(Evaluator(sliding_particle()).errors(given).velocity_mismatch, 0);
  given.velocity = vec({1.5, 0.5});  // |apart| = 0.5; scale = |u| + |v| + |J f| = 0.5 + 1 + 1
  EXPECT_EQ(Evaluator(sliding_particle()).errors(given).velocity_mismatch, 0.2);
  given.velocity = vec({1.5, kNan});
  EXPECT_EQ(Evaluator(sliding_particle()).errors(given).velocity_mismatch, kInf);
  given.velocity = vec({1.5});
  EXPECT_EQ(Evaluator(sliding_particle()).errors(given).velocity_mismatch, kInf);
  given.velocity.resize(0);
  EXPECT_TRUE(std::isnan(Evaluator(sliding_particle()).errors(given).velocity_mismatch));
}

TEST(ReturnedVelocityTest, MustStayInTheRangeOfASingularInertia) {
  const Problem problem(
      "reduced", frictionless(vec({1, -4}), Matrix(vec({1, 1})), FactoredInertia{Matrix(vec({1, 0})), vec({1})}));
  Answer given = answer(vec({3}));
  given.velocity = vec({4, -4});
  EXPECT_EQ(Evaluator(problem).errors(given).velocity_mismatch, 0);
  given.velocity = vec({4, -2});  // G does not see the difference; 2 / (4 + 4)
  EXPECT_EQ(Evaluator(problem).errors(given).velocity_mismatch, 0.25);
}

TEST(ForwardErrorTest, IsTakenOfBothVelocities) {
  Matrix G = Matrix::Identity(2, 2);
  G(0, 0) = 4;
  const Problem problem("particle", frictionless(vec({0, -2}), Matrix(vec({0, 1})), DenseInertia{G}));
  Evaluator evaluator(problem);
  Answer given = answer(vec({2.5}));  // v+ = (0, 1/2)
  given.velocity = vec({0.25, 0});
  EXPECT_TRUE(std::isnan(evaluator.errors(given).forward_velocity));
  evaluator.set_certified_velocity(vec({0, 0}));
  const Errors errors = evaluator.errors(given);
  EXPECT_EQ(errors.forward_velocity, 0.25);
  EXPECT_EQ(errors.forward_normal, 0.25);
  EXPECT_EQ(errors.forward_velocity_returned, 0.25);  // sqrt(4) 1/4 over 2
  EXPECT_EQ(errors.forward_normal_returned, 0);       // the normal direction does not see it
  EXPECT_THROW(evaluator.set_certified_velocity(vec({0})), std::invalid_argument);
  EXPECT_THROW(evaluator.set_certified_velocity(vec({0, kNan})), std::invalid_argument);
  EXPECT_THROW(Evaluator(Problem("bare", Lcp{Matrix::Identity(2, 2), vec({1, 1})})).set_certified_velocity(vec({0, 0})),
               std::invalid_argument);
}

TEST(TruthTest, PositiveDefiniteInertiaMakesAContactProblemSolvable) {
  EXPECT_EQ(Evaluator(sliding_particle()).truth(), Truth::kSolvable);
  Draw draw(11);
  const Matrix N = draw.matrix(3, 5);  // redundant contacts change nothing
  const Matrix X = draw.matrix(3, 3);
  const Vector v = draw.vector(3);
  EXPECT_EQ(Evaluator(Problem("full", frictionless(v, N, FactoredInertia{X, vec({1, 2, 3})}))).truth(),
            Truth::kSolvable);
  EXPECT_EQ(Evaluator(Problem("G*", frictionless(v, N, InverseInertia{Matrix::Identity(3, 3)}))).truth(),
            Truth::kSolvable);
  EXPECT_EQ(Evaluator(Problem("reduced", frictionless(v, N, FactoredInertia{X.leftCols(2), vec({1, 2})}))).truth(),
            Truth::kUnknown);
  Matrix dependent = X;
  dependent.col(2) = dependent.col(0) + dependent.col(1);
  EXPECT_EQ(Evaluator(Problem("dependent", frictionless(v, N, FactoredInertia{dependent, vec({1, 2, 3})}))).truth(),
            Truth::kUnknown);
  ContactProblem negative_mu = *sliding_particle().contact();
  negative_mu.mu(0) = -0.5;
  EXPECT_EQ(Evaluator(Problem("mu", negative_mu)).truth(), Truth::kUnknown);
}

TEST(TruthTest, ABareLcpIsSolvableWhenItsMatrixIsProvenPositiveDefinite) {
  Matrix M(2, 2);
  M << 1, 5, -5, 1;
  EXPECT_EQ(Evaluator(Problem("PD", Lcp{M, vec({-1, -1})})).truth(), Truth::kSolvable);
  M << 1, 1, 1, 1;
  EXPECT_EQ(Evaluator(Problem("PSD", Lcp{M, vec({-1, -1})})).truth(), Truth::kUnknown);
  EXPECT_EQ(Evaluator(Problem("large", Lcp{Matrix::Identity(65, 65), Vector::Ones(65)})).truth(), Truth::kUnknown);
}

// Two contacts push along x against each other and up together; nothing has inertia along y.
Problem squeezed(double vx, double vy) {
  Matrix N(2, 2);
  N << 1, -1, 1, 1;
  return Problem("squeezed", frictionless(vec({vx, vy}), N, FactoredInertia{Matrix(vec({1, 0})), vec({2})}));
}

TEST(FarkasTest, AProofHoldsAndOverridesASmallResidual) {
  const Problem problem = squeezed(0x1p-40, -0x1p-20);
  const Evaluator evaluator(problem);
  EXPECT_TRUE(evaluator.check_farkas(vec({1, 1})));
  EXPECT_TRUE(evaluator.check_farkas(vec({0x1p-1000, 0x1p-1000})));
  EXPECT_EQ(evaluator.truth(), Truth::kUnknown);
  Errors looks_solved;
  looks_solved.solved = true;
  EXPECT_EQ(verdict(Claim::kSolved, looks_solved, Truth::kUnsolvable), Verdict::kUnsolvable);
  EXPECT_TRUE(false_claim(Claim::kSolved, Verdict::kUnsolvable));
}

TEST(FarkasTest, WhatIsNotExactlyAProofIsNone) {
  const Evaluator evaluator(squeezed(0, -1));
  EXPECT_FALSE(evaluator.check_farkas(vec({1, 1 + 0x1p-52})));  // equal only to rounding
  EXPECT_FALSE(evaluator.check_farkas(vec({1, 0})));
  EXPECT_FALSE(evaluator.check_farkas(vec({0, 0})));
  EXPECT_FALSE(evaluator.check_farkas(vec({-1, -1})));
  EXPECT_FALSE(evaluator.check_farkas(vec({kNan, 1})));
  EXPECT_FALSE(evaluator.check_farkas(vec({kInf, kInf})));
  EXPECT_FALSE(evaluator.check_farkas(vec({1})));
  EXPECT_FALSE(evaluator.check_farkas(Vector()));
  EXPECT_FALSE(Evaluator(squeezed(0, 1)).check_farkas(vec({1, 1})));  // parting: solvable
  EXPECT_FALSE(Evaluator(squeezed(0, 1)).check_farkas(vec({-1, -1})));
  EXPECT_FALSE(Evaluator(squeezed(0, 0)).check_farkas(vec({1, 1})));
}

TEST(FarkasTest, SumsThatDoubleArithmeticLosesAreKept) {
  Matrix N(2, 3);
  N << 1, 0x1p-80, -1, 1, 1, 1;  // in double the first row sums to zero
  const FactoredInertia along_x{Matrix(vec({1, 0})), vec({1})};
  EXPECT_FALSE(Evaluator(Problem("lost", frictionless(vec({0, -1}), N, along_x))).check_farkas(vec({1, 1, 1})));
  N(0, 1) = 0;
  EXPECT_TRUE(Evaluator(Problem("kept", frictionless(vec({0, -1}), N, along_x))).check_farkas(vec({1, 1, 1})));
  N << 0x1p1000, 0, -0x1p1000, 0x1p-1000, 0x1p-1000, 0x1p-1000;
  EXPECT_TRUE(
      Evaluator(Problem("far", frictionless(vec({0, -0x1p-1000}), N, along_x))).check_farkas(vec({1, 0x1p-1070, 1})));
}

TEST(FarkasTest, EveryFormOfTheInertiaHasItsNullSpace) {
  Matrix N(2, 2);
  N << 1, -1, 1, 1;
  const Vector v = vec({0, -1});
  Matrix along_x = Matrix::Zero(2, 2);
  along_x(0, 0) = 2;
  const auto proven = [&](Inertia inertia) {
    return Evaluator(Problem("p", frictionless(v, N, std::move(inertia)))).check_farkas(vec({1, 1}));
  };
  EXPECT_TRUE(proven(DenseInertia{along_x}));
  EXPECT_TRUE(proven(InverseInertia{along_x}));
  EXPECT_TRUE(proven(BlockInertia{{Matrix::Constant(1, 1, 2), Matrix::Zero(1, 1)}}));
  EXPECT_FALSE(proven(DenseInertia{Matrix::Identity(2, 2)}));
  EXPECT_FALSE(proven(BlockInertia{{Matrix::Constant(1, 1, 2), Matrix::Constant(1, 1, 0x1p-1000)}}));
  EXPECT_FALSE(proven(FactoredInertia{Matrix::Identity(2, 2), vec({1, 1})}));
}

TEST(FarkasTest, BareProblemsAreProvenFromTheirMatrix) {
  Matrix M(2, 2);
  M << 1, -1, -1, 1;
  EXPECT_TRUE(Evaluator(Problem("crushed", Lcp{M, vec({-1, -1})})).check_farkas(vec({1, 1})));
  EXPECT_FALSE(Evaluator(Problem("barely", Lcp{M, vec({-1, 1 + 0x1p-40})})).check_farkas(vec({1, 1})));
  EXPECT_FALSE(Evaluator(Problem("crushed", Lcp{M, vec({-1, -1})})).check_farkas(vec({1, 2})));
  M << 0, 1, -1, 0;
  EXPECT_TRUE(Evaluator(Problem("transposed", Lcp{M, vec({1, -1})})).check_farkas(vec({0, 1})));
  EXPECT_FALSE(Evaluator(Problem("transposed", Lcp{M, vec({-1, 1})})).check_farkas(vec({1, 0})));
}

}  // namespace
}  // namespace lcpbench
