// What residuals and velocities of contacts are relative to: docs/explanation/verdicts.md.
#include <algorithm>
#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "core/answer/refined_inertia.h"
#include "study/evaluation/friction_model.h"
#include "tests/support/evaluation_cases.h"

namespace lcpbench::contact_scale_test {
namespace {

Errors evaluate_by(FrictionModel model, const ContactProblem& contact, const Vector& z) {
  const Problem problem("by a model", contact);
  Errors errors = evaluate(problem, z);
  measure_friction(model, problem, answer(z), errors);
  return errors;
}

/// The contact problem with one more contact without friction, and an answer with no impulse there.
std::pair<ContactProblem, Vector> with_contact(const ContactProblem& contact, const Vector& normal, double b,
                                               const Vector& z) {
  ContactProblem more = contact;
  const Index nc = contact.nc();
  Matrix N(contact.ngc(), nc + 1);
  N << to_dense(contact.N), normal;
  more.N = N;
  more.edges.push_back(0);
  more.mu.conservativeResize(nc + 1);
  more.b = Vector::Zero(nc + 1);
  more.mu(nc) = 0;
  if (contact.b.size() > 0) more.b.head(nc) = contact.b;
  more.b(nc) = b;
  Vector more_z(z.size() + 1);
  more_z << z.head(nc), 0, z.tail(z.size() - nc);
  return {more, more_z};
}

// A limit that is far away is open by gap / h, h a millisecond. Its normal couples it to all.
TEST(ContactScaleTest, RowsThatStayOpenChangeNothing) {
  Draw draw(31);
  for (int trial = 0; trial < 12; ++trial) {
    ContactProblem contact = random_frictional(draw, 6, 2, 4);
    const Problem alone("alone", contact);
    const Vector z = random_answer(draw, alone.size()).cwiseAbs();
    const Errors before = evaluate(alone, z);
    for (const double gap : {5.0, 1e3, 1e6}) {
      const auto [more, more_z] = with_contact(contact, draw.vector(6), gap / 1e-3, z);
      const Errors after = evaluate(Problem("with an open row", more), more_z);
      EXPECT_NEAR(after.velocity_residual_relative, before.velocity_residual_relative,
                  1e-12 * before.velocity_residual_relative);
      EXPECT_EQ(after.solved, before.solved);
    }
  }
}

// Two boxes, one on the other, that fall at 1 m/s; a push of 3e-4 of the right one is missing, or half a millionth.
TEST(ContactScaleTest, AnOpenRowHidesNoMissingImpulse) {
  const Matrix N = (Matrix(2, 2) << 1, -1, 0, 1).finished();
  const ContactProblem contact = frictionless(vec({-1, -1}), N, DenseInertia{Matrix::Identity(2, 2)});
  const Vector right = vec({2, 1});
  for (const double share : {0.0, 5e-7, 3e-4}) {
    const Vector z = right - vec({share, 0});
    const Errors before = evaluate(Problem("two", contact), z);
    EXPECT_EQ(before.solved, share < 1e-4);
    for (const double gap : {5.0, 1e3, 1e6}) {
      const auto [more, more_z] = with_contact(contact, vec({1, 1}), gap, z);
      const Errors after = evaluate(Problem("three", more), more_z);
      EXPECT_EQ(after.solved, before.solved) << share << ' ' << gap;
      EXPECT_NEAR(after.velocity_residual_relative, before.velocity_residual_relative, 1e-12);
    }
  }
}

/// What never approached and takes no impulse counts for nothing, where anything else approaches.
TEST(ContactScaleTest, AContactThatSeparatesMayBeLeftOut) {
  Draw draw(32);
  int separating = 0;
  for (int trial = 0; trial < 60; ++trial) {
    ContactProblem contact = random_frictional(draw, 5, 2, 2);
    const Problem alone("alone", contact);
    const Vector z = random_answer(draw, alone.size()).cwiseAbs() * (trial % 2 == 0 ? 1 : 0x1p-30);
    const Vector normal = draw.vector(5);
    const auto [more, more_z] = with_contact(contact, normal, 0, z);
    const bool separates = normal.dot(contact.v) > 0 && normal.dot(post_impact_velocity(more, more_z)) > 0;
    const bool approaches = (to_dense(contact.N).transpose() * contact.v).minCoeff() < -0.01;
    if (!separates || !approaches) continue;
    ++separating;
    const Errors with = evaluate(Problem("with it", more), more_z), without = evaluate(alone, z);
    EXPECT_EQ(with.solved, without.solved);
    EXPECT_NEAR(with.velocity_residual_relative, without.velocity_residual_relative,
                1e-12 * without.velocity_residual_relative);
  }
  EXPECT_GT(separating, 5);
}

// Of a box that slides at the speed that rounding leaves, beside one step of gravity, and of one that touches nothing.
TEST(ContactScaleTest, NoiseAtRestIsNeverWrong) {
  for (const double noise : {8e-16, -1e-15, 9e-13}) {
    ContactProblem contact = *particle(noise, -0.02, 1).contact();
    EXPECT_TRUE(evaluate(Problem("slides on", contact), vec({0.02, 0, 0, 0})).solved) << noise;
    contact = *particle(0, noise, 1).contact();
    EXPECT_TRUE(evaluate(Problem("falls", contact), Vector::Zero(4)).solved) << noise;
    Answer given = answer(vec({0.02, 0, 0, 0}));
    given.velocity = vec({2 * noise, -noise});
    EXPECT_TRUE(Evaluator(particle(noise, -0.02, 1)).errors(given).solved) << noise;
  }
  EXPECT_FALSE(evaluate(particle(0, -2e-8, 1), Vector::Zero(4)).solved);
  EXPECT_FALSE(evaluate(particle(0, -1.1e-12, 1), Vector::Zero(4)).solved);
}

// A millionth of the tangential speed is the least scale: the normal one is 1e-9 m/s here.
TEST(ContactScaleTest, ASlidingContactMayApproachByALittle) {
  for (const double slip : {1.0, 10.0}) {
    const Problem problem = particle(slip, -1e-9, 0);
    EXPECT_DOUBLE_EQ(evaluate(problem, vec({0, 0, 0, slip})).velocity_residual_relative, 1e-9 / (1e-6 * slip));
  }
}

/// Scales are the velocities of bodies, not the offsets that soft contacts and belts have along their tangents.
TEST(ContactScaleTest, AnOffsetAlongTheTangentIsNoScale) {
  ContactProblem contact = *particle(0, -1e-9, 0.5).contact();
  contact.offset_t = vec({1e6, 0});
  const Vector none = vec({0, 0, 0, 1e6});  // lambda is the speed of the belt
  const Errors errors = evaluate(Problem("belt", contact), none);
  EXPECT_DOUBLE_EQ(errors.velocity_residual_relative, 0.1);
  EXPECT_FALSE(errors.solved);
  contact.b = vec({1e3});  // along the normal: the row is open
  EXPECT_EQ(evaluate(Problem("belt far away", contact), none).velocity_residual_relative, 0);
  contact.b = vec({-1e3});
  EXPECT_DOUBLE_EQ(evaluate(Problem("overlap", contact), none).velocity_residual_relative, 1);
}

/// Opposite impulses that cancel, however large, leave the residual of their difference.
TEST(ContactScaleTest, HugeMultipliersHideNothing) {
  const Matrix N = (Matrix(1, 2) << 1, -1).finished();
  ContactProblem contact = frictionless(vec({-1}), N, DenseInertia{Matrix::Identity(1, 1)});
  for (const double press : {0.0, 1e7, 1e15, 1e100}) {
    EXPECT_EQ(evaluate(Problem("pressed", contact), vec({press, press})).velocity_residual_relative, 1) << press;
    EXPECT_FALSE(evaluate(Problem("pressed", contact), vec({press, press})).solved) << press;
  }
}

/// Without impulses the convex model has a residual of its own, by which it is measured: sliding opens its contacts.
TEST(ContactScaleTest, TheConvexModelHasItsOwnScale) {
  const double mu = 0.5;
  ContactProblem contact = *particle(3, -1, mu).contact();
  const Vector none = Vector::Zero(4);
  // |P(-w)| with w = (w_N, w_t) = (-1, 3): along the edge (1, mu) of the cone, (1 + 3 mu) / sqrt(1 + mu^2).
  const double without = (1 + 3 * mu) / std::sqrt(1 + mu * mu);
  const Errors errors = evaluate_by(FrictionModel::kConvex, contact, none);
  EXPECT_DOUBLE_EQ(errors.velocity_residual_m_per_s, without);
  EXPECT_DOUBLE_EQ(errors.velocity_residual_relative, 1);
  EXPECT_DOUBLE_EQ(errors.worst.scale, without);
  EXPECT_DOUBLE_EQ(evaluate_by(FrictionModel::kPyramid, contact, none).worst.scale, 1);
  EXPECT_DOUBLE_EQ(evaluate_by(FrictionModel::kCone, contact, none).worst.scale, 1);
  contact.v = vec({3, 1});  // separates, but not by mu times its slip: no impulses are no answer to the convex model
  EXPECT_TRUE(evaluate_by(FrictionModel::kCone, contact, none).solved);
  EXPECT_DOUBLE_EQ(evaluate_by(FrictionModel::kConvex, contact, none).velocity_residual_relative, 1);
  contact.v = vec({3, 2});
  EXPECT_TRUE(evaluate_by(FrictionModel::kConvex, contact, none).solved);
}

/// Their common energy could move the light one by 3e4 m/s. A forged 1e-3 m/s is 10 times what passes by that, and an
/// error of 1e-7 m/s of its own speed is right.
TEST(ContactScaleTest, AForgedVelocityOfALightBodyIsFoundBesideAHeavyOne) {
  Matrix G = Matrix::Identity(2, 2);
  G(0, 0) = 1e9;
  const ContactProblem contact = frictionless(vec({1, 0}), (Matrix(2, 1) << -1, 1).finished(), DenseInertia{G});
  const double f = 1 / (1 + 1e-9);  // both move as one
  Answer given = answer(vec({f}));
  const auto error_of = [&](double off) {
    given.velocity = vec({1 - f * 1e-9, f + off});
    return Evaluator(Problem("heavy beside light", contact)).errors(given);
  };
  EXPECT_TRUE(error_of(1e-7).solved);
  EXPECT_FALSE(error_of(1e-3).solved);
  // Apart, at rest, and in an island of its own: nothing but the least speed counts.
  Matrix apart = Matrix::Identity(3, 3);
  apart(0, 0) = 1e9;
  const ContactProblem alone = frictionless(vec({-1, 0, 0}), (Matrix(3, 2) << 1, 0, 0, 1, 0, 0).finished(),
                                            DenseInertia{apart});
  given = answer(vec({1e9, 0}));
  for (const double off : {1e-13, 1e-7, 1e-3}) {
    given.velocity = vec({0, off, 0});
    EXPECT_EQ(Evaluator(Problem("apart", alone)).errors(given).solved, off < 1e-12) << off;
  }
}

/// sqrt(G*_ii v'G v) is what the energy of the island could give a coordinate; 1e-12 of that passes, whatever it moves by.
TEST(ContactScaleTest, AVelocityMayBeOffByAShareOfTheEnergyOfItsIsland) {
  Matrix G = Matrix::Identity(2, 2);
  G(0, 0) = 1e12;
  ContactProblem contact = frictionless(vec({1, 0}), (Matrix(2, 1) << 1, 1).finished(), DenseInertia{G});
  contact.b = vec({5});  // separates: v+ = v
  Answer given = answer(vec({0}));
  for (const double off : {0.9e-6, 1.1e-6}) {  // 1e-12 sqrt(1e12)
    given.velocity = vec({1, off});
    EXPECT_EQ(Evaluator(Problem("at rest beside", contact)).errors(given).solved, off < 1e-6) << off;
  }
  given.velocity = vec({1, 2e-12});  // where G is not known, there is no energy
  contact.inertia = InverseInertia{G.inverse()};
  EXPECT_FALSE(Evaluator(Problem("given inverse", contact)).errors(given).solved);
}

/// Factors x and x + d y with x = (9, -10, -11), y = (11, -7, -15), and the normal x + (x + d y) + n, n = (73, 14, 47)
/// at right angles to both, which the inertia does not see: M = 1^2 + 1^2.
ContactProblem close_factors(double d) {
  Matrix X(3, 2), N(3, 1);
  X << 9, 9 + 11 * d, -10, -10 - 7 * d, -11, -11 - 15 * d;
  N << 91 + 11 * d, -6 - 7 * d, 25 - 15 * d;
  return frictionless(vec({-1, 0, 0}), N, FactoredInertia{X, vec({1, 1})});
}

/// Where the factors are distinct the right answer is found right and another one wrong. Where 113 bits lose the right
/// one, it is neither; only what is wrong however they round is wrong.
TEST(ContactScaleTest, WhatIsNotResolvedIsOpen) {
  for (const int bits : {10, 20, 34, 38}) {
    const double d = std::ldexp(1.0, -bits), right = (91 + 11 * d) / 2;
    Evaluator evaluator(Problem("close", close_factors(d)));
    const auto verdict_on = [&](double f, Claim claim) {
      return verdict(claim, evaluator.errors(answer(vec({f}))), Truth::kUnknown);
    };
    EXPECT_EQ(evaluator.errors(answer(vec({right}))).unresolved, bits > 20) << bits;
    EXPECT_EQ(verdict_on(right, Claim::kSolved), bits > 20 ? Verdict::kOpen : Verdict::kSolved) << bits;
    EXPECT_EQ(verdict_on(right, Claim::kIterationLimit), bits > 20 ? Verdict::kOpen : Verdict::kSolved) << bits;
    EXPECT_EQ(verdict_on(right * (1 + 3e-4), Claim::kSolved), bits > 20 ? Verdict::kOpen : Verdict::kWrong) << bits;
    EXPECT_EQ(verdict_on(1e-12, Claim::kSolved), Verdict::kWrong) << bits;  // hardly an impulse, whatever it moves
  }
}

/// No impulses need no G*: they are right wherever nothing approaches, and are left open with a velocity that is not v.
TEST(ContactScaleTest, NoImpulsesNeedNoInertia) {
  Matrix X(3, 3);
  X << 1, 1, 1, 0, 0x1p-52, 0, 1, 1, 1 + 0x1p-52;
  X(1, 1) = 0x1p-97;  // neither dependent nor independent
  const ContactProblem contact =
      frictionless(vec({0, 1, 0}), Matrix(vec({0, 1, 0})), FactoredInertia{X, Vector::Ones(3)});
  ASSERT_TRUE(RefinedInertia(contact.inertia).unresolved());
  Answer given = answer(vec({0}));
  EXPECT_TRUE(Evaluator(Problem("separates", contact)).errors(given).solved);
  given.velocity = contact.v;
  EXPECT_TRUE(Evaluator(Problem("separates", contact)).errors(given).solved);
  given.velocity = 2 * contact.v;
  const Errors moved = Evaluator(Problem("separates", contact)).errors(given);
  EXPECT_EQ(verdict(Claim::kSolved, moved, Truth::kUnknown), Verdict::kOpen);
  ContactProblem closing = contact;
  closing.v = -contact.v;
  EXPECT_TRUE(evaluate(Problem("closes", closing), vec({0})).unresolved);
  EXPECT_TRUE(evaluate(Problem("separates", contact), vec({1})).unresolved);
}

}  // namespace
}  // namespace lcpbench::contact_scale_test
