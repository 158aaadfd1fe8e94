#include "study/evaluation/friction_model.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "core/compliance.h"
#include "core/round_cone.h"
#include "core/scene.h"
#include "study/certificates/judge.h"
#include "study/certify/deadline.h"

namespace lcpbench::friction_model_test {
namespace {

constexpr double kMass = 2;
constexpr double kMu = 0.5;

/// A body that hits the ground at 1 m/s below its centre, and slides; the contact moves it without turning.
Problem sliding(double vx, double vy) {
  RigidScene scene;
  scene.bodies.push_back({.mass = kMass, .linear_velocity = {vx, vy, -1}});
  scene.contacts.push_back({.mu = kMu, .edges = 4});
  return Problem("sliding", std::move(scene));
}

/// z of the friction impulse (fx, fy) under the normal impulse f_N, with the least lambda for the pyramid.
Answer impulses(double normal, double fx, double fy) {
  Answer answer;
  answer.claim = Claim::kSolved;
  answer.z = Vector::Zero(6);
  answer.z << normal, std::max(fx, 0.0), std::max(fy, 0.0), std::max(-fx, 0.0), std::max(-fy, 0.0), 0;
  return answer;
}

Errors by_cone(const Problem& problem, const Answer& answer) {
  Errors errors = Evaluator(problem).errors(answer);
  measure_friction(FrictionModel::kCone, problem, answer, errors);
  return errors;
}

/// A contact that nothing presses slides at 5 m/s; it has to separate. No lambda hides that from a model of the cone.
TEST(FrictionModelTest, ALargeLambdaHidesNoSlip) {
  RigidScene scene;
  scene.bodies.push_back({.mass = kMass, .linear_velocity = {3, 4, 0}});
  scene.contacts.push_back({.mu = kMu, .edges = 4});
  const Problem problem("grazing", std::move(scene));
  for (const double lambda : {4.0, 1e60}) {
    Answer answer = impulses(0, 0, 0);
    answer.z(5) = lambda;
    Errors convex = Evaluator(problem).errors(answer);
    EXPECT_TRUE(convex.solved);
    EXPECT_TRUE(by_cone(problem, answer).solved) << lambda;
    measure_friction(FrictionModel::kConvex, problem, answer, convex);
    EXPECT_FALSE(convex.solved) << lambda;
    answer.z(0) = kMass;  // presses, without friction
    EXPECT_FALSE(by_cone(problem, answer).solved) << lambda;
    EXPECT_GE(by_cone(problem, answer).model_error_m_per_s, 0.25) << lambda;
  }
}

/// Coulomb's answer to an oblique slip: the friction is opposite to it, at the limit.
TEST(FrictionModelTest, TheConesSolutionPassesAndThePyramidsDoesNot) {
  const Problem problem = sliding(3, 4);  // of 5 m/s
  const double normal = kMass;
  const Answer cone = impulses(normal, -kMu * normal * 0.6, -kMu * normal * 0.8);
  EXPECT_TRUE(by_cone(problem, cone).solved);
  EXPECT_LT(by_cone(problem, cone).velocity_residual_m_per_s, 1e-15);
  EXPECT_LT(by_cone(problem, cone).cone_violation, 1e-15);
  EXPECT_FALSE(Evaluator(problem).errors(cone).solved);

  Answer pyramid = impulses(normal, 0, -kMu * normal);  // its corner nearest to the slip
  pyramid.z(5) = 4 - kMu;
  EXPECT_TRUE(Evaluator(problem).errors(pyramid).solved);
  const Errors errors = by_cone(problem, pyramid);
  EXPECT_FALSE(errors.solved);
  // On the disc of radius mu = 0.5 m/s the corner is at (0, -0.5), the nearest point of (0, -0.5) - (3, 3.5) at
  // -0.5 (3, 4) / 5: they are sqrt(0.3^2 + 0.1^2) apart. The point approaches at 1 m/s.
  EXPECT_NEAR(errors.velocity_residual_m_per_s, std::sqrt(0.1), 1e-14);
  EXPECT_NEAR(errors.velocity_residual_relative, std::sqrt(0.1), 1e-14);
  EXPECT_EQ(errors.worst.row, 5);
}

/// Where the directions name no round cone, the answer is not measured, and the claim is not false.
TEST(FrictionModelTest, WhatNamesNoConeIsNotMeasured) {
  ContactProblem contact = *sliding(3, 4).contact();
  contact.D = Matrix(to_dense(contact.D)(Eigen::all, {0, 0, 2, 2}));
  const Problem irregular("one tangent twice", contact);
  Answer answer;
  answer.claim = Claim::kSolved;
  answer.z = Vector::Zero(6);
  for (const FrictionModel model : {FrictionModel::kCone, FrictionModel::kConvex}) {
    Errors errors = Evaluator(irregular).errors(answer);
    measure_friction(model, irregular, answer, errors);
    EXPECT_TRUE(errors.unresolved);
    EXPECT_EQ(verdict(answer.claim, errors, Truth::kUnknown), Verdict::kOpen);
  }
}

/// Directions as edge_direction() rounds them name a cone; those that are off by 6e-7, and one tangent twice, do not.
TEST(FrictionModelTest, RegularMeansToTheLastDigitsOfARoundedDirection) {
  ContactProblem contact = *sliding(3, 4).contact();
  Matrix D(contact.ngc(), 8);
  for (Index k = 0; k < 8; ++k) {
    const auto [c, s] = edge_direction(k, 8);
    D.col(k) = c * to_dense(contact.D).col(0) + s * to_dense(contact.D).col(1);
  }
  contact.D = D;
  contact.edges = {8};
  EXPECT_EQ(why_no_round_cone(contact), "");
  D(0, 2) += 6e-7;
  D(0, 6) -= 6e-7;
  contact.D = D;
  EXPECT_NE(why_no_round_cone(contact), "");
  contact.D = Matrix(D(Eigen::all, {0, 0, 4, 4}));
  contact.edges = {4};
  EXPECT_NE(why_no_round_cone(contact), "");
}

TEST(FrictionModelTest, StickingAndSeparationPass) {
  EXPECT_TRUE(by_cone(sliding(0.2, 0.3), impulses(kMass, -0.2 * kMass, -0.3 * kMass)).solved);  // |f| = 0.36 f_N
  RigidScene scene;
  scene.bodies.push_back({.mass = kMass, .linear_velocity = {1, 1, 1}});
  scene.contacts.push_back({.mu = kMu, .edges = 4});
  EXPECT_TRUE(by_cone(Problem("up", std::move(scene)), impulses(0, 0, 0)).solved);
}

TEST(FrictionModelTest, EachWayToBreakTheConeIsSeen) {
  const double f = kMu * kMass;
  EXPECT_FALSE(by_cone(sliding(3, 4), impulses(kMass, 0, 0)).solved) << "slips without friction";
  EXPECT_FALSE(by_cone(sliding(3, 4), impulses(kMass, f * 0.6, f * 0.8)).solved) << "along the slip";
  EXPECT_FALSE(by_cone(sliding(0.5, 0.5), impulses(kMass, -0.5 * kMass, -0.5 * kMass)).solved) << "more than its limit";
  EXPECT_FALSE(by_cone(sliding(0, 0), impulses(0, 0, 0)).solved) << "approaches";
  EXPECT_FALSE(by_cone(sliding(0, 0), impulses(2 * kMass, 0, 0)).solved) << "jumps";
  EXPECT_NEAR(by_cone(sliding(0.5, 0.5), impulses(kMass, -0.5 * kMass, -0.5 * kMass)).cone_violation,
              std::sqrt(0.5) * kMass - f, 1e-14);
}

/// Bodies of kMass, each with three coordinates and a contact of its own along the third: each is an island.
Problem polygons(int edges, const std::vector<std::array<double, 3>>& velocities) {
  const auto count = static_cast<Index>(velocities.size());
  Matrix N = Matrix::Zero(3 * count, count);
  Matrix D = Matrix::Zero(3 * count, edges * count);
  ContactProblem contact;
  contact.v.resize(3 * count);
  for (Index i = 0; i < count; ++i) {
    for (Index k = 0; k < 3; ++k)
      contact.v(3 * i + k) = velocities[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
    N(3 * i + 2, i) = 1;
    for (Index k = 0; k < edges / 2; ++k) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) / edges;
      D(3 * i, edges * i + k) = std::cos(angle);
      D(3 * i + 1, edges * i + k) = std::sin(angle);
      D.col(edges * i + k + edges / 2) = -D.col(edges * i + k);
    }
  }
  contact.N = N;
  contact.D = D;
  contact.edges.assign(velocities.size(), edges);
  contact.mu = Vector::Constant(count, kMu);
  contact.inertia = DenseInertia{kMass * Matrix::Identity(3 * count, 3 * count)};
  return Problem("polygons", std::move(contact));
}

/// The cone is the same however many edges its polygon has.
TEST(FrictionModelTest, TheImpulsesOfEightDirectionsAreOneFriction) {
  const Problem problem = polygons(8, {{3, 3, -1}});
  Answer answer;
  answer.z = Vector::Zero(10);
  answer.z(0) = kMass;
  answer.z(1 + 5) = kMu * kMass;  // at 225 degrees, opposite to the slip
  EXPECT_TRUE(by_cone(problem, answer).solved);
  EXPECT_LT(by_cone(problem, answer).velocity_residual_m_per_s, 1e-15);
  answer.z(1 + 5) = 0;
  answer.z(1 + 4) = answer.z(1 + 6) = kMu * kMass / std::numbers::sqrt2;  // the same, along the tangents
  EXPECT_LT(by_cone(problem, answer).velocity_residual_m_per_s, 1e-15);
  answer.z(1 + 6) = 0;
  EXPECT_FALSE(by_cone(problem, answer).solved);
  answer.z(1 + 4) = 0;
  answer.z(1 + 1) = kMu * kMass;  // at 45 degrees, along the slip
  EXPECT_NEAR(by_cone(problem, answer).velocity_residual_m_per_s, 2 * kMu, 1e-14);
}

/// A fast contact does not hide a slow one that is wrong.
TEST(FrictionModelTest, EachIslandHasItsOwnScale) {
  const Problem problem = polygons(4, {{3e6, 4e6, -1e6}, {3, 4, -1}});
  Answer answer;
  answer.z = Vector::Zero(12);
  answer.z.head(2) << 1e6 * kMass, kMass;
  answer.z.segment(2, 8) << 0, 0, 1e6 * kMu * kMass * 0.6, 1e6 * kMu * kMass * 0.8, 0, 0, kMu * kMass * 0.6,
      kMu * kMass * 0.8;
  EXPECT_TRUE(by_cone(problem, answer).solved);
  answer.z.segment(6, 4).setZero();
  const Errors errors = by_cone(problem, answer);
  EXPECT_FALSE(errors.solved);
  EXPECT_NEAR(errors.velocity_residual_relative, kMu, 1e-14);
  EXPECT_EQ(errors.worst.row, 11);
}

/// The infinite offset of one contact is no scale for the violation of another.
TEST(FrictionModelTest, DataThatAreNotFiniteHaveNoErrors) {
  RigidScene scene;
  scene.bodies.push_back({.mass = kMass, .linear_velocity = {0, 0, -1}});
  scene.contacts.assign(2, {.mu = kMu, .edges = 4});
  ContactProblem contact = *Problem("two contacts", std::move(scene)).contact();
  contact.b = Vector{{0, std::numeric_limits<double>::infinity()}};
  Answer answer;
  answer.z = Vector::Zero(12);
  const Errors errors = by_cone(Problem("infinite", contact), answer);
  EXPECT_FALSE(errors.solved);
  EXPECT_TRUE(std::isnan(errors.velocity_residual_m_per_s));
}

/// The energies of such impulses exceed the largest double.
TEST(FrictionModelTest, HugeImpulsesAreNotNearTheOptimum) {
  const Answer answer = impulses(1e160, 0, 0);
  Errors errors = Evaluator(sliding(3, 4)).errors(answer);
  measure_friction(FrictionModel::kConvex, sliding(3, 4), answer, errors);
  EXPECT_GE(errors.optimum_distance, 0.5);
}

TEST(FrictionModelTest, AnAnswerToTheConeIsJudgedByItAndTellsNothingOfThePyramid) {
  const Problem problem = sliding(3, 4);
  const Answer cone = impulses(kMass, -0.3 * kMass, -0.4 * kMass);
  BoundedCertifier certifier;
  Judge judge(problem, certifier);
  const std::size_t as_cone = judge.judge(cone, FrictionModel::kCone);
  EXPECT_TRUE(judge.judgement(as_cone).errors.solved);
  EXPECT_FALSE(judge.findings().has(Evidence::kSolvedAnswer));
  const std::size_t as_pyramid = judge.judge(cone);
  EXPECT_NE(as_cone, as_pyramid);
  EXPECT_FALSE(judge.judgement(as_pyramid).errors.solved);
}

TEST(JudgeTest, ARefusalIsJudgedApartFromTheAnswerWithoutNumbers) {
  const Problem empty("empty", Lcp{Matrix(0, 0), Vector(0)});
  BoundedCertifier certifier;
  Judge judge(empty, certifier);
  Answer answer;
  answer.claim = Claim::kUnsupported;
  EXPECT_FALSE(judge.judgement(judge.judge(answer)).errors.solved);
  answer.claim = Claim::kSolved;
  EXPECT_TRUE(judge.judgement(judge.judge(answer)).errors.solved);
}

TEST(FrictionModelTest, TheVelocityOfAnAnswerToTheConeIsJudgedToo) {
  Answer cone = impulses(kMass, -0.3 * kMass, -0.4 * kMass);
  const Problem problem = sliding(3, 4);
  BoundedCertifier certifier;
  Judge judge(problem, certifier);
  cone.velocity = post_impact_velocity(*problem.contact(), cone.z);
  EXPECT_TRUE(judge.judgement(judge.judge(cone, FrictionModel::kCone)).errors.solved);
  cone.velocity(1) += 0.01;
  EXPECT_FALSE(judge.judgement(judge.judge(cone, FrictionModel::kCone)).errors.solved);
}

/// The same amount of work on every machine: what it ends for is kept or left open alike, however long it takes.
TEST(BoundedCertifierTest, EndsByWorkAndNotByTime) {
  Lcp lcp{Matrix::Zero(16, 16), Vector::Zero(16)};
  std::uint64_t state = 1;
  const auto draw = [&state] {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return std::ldexp(static_cast<double>(state >> 34) - 0x1p29, static_cast<int>(state >> 59) - 46);
  };
  for (double& entry : lcp.M.reshaped()) entry = draw();
  for (double& entry : lcp.q) entry = draw() - 0.25;
  const Problem problem("random", lcp);
  const auto kind = [&](std::int64_t work) { return Certifier({.most_work = work}).certify(problem).kind; };
  EXPECT_EQ(kind(1), CertificateKind::kOpen);
  const exact::Deadline deadline = exact::Deadline::after_work(3);
  EXPECT_FALSE(deadline.passed());
  EXPECT_FALSE(deadline.passed());
  EXPECT_TRUE(deadline.passed());
  EXPECT_THROW(deadline.require(1), exact::TimePassed);
  EXPECT_TRUE(std::isinf(deadline.left_s()));
}

/// The error that every answer has against the cone is the residual by which answers to the cone are judged.
void expect_model_error(const Problem& problem, const Answer& answer, double expected) {
  EXPECT_NEAR(Evaluator(problem).errors(answer).model_error_m_per_s, expected, 1e-14);
  const Errors cone = by_cone(problem, answer);
  EXPECT_NEAR(cone.velocity_residual_m_per_s, expected, 1e-14);
  EXPECT_EQ(cone.model_error_m_per_s, cone.velocity_residual_m_per_s);
}

TEST(FrictionModelTest, EveryAnswerWithFrictionHasAModelError) {
  Answer pyramid = impulses(kMass, 0, -kMu * kMass);
  pyramid.z(5) = 4 - kMu;
  expect_model_error(sliding(3, 4), pyramid, std::sqrt(0.1));
  EXPECT_EQ(Evaluator(sliding(3, 4)).errors(pyramid).velocity_residual_m_per_s, 0);
  expect_model_error(sliding(3, 4), impulses(kMass, -kMu * kMass * 0.6, -kMu * kMass * 0.8), 0);
  expect_model_error(sliding(0.2, 0.3), impulses(kMass, -0.2 * kMass, -0.3 * kMass), 0);  // sticks
  expect_model_error(sliding(0, 0), impulses(kMass, 0, 0), 0);                            // has nothing to hold
  expect_model_error(sliding(1, 0), impulses(kMass, 0, 0), kMu);
  expect_model_error(sliding(0, 0), impulses(0, 0, 0), 1);  // approaches: the normal row is the cone's too
  expect_model_error(sliding(3, 4), impulses(-kMass, 0, 0), 2);
  expect_model_error(sliding(0, 0), impulses(0, 0.5 * kMass, 0), 1);
  Answer eighth;
  eighth.z = Vector::Zero(10);
  eighth.z(0) = kMass;
  eighth.z(1 + 4) = kMu * kMass;
  // At 45 degrees to the slip of 1.5 m/s: the nearest point of the disc to (-0.5, 0) - (1, 1.5) is off by an angle.
  const double aim = std::hypot(1.5, 1.5);
  expect_model_error(polygons(8, {{1.5, 1.5, -1}}), eighth, std::hypot(kMu - kMu * 1.5 / aim, kMu * 1.5 / aim));
}

TEST(FrictionModelTest, WhereNoConeIsNamedNoModelErrorIs) {
  const auto error = [](const Problem& problem) {
    Answer answer;
    answer.z = Vector::Zero(problem.size());
    return Evaluator(problem).errors(answer).model_error_m_per_s;
  };
  EXPECT_FALSE(std::isnan(error(polygons(8, {{1, 1, -1}}))));
  EXPECT_TRUE(std::isnan(error(polygons(6, {{1, 1, -1}})))) << "no tangents";
  ContactProblem bent = *polygons(8, {{1, 1, -1}}).contact();
  std::get<Matrix>(bent.D).col(1) *= 1.01;
  std::get<Matrix>(bent.D).col(5) *= 1.01;
  EXPECT_TRUE(std::isnan(error(Problem("bent", bent)))) << "no regular polygon";
  Answer rest;
  rest.z = Vector::Zero(10);
  EXPECT_FALSE(std::isnan(by_cone(polygons(8, {{1, 1, -1}}), rest).velocity_residual_m_per_s));
  EXPECT_TRUE(std::isnan(by_cone(Problem("bent", bent), rest).velocity_residual_m_per_s)) << "no regular polygon";
  ContactProblem smooth = *polygons(4, {{1, 1, -1}}).contact();
  smooth.D = Matrix(3, 0);
  smooth.edges = {0};
  smooth.mu.setZero();
  EXPECT_TRUE(std::isnan(error(Problem("smooth", smooth)))) << "no friction";
}

}  // namespace
}  // namespace lcpbench::friction_model_test
