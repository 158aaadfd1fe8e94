#include <algorithm>
#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include "generators/random.h"
#include "generators/sets.h"
#include "study/evaluation/fastest_contact.h"
#include "tests/native/auto_checks.h"
#include "tests/support/brick_wall.h"

// The problems of rest/*: where rest is a solution by construction, `auto` returns it, whatever it begins with.

namespace lcpbench::auto_rest_test {
namespace {

constexpr std::uint64_t kSeed = 72;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::int64_t kTrials = 20;  // sanitizers take ten times as long
#else
constexpr std::int64_t kTrials = 200;  ///< of each of the five sets
#endif
constexpr double kTimeLimit_s = 200;  // a net: under sanitizers one takes 20 s

/// The problem of the next step: the same contacts, each velocity changed by up to 1e-12 of itself.
Problem next_step(const Problem& problem, std::int64_t trial) {
  ContactProblem next = *problem.contact();
  DrawSequence draws({stream_id("auto_rest_test"), kSeed, static_cast<std::uint64_t>(trial)}, Purpose::kVelocity);
  for (double& speed : next.v) speed *= 1 + 1e-12 * static_cast<double>(draws.signed_grid()) * kGridStep;
  return {problem.name() + ", the next step", next};
}

/// What comes back, or where nothing does, what the impulses imply.
Vector velocity_after(const Problem& problem, const Answer& answer) {
  if (answer.velocity.size() > 0) return answer.velocity;
  return post_impact_velocity(*problem.contact(), answer.z);
}

/// Where no contact approaches, no impulse is needed: then a body that may hang between its contacts may as well fall.
bool approaches(const ContactProblem& contact) {
  for (Index c = 0; c < contact.nc(); ++c) {
    if (dot_column(contact.N, c, contact.v) + contact.offset(c) < 0) return true;
  }
  return false;
}

/// Answers that are not rest, to the last bit.
struct Tally {
  bool to_rounding = false;  ///< a contact may move by as much as the change of the velocities
  int failed = 0;
  int unsolved = 0;
  int moving = 0;      ///< those with a contact faster than 1e-9 of what gravity gives in the step
  double fastest = 0;  ///< contact after [m/s]
  std::string example;

  void add(const Problem& problem, const Answer& answer) {
    const bool solved = Evaluator(problem).errors(answer).solved;
    const bool rests = answer.velocity.size() == problem.contact()->ngc() && !answer.velocity.any();
    if (solved && rests) return;
    const double limit = to_rounding ? 1e-9 * 9.81 * 0.005 : 0;
    if (solved && fastest_contact(*problem.contact(), velocity_after(problem, answer)).m_per_s <= limit) return;
    ++failed;
    unsolved += solved ? 0 : 1;
    const double speed = fastest_contact(*problem.contact(), velocity_after(problem, answer)).m_per_s;
    moving += speed <= 1e-9 * 9.81 * 0.005 ? 0 : 1;
    if (example.empty() || !(speed <= fastest)) example = problem.name() + ": " + answer.detail;
    fastest = std::max(fastest, speed);
  }
};

TEST(AutoRestTest, RestsWhereItCan) {
  const auto solver = make_solver(parse_spec("auto"));
  for (const std::string& name : expand_sets("rest/*")) {
    const auto set = open_set(name);
    Tally cold, warm{.to_rounding = true};
    for (std::int64_t trial = 0; trial < kTrials; ++trial) {
      const Problem problem = set->generate(kSeed, trial);
      if (!approaches(*problem.contact())) continue;
      Answer answer;
      solver->load(problem);
      solver->solve({.time_limit_s = kTimeLimit_s}, answer);
      cold.add(problem, answer);
      const Vector start = answer.z;
      const Problem next = next_step(problem, trial);
      solver->update(next);
      solver->solve({.start = &start, .time_limit_s = kTimeLimit_s}, answer);
      warm.add(next, answer);
    }
    for (const auto& [what, tally] : {std::pair{"cold", cold}, std::pair{"warm", warm}}) {
      EXPECT_EQ(tally.failed, 0) << name << ", " << what << ": of " << kTrials << " answers this many are not rest, "
                                 << tally.moving << " move by more than rounding, " << tally.unsolved
                                 << " are unsolved; the fastest contact has " << tally.fastest
                                 << " m/s: " << tally.example;
    }
  }
}

// contact_lemke alone lets the cube turn about a corner, which satisfies all contacts, too. Where the fingers do not
// press, contacts with both could hold it by any impulses.
TEST(AutoRestTest, APinchedCubeDoesNotTurnAndOneBetweenTwoWallsFalls) {
  ContactProblem contact = testing::pinched_cube();
  for (const bool presses : {true, false}) {
    if (!presses) contact.v.tail<2>().setZero();
    const Problem problem("cube", contact);
    const Answer answer = testing::solve("auto", problem);
    testing::expect_solved(problem, answer);
    EXPECT_EQ(velocity_after(problem, answer), presses ? Vector(Vector::Zero(8)) : contact.v);
  }
}

// The bricks at both ends stand on the edges of those below, half of them in the air. A speed of rounding that turns
// them inward is held by contacts that carried nothing before.
TEST(AutoRestTest, BricksOnAnEdgeRestAfterRounding) {
  constexpr int kRows = 6, kColumns = 8;
  RigidScene wall = testing::frictional_brick_wall(kRows, kColumns, 0.5);
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      RigidBody& brick = wall.bodies[static_cast<std::size_t>(row * kColumns + column)];
      const bool hangs_left = row > 0 && row % 2 == 0 && column == 0;
      const bool hangs_right = row % 2 == 1 && column + 1 == kColumns;
      brick.linear_velocity = {0, 0, -0.05};
      brick.angular_velocity = {0, hangs_left ? 1e-14 : hangs_right ? -1e-14 : 0.0, 0};
    }
  }
  const Problem problem("wall", wall);
  const Answer answer = testing::solve("auto", problem);
  testing::expect_solved(problem, answer);
  ASSERT_GT(answer.velocity.size(), 0) << answer.detail;
  EXPECT_FALSE(answer.velocity.any()) << answer.velocity.transpose();
}

