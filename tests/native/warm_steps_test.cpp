// Steps whose contacts change, solved by `auto` from the last answer.
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/warm_start.h"
#include "generators/scenes/scenes.h"
#include "tests/native/auto_checks.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/box_stacks.h"

namespace lcpbench::warm_steps_test {
namespace {

using testing::auto_solver;
using testing::box_stacks;
using testing::BoxStacks;
using testing::disturbance;
using testing::expect_verified;
using testing::falling_velocity;
using testing::solve;
using testing::velocity_difference;

/// The stack in this step, with contact points, normals and masses of its own.
RigidScene stack_in_step(const BoxStacks& shape, int step) {
  RigidScene scene = box_stacks(shape);
  const Vector v = falling_velocity(shape, step);
  long number = 100L * step;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    scene.bodies[b].linear_velocity = v.segment<3>(6 * static_cast<Index>(b));
    scene.bodies[b].angular_velocity = v.segment<3>(6 * static_cast<Index>(b) + 3);
    scene.bodies[b].mass = 1 + 0.01 * disturbance(++number);
  }
  for (RigidContact& contact : scene.contacts) {
    contact.point.x() += 0.01 * disturbance(++number);
    contact.normal = Eigen::Vector3d(0.01 * disturbance(++number), 0, 1).normalized();
    contact.tangent = contact.normal.cross(Eigen::Vector3d::UnitX()).normalized();
  }
  return scene;
}

Problem problem_of(const RigidScene& scene) { return {"stack", scene}; }

bool holds(const Answer& answer) { return answer.detail.find("sticking_contacts") != std::string::npos; }

/// `auto` after a step with this problem, and impulses at all contacts that hold, as those of later steps are.
std::unique_ptr<Solver> after(const Problem& problem, Vector& start) {
  start = solve("friction_ipm", problem).z;
  auto solver = auto_solver();
  solver->load(problem);
  solve(*solver);
  return solver;
}

enum class Form { kBodies, kOneBlock, kDense };

/// As free bodies, or as a robot has it: G in one block, or whole.
Problem in_form(const RigidScene& scene, Form form) {
  ContactProblem contact = contact_problem(scene);
  const Matrix G = dense_inertia(contact.inertia);
  if (form == Form::kOneBlock) contact.inertia = BlockInertia{{G}};
  if (form == Form::kDense) contact.inertia = DenseInertia{G};
  return {"stack", std::move(contact)};
}

// Other contacts in each step, and one factorization finds what holds them.
TEST(WarmStepsTest, ARestingStackIsStickingByOneFactorization) {
  for (const Form form : {Form::kBodies, Form::kOneBlock, Form::kDense}) {
    for (const int height : {4, 8}) {
      const BoxStacks shape{.height = height, .fresh = 0.2};
      Vector start;
      const auto solver = after(in_form(stack_in_step(shape, 0), form), start);
      for (int step = 1; step <= 5; ++step) {
        const std::string what = std::to_string(height) + " cubes, step " + std::to_string(step);
        const Problem problem = in_form(stack_in_step(shape, step), form);
        solver->update(problem);
        const Answer answer = solve(*solver, {.start = &start});
        expect_verified(problem, answer, what);
        EXPECT_TRUE(holds(answer)) << what << ": " << answer.detail;
        EXPECT_EQ(answer.counters.factorizations, 1) << what;
        EXPECT_LE(velocity_difference(problem, answer, solve(problem)), 1e-8) << what;
        const Vector u = post_impact_velocity(*problem.contact(), answer.z);
        EXPECT_TRUE(answer.velocity.size() == 0 || (answer.velocity - u).lpNorm<Eigen::Infinity>() <= 1e-10) << what;
        start = answer.z;
      }
    }
  }
}

// A cube more: its contacts have no impulse in the start, and are held because they approach.
TEST(WarmStepsTest, NewContactsAreStickingWhenTheyApproach) {
  const BoxStacks low{.height = 7, .fresh = 0.2};
  const BoxStacks high{.height = 8, .fresh = 0.2};
  const Problem before = problem_of(stack_in_step(low, 0));
  const Problem now = problem_of(stack_in_step(high, 1));
  std::vector<ContactId> ids(static_cast<std::size_t>(now.contact()->nc()));
  for (std::size_t c = 0; c < ids.size(); ++c) ids[c] = 1000 - c;
  const std::vector<ContactId> ids_before(ids.begin(), ids.begin() + before.contact()->nc());
  Vector last, start;
  const auto solver = after(before, last);
  ContactMatch match;
  match.find(ids_before, ids);
  EXPECT_EQ(match.matched(), before.contact()->nc());
  matched_start(last, contact_layout(*before.contact()), match, contact_layout(*now.contact()), start);
  solver->update(now);
  const Answer answer = solve(*solver, {.start = &start});
  expect_verified(now, answer, "a cube more");
  EXPECT_TRUE(holds(answer)) << answer.detail;
  EXPECT_GT(answer.counters.factorizations, 1);
}

// The guess is wrong in every way that it can be: the answer is as right as without it.
TEST(WarmStepsTest, AWrongGuessChangesNoAnswer) {
  const BoxStacks shape{.height = 6, .fresh = 0.2};
  Vector start;
  const auto solver = after(problem_of(stack_in_step(shape, 0)), start);

  BoxStacks sliding = shape;
  sliding.slide = 2;  // more than friction stops in a step
  RigidScene flying = stack_in_step(shape, 1);
  for (RigidBody& body : flying.bodies) body.linear_velocity.z() += 1;
  RigidScene half = stack_in_step(shape, 1);
  for (std::size_t b = 3; b < half.bodies.size(); ++b) half.bodies[b].linear_velocity.z() += 1;
  RigidScene slippery = stack_in_step(shape, 1);
  for (RigidBody& body : slippery.bodies) body.linear_velocity.x() += 0.02;
  for (RigidContact& contact : slippery.contacts) contact.mu = 0.01;
  RigidScene tipping = stack_in_step(shape, 1);
  for (RigidBody& body : tipping.bodies) body.angular_velocity.y() += 5;
  int wrong = 0;
  const std::vector<RigidScene> scenes{stack_in_step(sliding, 1), flying, half, slippery, tipping};
  for (std::size_t k = 0; k < scenes.size(); ++k) {
    const Problem problem = problem_of(scenes[k]);
    solver->update(problem);
    const Answer answer = solve(*solver, {.start = &start});
    const Answer expected = solve(problem);
    testing::expect_solved(problem, answer, kSolvedVelocityResidual, std::to_string(k));
    EXPECT_LE(velocity_difference(problem, answer, expected), 1e-7) << k << ": " << answer.detail;
    wrong += holds(answer) ? 0 : 1;
  }
  EXPECT_GE(wrong, 4);
}

TEST(WarmStepsTest, NoStartIsTrusted) {
  const Problem problem = problem_of(stack_in_step({.height = 6, .fresh = 0.2}, 1));
  Vector last;
  const auto solver = after(problem_of(stack_in_step({.height = 6, .fresh = 0.2}, 0)), last);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double huge = std::numeric_limits<double>::max();
  std::vector<Vector> starts{Vector::Zero(last.size()),
                             Vector::Ones(last.size()),
                             Vector::Constant(last.size(), nan),
                             Vector::Constant(last.size(), huge),
                             Vector::Constant(last.size(), -1),
                             Vector::Ones(last.size() - 1),
                             1e-300 * last,
                             Vector()};
  Vector unpaired = last;  // no lambda, friction far outside of the pyramids
  unpaired.segment(problem.contact()->nc(), cols(problem.contact()->D)).setConstant(1e3);
  unpaired.segment(problem.contact()->nc(), 2).setZero();
  starts.push_back(unpaired);
  for (std::size_t k = 0; k < starts.size(); ++k) {
    solver->update(problem);
    expect_verified(problem, solve(*solver, {.start = &starts[k]}), "start " + std::to_string(k));
  }
}

// The same contacts at other velocities, and contacts again that were met: nothing is allocated any more.
TEST(WarmStepsTest, SolvesOfStickingContactsAllocateNothing) {
  const BoxStacks shape{.height = 8, .fresh = 0.2};
  Vector start;
  const auto solver = after(problem_of(stack_in_step(shape, 0)), start);
  solver->update(problem_of(stack_in_step(shape, 1)));
  Answer answer;
  solver->solve({.start = &start}, answer);
  ASSERT_TRUE(holds(answer)) << answer.detail;
  for (int step = 2; step <= 4; ++step) {
    start = answer.z;
    const Vector v = falling_velocity(shape, step);
    EXPECT_EQ(testing::count_allocations([&] { solver->update(v); }), 0) << step;
    EXPECT_EQ(testing::count_allocations([&] { solver->solve({.start = &start}, answer); }), 0) << step;
    EXPECT_TRUE(holds(answer)) << answer.detail;
  }
}

/// The steps of a collected scene one after the other, each from the answer to the last: what cold solves have to be.
void expect_as_right_as_cold(const CollectedScene& scene) {
  const auto file = open_collected(scene);
  const auto solver = auto_solver();
  std::vector<ContactId> ids, last_ids;
  ContactLayout layout, last_layout;
  ContactMatch match;
  Answer answer;
  Vector start;
  for (std::size_t k = 0; k < file->count(); ++k) {
    const SceneStep step = file->read(k);
    const ContactProblem& contact = *step.problem.contact();
    const std::string what = step.problem.name() + " step " + std::to_string(step.step);
    ids.clear();
    for (const std::string& id : step.contact_ids) ids.push_back(contact_id(id));
    layout = contact_layout(contact);
    start.setZero(layout.size());
    match.find(last_ids, ids);
    const bool has_start = static_cast<Index>(ids.size()) == layout.nc && k > 0;
    if (has_start) matched_start(answer.z, last_layout, match, layout, start);
    solver->update(step.problem);
    solver->solve({.start = &start, .time_limit_s = 60}, answer);
    testing::expect_solved(step.problem, answer, kSolvedVelocityResidual, what);
    last_ids = ids;
    last_layout = layout;
    testing::expect_rest_where_it_is_a_solution(contact, answer, what);
  }
}

TEST(WarmStepsTest, CollectedStepsAreVerifiedAndRestWhereTheyCan) {
  int scenes = 0;
  for (const CollectedScene& scene : collected_scenes()) {
    for (const std::string_view family : {"card-house", "stack", "humanoid-pushed", "quadruped-standing"}) {
      if (!scene.name.starts_with("scene/" + std::string(family) + "/")) continue;
      expect_as_right_as_cold(scene);
      ++scenes;
    }
  }
  EXPECT_GE(scenes, 8);
}

}  // namespace
}  // namespace lcpbench::warm_steps_test
