#include "study/evaluation/friction_model.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/scene.h"
#include "study/certificates/judge.h"

namespace lcpbench {
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
  measure_cone(problem, answer, errors);
  return errors;
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
  // -0.5 (3, 4) / 5: they are sqrt(0.3^2 + 0.1^2) apart. The largest q is 4 m/s.
  EXPECT_NEAR(errors.velocity_residual_m_per_s, std::sqrt(0.1), 1e-14);
  EXPECT_NEAR(errors.velocity_residual_relative, std::sqrt(0.1) / 4, 1e-14);
  EXPECT_EQ(errors.worst.row, 5);
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

TEST(FrictionModelTest, AnAnswerToTheConeIsJudgedByItAndTellsNothingOfThePyramid) {
  const Problem problem = sliding(3, 4);
  const Answer cone = impulses(kMass, -0.3 * kMass, -0.4 * kMass);
  Settler settler;
  Judge judge(problem, settler);
  const std::size_t as_cone = judge.judge(cone, FrictionModel::kCone);
  EXPECT_TRUE(judge.judgement(as_cone).errors.solved);
  EXPECT_FALSE(judge.findings().has(Evidence::kSolvedAnswer));
  const std::size_t as_pyramid = judge.judge(cone);
  EXPECT_NE(as_cone, as_pyramid);
  EXPECT_FALSE(judge.judgement(as_pyramid).errors.solved);
}

TEST(FrictionModelTest, TheSettingConeSaysIt) {
  EXPECT_EQ(friction_model("cone=true,method=nsgs"), FrictionModel::kCone);
  EXPECT_EQ(friction_model("method=nsgs,cone=true"), FrictionModel::kCone);
  EXPECT_EQ(friction_model("cone=false,method=nsgs"), FrictionModel::kPyramid);
  EXPECT_EQ(friction_model("second_cone=true"), FrictionModel::kPyramid);
  EXPECT_EQ(friction_model(""), FrictionModel::kPyramid);
}

}  // namespace
}  // namespace lcpbench