/// A cube of 1000 t on one of 1 kg, after one step's gravity. @param shift of the contact points [m]
RigidScene heavy_on_light(double shift) {
  RigidScene scene;
  for (int k = 0; k < 2; ++k) {
    RigidBody cube;
    cube.mass = k == 0 ? 1 : 1e6;
    cube.inertia = cube.mass / 6 * Eigen::Matrix3d::Identity();
    cube.position = {0, 0, k + 0.5};
    cube.linear_velocity = {0, 0, -9.81 * 0.005};
    scene.bodies.push_back(cube);
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.5, 0.5}) {
        RigidContact contact;
        contact.body_a = k;
        contact.body_b = k - 1;
        contact.point = {x + shift * (k + 1), y - shift, static_cast<double>(k)};
        contact.mu = 0.5;
        contact.edges = 4;
        scene.contacts.push_back(contact);
      }
    }
  }
  return scene;
}

// What the heavy cube's impulses miss by rounding moves the light one 1e6 times as fast.
TEST(AutoRestTest, ImpulsesOfTheLastStepCountOnlyIfTheyAreAsExactAsNewOnes) {
  const auto solver = make_solver(parse_spec("auto"));
  const Problem first("first", heavy_on_light(0));
  solver->load(first);
  Answer answer;
  solver->solve({}, answer);
  for (int step = 1; step <= 5; ++step) {
    const Problem next("step " + std::to_string(step), heavy_on_light(step * 1e-13));
    const Vector start = answer.z;
    solver->load(next);
    solver->solve({.start = &start}, answer);
    EXPECT_TRUE(Evaluator(next).errors(answer).solved);
    const Vector implied = post_impact_velocity(*next.contact(), answer.z);
    EXPECT_LE(fastest_contact(*next.contact(), implied).m_per_s, 1e-9 * 9.81 * 0.005) << next.name();
  }
}

TEST(AutoRestTest, MotionWithoutMomentumGoesOn) {
  ContactProblem contact;
  contact.v = Vector{{-1, 1}};
  contact.N = Matrix{{0, 4}, {0, 4}};
  contact.D = Matrix(2, 0);
  contact.edges = {0, 0};
  contact.mu = Vector::Zero(2);
  contact.inertia = DenseInertia{Matrix::Constant(2, 2, 40)};
  const Problem problem("massless motion", contact);
  const auto solver = make_solver(parse_spec("auto"));
  solver->load(problem);
  Answer answer;
  solver->solve({}, answer);
  EXPECT_EQ(answer.claim, Claim::kSolved);
  EXPECT_LE((velocity_after(problem, answer) - contact.v).cwiseAbs().maxCoeff(), 1e-12);  // rounding
}

TEST(AutoRestTest, SolvesWhereRestIsImpossible) {
  const auto solver = make_solver(parse_spec("auto"));
  for (const std::string& name : expand_sets("rest/*{margin=0.7}")) {
    const auto set = open_set(name);
    for (std::int64_t trial = 0; trial < kTrials / 10; ++trial) {
      const Problem problem = set->generate(kSeed, trial);
      Answer answer;
      solver->load(problem);
      solver->solve({.time_limit_s = kTimeLimit_s}, answer);
      EXPECT_TRUE(Evaluator(problem).errors(answer).solved) << problem.name() << ": " << answer.detail;
      EXPECT_TRUE(velocity_after(problem, answer).any()) << problem.name() << ": " << answer.detail;
    }
  }
}

}  // namespace
}  // namespace lcpbench::auto_rest_test
