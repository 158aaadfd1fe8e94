#include "study/evaluation/evaluation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/evaluation_cases.h"

namespace lcpbench::evaluation_test {
namespace {

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
  EXPECT_LE(errors.violation_m_per_s, 1e-30);
}

TEST(EvaluationTest, ASmallErrorIsMeasuredExactly) {
  for (const double d : {0x1p-30, -0x1p-30, 0x1p-10, -0x1p-10}) {
    const Errors errors = evaluate(particle(0, -2, 0.5), vec({2 + d, 0, 0, 0}));  // w_n = d, max|q| = 2
    EXPECT_EQ(errors.velocity_residual_m_per_s, std::abs(d));
    EXPECT_EQ(errors.velocity_residual_relative, std::abs(d) / 2);
    EXPECT_EQ(errors.solved, std::abs(d) / 2 <= kSolvedVelocityResidual);
    EXPECT_EQ(errors.violation_m_per_s, std::max(0.0, -d));
    EXPECT_EQ(errors.complementarity_j, (2 + d) * d);
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
}

TEST(EvaluationTest, FrictionIgnoredPassesThePapersCriterionAndIsNotSolved) {
  for (const double lambda : {0.0, 2.0}) {
    const Errors errors = evaluate(sliding_particle(), vec({1, 0, 0, lambda}));
    EXPECT_TRUE(errors.criterion);
    EXPECT_FALSE(errors.solved);
    EXPECT_EQ(errors.velocity_residual_m_per_s, lambda == 0 ? 2 : 0.5);  // slip row; cone row
    EXPECT_EQ(verdict(Claim::kSolved, errors, Truth::kSolvable), Verdict::kWrong);
    EXPECT_EQ(verdict(Claim::kTimeLimit, errors, Truth::kSolvable), Verdict::kMissed);
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
  EXPECT_TRUE(errors.criterion);  // the paper's criterion does not look at signs
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

TEST(EvaluationTest, WithoutVelocityTheLeastScaleDecides) {
  EXPECT_EQ(evaluate(particle(0, 0, 0.5), Vector::Zero(4)).velocity_residual_relative, 0);
  const Errors errors = evaluate(particle(0, 0, 0.5), vec({1, 0, 0, 0}));
  EXPECT_DOUBLE_EQ(errors.velocity_residual_relative, 1e8);
  EXPECT_FALSE(errors.solved);
}

TEST(EvaluationTest, TheEmptyProblemIsSolvedByTheEmptyAnswer) {
  const Errors errors = evaluate(
      Problem("free flight", frictionless(vec({1, 2}), Matrix(2, 0), DenseInertia{Matrix::Identity(2, 2)})), Vector());
  expect_exact(errors);
  const Problem empty("empty", Lcp{Matrix(0, 0), Vector(0)});
  EXPECT_TRUE(evaluate(empty, Vector()).solved);
  Answer refusal;
  refusal.claim = Claim::kUnsupported;
  EXPECT_FALSE(Evaluator(empty).errors(refusal).solved);
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
}

TEST(EvaluationTest, WorkOfALightFactorIsNotLostInTheRoundingOfAHeavyOne) {
  Matrix X(3, 2);
  X << 3, 1, 7, 1, 0, 0;
  const ContactProblem contact =
      frictionless(vec({-1, 1, 0}), Matrix(vec({1, -1, 0})), FactoredInertia{X, vec({1e60, 1})});
  const Errors errors = evaluate(Problem("light", contact), vec({0.32}));
  EXPECT_TRUE(errors.solved);
  EXPECT_DOUBLE_EQ(errors.work_gain_j, -0.32);  // f N'(v + v+) / 2
  EXPECT_TRUE(errors.criterion);
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
    EXPECT_NEAR(errors->velocity_residual_m_per_s, dense.velocity_residual_m_per_s,
                0x1p-30 * dense.velocity_residual_m_per_s);  // diagonal entries of M are that accurate
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
      EXPECT_EQ(errors.work_gain_j, mass * length * length * reference.work_gain_j);
    }
  }
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
  const Errors alone = evaluate(Problem("plate", plate()), [&] {
    Vector one = plate_answer();
    one(0) += 0x1p-12;
    return one;
  }());
  EXPECT_EQ(errors.velocity_residual_m_per_s, alone.velocity_residual_m_per_s);
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

TEST(ReturnedVelocityTest, IsPartOfTheAnswer) {
  // v = (2, -1), v+ = (1.5, 0), |G*| |J| |f| = (0.5, 1): the limits are 1e-4 times (2.5, 2).
  const auto judged = [](const Vector& velocity) {
    Answer given = answer(sliding_answer());
    given.velocity = velocity;
    return Evaluator(sliding_particle()).errors(given);
  };
  for (const double part : {0.0, 0.99, -0.99, 1.01, -1.01}) {
    for (const double other : {0.0, 1.01}) {
      const Errors errors = judged(vec({1.5 + part * 2.5e-4, other * 2e-4}));
      EXPECT_EQ(errors.solved, std::abs(part) < 1 && other < 1) << part << " " << other;
      EXPECT_NEAR(errors.returned_velocity_error, 1e-4 * std::max(std::abs(part), other), 1e-12);
    }
  }
  const Errors errors = judged(vec({777, 0}));
  EXPECT_EQ(errors.worst_coordinate.coordinate, 0);
  EXPECT_EQ(errors.worst_coordinate.returned, 777);
  EXPECT_EQ(errors.worst_coordinate.implied, 1.5);
  for (const Vector& none : {vec({1.5, kNan}), vec({1.5, kInf}), vec({1.5}), vec({1.5, 0, 0})}) {
    EXPECT_EQ(judged(none).returned_velocity_error, kInf);
    EXPECT_FALSE(judged(none).solved);
  }
  EXPECT_TRUE(judged(Vector()).solved);
  EXPECT_TRUE(std::isnan(judged(Vector()).returned_velocity_error));
}

/// Two equal pushes from both sides move nothing: v and G* J f are zero, and what rounding leaves is right.
TEST(ReturnedVelocityTest, MayRoundWhatCancels) {
  Matrix G(3, 3);
  G << 4, 1, -2, 1, 5, 3, -2, 3, 7;
  Matrix N(3, 2);
  N << 1, -1, 0.3, -0.3, 0.1, -0.1;
  const Problem problem("pressed", frictionless(Vector::Zero(3), N, DenseInertia{G}));
  Answer given = answer(vec({2, 2}));
  for (const double size : {1e-17, 1e-3}) {
    given.velocity = Vector::Constant(3, size);
    EXPECT_EQ(Evaluator(problem).errors(given).velocity_passes(), size < 1e-10) << size;
  }
  given.z.setZero();
  EXPECT_FALSE(Evaluator(problem).errors(given).velocity_passes());
}

/// An impulse on the second coordinate leaves the third at rest, G*_32 = 0, but a system in G rounds there, too.
TEST(ReturnedVelocityTest, MayRoundAsSolvingDoes) {
  Matrix G(4, 4);
  G << 1, 2, 2, 1, 2, 5, 4, 1, 2, 4, 5, 2, 1, 1, 2, 3;
  const Vector moved = 1e4 * vec({-5, 2, 0, 1});  // G moved = (0, 1e4, 0, 0)
  const Problem problem("pushed", frictionless(Vector::Zero(4), Matrix(vec({0, 1, 0, 0})), DenseInertia{G}));
  Answer given = answer(vec({1e4}));
  for (const double rounding : {5e-11, 1e-9}) {
    given.velocity = moved + rounding * vec({0, 0, 1, 0});
    EXPECT_EQ(Evaluator(problem).errors(given).velocity_passes(), rounding < 5e-10) << rounding;
  }
}

/// G = diag(2^-40, 2^-41, 0) + w w': rounding explains more than a thousandth of a velocity, and does not excuse it.
TEST(ReturnedVelocityTest, MayRoundLittleOfWhatMoves) {
  const Vector w = vec({1, -1, -7});
  const Matrix G = Matrix(vec({0x1p-40, 0x1p-41, 0}).asDiagonal()) + w * w.transpose();
  const Problem problem("weak", frictionless(Vector::Zero(3), Matrix(vec({1, 0, 0})), DenseInertia{G}));
  Answer given = answer(vec({0x1p-40}));
  for (const double off : {0.9e-4, 1.1e-4}) {
    given.velocity = vec({1, off, 1.0 / 7});
    EXPECT_EQ(Evaluator(problem).errors(given).velocity_passes(), off < 1e-4) << off;
  }
}

/// There is no G whose diagonal could tell what rounding may leave. The scale is |v| + |G*| |J| |f| = 2.
TEST(ReturnedVelocityTest, IsComparedWhereOnlyTheInverseIsGiven) {
  const Problem problem("inverse",
                        frictionless(vec({0, -1}), Matrix(vec({1, 1})), InverseInertia{Matrix::Identity(2, 2)}));
  Answer given = answer(vec({1}));
  for (const double off : {1.9e-4, 2.1e-4}) {
    given.velocity = vec({1, off});
    EXPECT_EQ(Evaluator(problem).errors(given).velocity_passes(), off < 2e-4) << off;
  }
}

/// Regular, with pivots of about one in double, which puts its least eigenvalue at 2^-51: it is about 2^-80. The last
/// coordinate takes 98^2 / 2401 = 4 from the one before it, but for rounding.
Matrix nearly_singular() {
  Matrix U = Matrix::Identity(41, 41);
  for (Index j = 0; j < 40; ++j) U.col(j).head(j).setConstant(-1);
  Matrix G = U * U.transpose();
  G(39, 39) += 4;
  G(39, 40) = G(40, 39) = 98;
  G(40, 40) = 2401;
  return G;
}

/// 113 bits do not hold 5 beside 1e36.
TEST(EvaluationTest, WhatIsLeftOfImpulsesThatCancelIsMeasuredInAnyOrder) {
  for (const bool first : {true, false}) {
    Matrix N(1, 4);
    if (first) N << 1, 1, -1, 1;
    else N << 1, -1, 1, 1;
    ContactProblem problem = frictionless(vec({0}), N, DenseInertia{Matrix::Identity(1, 1)});
    problem.b = vec({0, 0, 0, 1});
    for (const double large : {1e20, 1e36, 1e100}) {
      const Vector z = first ? vec({5, large, large, 0}) : vec({large, large, 5, 0});
      EXPECT_EQ(evaluate(Problem("pressed", problem), z).velocity_residual_m_per_s, 5) << large;
    }
  }
}

/// Only what asks for more than v and J f is not measured, and then nothing is: no G* is known.
TEST(EvaluationTest, InertiaThatProvesUnresolvedLateLeavesTheAnswerOpen) {
  constexpr Index kSize = 41;
  const Vector v = Vector::Unit(kSize, 0);
  Matrix N(kSize, 2);
  N << Vector::Unit(kSize, 0), -Vector::Unit(kSize, 0);
  const DenseInertia inertia{nearly_singular()};
  ContactProblem one = frictionless(v, Matrix(N.col(0)), inertia);
  Answer given = answer(vec({0}));
  EXPECT_TRUE(Evaluator(Problem("separates", one)).errors(given).solved);
  given.velocity = 3 * v;  // how wrong that is depends on G*
  const Errors moved = Evaluator(Problem("separates", one)).errors(given);
  EXPECT_TRUE(moved.unresolved);
  EXPECT_FALSE(moved.solved);
  EXPECT_TRUE(std::isnan(moved.measure()));
  EXPECT_EQ(verdict(Claim::kSolved, moved, Truth::kUnknown), Verdict::kOpen);
  // Opposite impulses move nothing. The first contact separates with 1 m/s: its residual is the least of M_ii z_i
  // and 1.
  ContactProblem two = frictionless(v, N, inertia);
  two.b = vec({0, 1});
  const Errors pressed = evaluate(Problem("pressed", two), vec({1, 1}));
  EXPECT_TRUE(pressed.unresolved);
  EXPECT_FALSE(pressed.solved);
  EXPECT_TRUE(std::isnan(pressed.measure()));
}

/// Two factors that only exact arithmetic tells apart: it takes finite data alone.
TEST(EvaluationTest, DataThatAreNotFiniteHaveNoErrors) {
  Matrix X(3, 2);
  X << 1, 1, 0, 0x1p-60, 0, 0;
  for (const double speed : {kNan, kInf}) {
    const Problem problem(
        "not finite", frictionless(vec({speed, 0, 0}), Matrix(vec({1, 0, 0})), FactoredInertia{X, Vector::Ones(2)}));
    const Errors errors = evaluate(problem, vec({0}));
    EXPECT_FALSE(errors.solved);
    EXPECT_TRUE(std::isnan(errors.velocity_residual_m_per_s));
  }
}

TEST(ForwardErrorTest, IsTakenOfTheVelocityThatZImplies) {
  Matrix G = Matrix::Identity(2, 2);
  G(0, 0) = 4;
  const Problem problem("particle", frictionless(vec({0, -2}), Matrix(vec({0, 1})), DenseInertia{G}));
  Evaluator evaluator(problem);
  Answer given = answer(vec({2.5}));  // v+ = (0, 1/2)
  given.velocity = vec({0.25, 0});
  EXPECT_TRUE(std::isnan(evaluator.errors(given).forward_velocity));
  evaluator.set_certified_velocity(vec({0, 0}));
  EXPECT_EQ(evaluator.errors(given).forward_velocity, 0.25);
  EXPECT_THROW(evaluator.set_certified_velocity(vec({0})), std::invalid_argument);
  EXPECT_THROW(evaluator.set_certified_velocity(vec({0, kNan})), std::invalid_argument);
  EXPECT_THROW(Evaluator(Problem("bare", Lcp{Matrix::Identity(2, 2), vec({1, 1})})).set_certified_velocity(vec({0, 0})),
               std::invalid_argument);
}

}  // namespace
}  // namespace lcpbench::evaluation_test
