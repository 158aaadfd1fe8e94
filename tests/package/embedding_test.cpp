// What a simulator relies on: the package's header and library, and nothing else of this project.

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <lcpbench/lcpbench.h>

#include "tests/support/allocation_counter.h"

namespace lcpbench {
namespace {

constexpr double kGravity = 9.81;
constexpr double kStep = 0.01;

/// A box of 1.2 kg on its four lower corners; z is up.
RigidScene box_on_ground(double mu) {
  RigidScene scene;
  scene.bodies.resize(1);
  scene.bodies[0].mass = 1.2;
  scene.bodies[0].inertia = Eigen::Vector3d(0.02, 0.02, 0.032).asDiagonal();
  scene.bodies[0].position = {0, 0, 0.1};
  for (const double x : {-0.2, 0.2}) {
    for (const double y : {-0.2, 0.2}) {
      scene.contacts.push_back({.point = {x, y, 0}, .mu = mu, .edges = mu > 0 ? 4 : 0});
    }
  }
  return scene;
}

Vector falling(double along = 0) {
  Vector v = Vector::Zero(6);
  v(0) = along;
  v(2) = -kGravity * kStep;
  return v;
}

std::string refusal(auto&& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was refused";
}

// Sliding along one of the axes: friction mu times the weight, against the motion.
TEST(EmbeddingTest, ImpulsesInWorldAxesAreWhatTheVelocitySays) {
  const RigidScene scene = box_on_ground(0.25);
  for (const int axis : {0, 1}) {
    ContactSolver solver("contact_lemke");
    solver.load(scene);
    Vector sliding = falling();
    sliding(axis) = 2;
    solver.set_velocity(sliding);
    ASSERT_EQ(solver.solve(), Claim::kSolved) << solver.answer().detail;
    Eigen::Vector3d total = Eigen::Vector3d::Zero();
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    for (Index contact = 0; contact < 4; ++contact) {
      const Eigen::Vector3d impulse = solver.impulse(contact);
      total += impulse;
      moment += (scene.contacts[static_cast<std::size_t>(contact)].point - scene.bodies[0].position).cross(impulse);
      EXPECT_NEAR(solver.friction_impulse(contact, axis), -0.25 * solver.normal_impulse(contact), 1e-15);
      EXPECT_NEAR(solver.friction_impulse(contact, 1 - axis), 0, 1e-15);
      EXPECT_NEAR(impulse.z(), solver.normal_impulse(contact), 1e-15);
    }
    EXPECT_NEAR(total(axis), -0.25 * 1.2 * kGravity * kStep, 1e-15);
    EXPECT_LE((sliding.head<3>() + total / 1.2 - solver.velocity().head<3>()).norm(), 1e-15);
    EXPECT_LE(
        (moment.array() / Eigen::Array3d(0.02, 0.02, 0.032) - solver.velocity().tail<3>().array()).matrix().norm(),
        1e-14);
  }
}

TEST(EmbeddingTest, EveryNativeSolverStopsTheBox) {
  const std::vector<NativeSolver> solvers = native_solvers();
  ASSERT_GE(solvers.size(), 9U);
  for (const NativeSolver& each : solvers) {
    SCOPED_TRACE(each.name);
    ContactSolver solver(each.name);
    solver.load(box_on_ground(0));
    for (int step = 0; step < 3; ++step) {
      solver.set_velocity(falling());
      ASSERT_EQ(solver.solve(), Claim::kSolved) << solver.answer().detail;
      // Interior points and relaxation stop short of rounding; a verdict would allow 1e-4.
      EXPECT_LE(solver.velocity().cwiseAbs().maxCoeff(), 1e-5 * kGravity * kStep);
    }
    RigidScene one_corner = box_on_ground(0.5);
    one_corner.contacts.resize(1);
    EXPECT_EQ(refusal([&] { solver.load(one_corner); }) == "nothing was refused", each.friction);
  }
}

TEST(EmbeddingTest, DenseInertiaAndItsBlocksGiveTheSameVelocity) {
  const ContactProblem blocks = contact_problem(box_on_ground(0.5));
  ContactProblem dense = blocks;
  dense.inertia = DenseInertia{dense_inertia(blocks.inertia)};
  dense.N = to_dense(blocks.N);
  dense.D = to_dense(blocks.D);
  ContactSolver of_blocks("contact_lemke"), of_dense("contact_lemke");
  of_blocks.load(blocks);
  of_dense.load(dense);
  for (ContactSolver* solver : {&of_blocks, &of_dense}) {
    solver->set_velocity(falling(0.02));
    ASSERT_EQ(solver->solve(), Claim::kSolved);
    EXPECT_LE(solver->velocity().norm(), 1e-15);
    EXPECT_THROW(solver->impulse(0), std::logic_error);  // no scene: no world axes
  }
}

TEST(EmbeddingTest, ReturnsTheVelocityOfTheSolverWhereItHasOne) {
  ContactSolver solver("active_set");
  solver.load(box_on_ground(0));
  solver.set_velocity(falling());
  ASSERT_EQ(solver.solve(), Claim::kSolved);
  ASSERT_EQ(solver.answer().velocity.size(), 6);
  EXPECT_EQ(solver.velocity(), solver.answer().velocity);
  solver.set_velocity(falling(1));
  EXPECT_EQ(solver.answer().velocity.size(), 0) << "not solved yet";
  ASSERT_EQ(solver.solve(), Claim::kSolved);
  RigidScene two = box_on_ground(0);
  two.bodies.push_back(two.bodies[0]);
  solver.update(two, {});
  EXPECT_EQ(solver.answer().velocity.size(), 0) << "that of one body";
  EXPECT_EQ(solver.answer().z, Vector::Zero(4));
}

TEST(EmbeddingTest, StepsStartFromTheLastImpulsesWhereTheSolverCan) {
  ContactSolver solver("active_set");
  ASSERT_TRUE(solver.capabilities().warm_start);
  solver.load(box_on_ground(0));
  const auto first_steps = [&] {
    solver.set_velocity(falling());
    EXPECT_EQ(solver.solve(), Claim::kSolved);
    return solver.velocity();
  };
  const Vector cold = first_steps();
  EXPECT_LE((first_steps() - cold).norm(), 1e-15);
  solver.load(box_on_ground(0));
  EXPECT_EQ(first_steps(), cold) << "a new load must not start from what was before";
}

TEST(EmbeddingTest, AStepAllocatesNothing) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "the allocator of this build cannot be replaced";
  for (const char* spec : {"contact_lemke{precision=double}", "active_set", "lemke"}) {
    SCOPED_TRACE(spec);
    ContactSolver solver(spec);
    ASSERT_TRUE(solver.capabilities().allocation_free);
    solver.load(box_on_ground(std::string(spec) == "active_set" ? 0 : 0.5));
    solver.solve();
    const Vector v = falling(0.03);
    Vector next(6);
    const bool reloads = std::string(spec) == "lemke";  // takes another v by loading all of the problem
    if (!reloads) solver.set_velocity(v);
    EXPECT_EQ(testing::count_allocations([&] {
                if (!reloads) solver.set_velocity(v);
                solver.solve();
                next = solver.velocity();
              }),
              0);
    ASSERT_EQ(solver.answer().claim, Claim::kSolved);
  }
}

// Solvers that know no compliance get an equivalent rigid problem, with more coordinates.
TEST(EmbeddingTest, ASolveOfSoftContactsAllocatesNothing) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "the allocator of this build cannot be replaced";
  struct Case {
    std::string spec;
    double offset = 0;
  };
  const std::vector<Case> cases{{"active_set"}, {"velocity_ipm"}, {"lemke"}, {"lemke", 1e-3}};
  for (const auto& [spec, offset] : cases) {
    SCOPED_TRACE(spec);
    RigidScene scene = box_on_ground(spec == "lemke" ? 0.5 : 0);
    scene.contacts[0].compliance_n = 0.1;
    if (offset > 0) scene.contacts[0].compliance_t = 0.1;
    scene.contacts[0].offset_t = {offset, 0};
    scene.bodies[0].linear_velocity = falling().head<3>();
    ContactSolver solver(spec);
    ASSERT_TRUE(solver.capabilities().allocation_free);
    solver.load(scene);
    solver.solve();
    Vector velocity = solver.velocity();
    EXPECT_EQ(testing::count_allocations([&] {
                for (int k = 0; k < 3; ++k) solver.solve();
                velocity = solver.velocity();
              }),
              0);
    ASSERT_EQ(solver.answer().claim, Claim::kSolved);
    EXPECT_LE(velocity.lpNorm<Eigen::Infinity>(), 1e-9 + 10 * offset);
  }
}

TEST(EmbeddingTest, WithoutAnAnswerTheVelocityIsTheGivenOne) {
  ContactSolver solver("contact_lemke");
  solver.load(box_on_ground(0.5));
  solver.set_velocity(falling());
  EXPECT_EQ(solver.solve(0.0), Claim::kTimeLimit);
  EXPECT_EQ(solver.velocity(), falling());
  EXPECT_EQ(solver.normal_impulse(3), 0);
  ASSERT_EQ(solver.solve(), Claim::kSolved);
  EXPECT_NE(solver.velocity(), falling());
  solver.set_velocity(falling(1));
  EXPECT_EQ(solver.velocity(), falling(1)) << "not solved yet";
  EXPECT_EQ(solver.normal_impulse(3), 0) << "not solved yet";
  EXPECT_NE(solver.answer().claim, Claim::kSolved) << "not solved yet";
}

TEST(EmbeddingTest, WhoeverIsCutShortHandsOutNoIterate) {
  for (const NativeSolver& each : native_solvers()) {
    SCOPED_TRACE(each.name);
    ContactSolver solver(each.name);
    solver.load(box_on_ground(0));
    solver.set_velocity(falling());
    if (solver.solve(0.0) == Claim::kSolved) continue;
    EXPECT_EQ(solver.velocity(), falling());
    for (Index contact = 0; contact < 4; ++contact) EXPECT_EQ(solver.impulse(contact), Eigen::Vector3d::Zero());
  }
  ContactSolver relaxation("psor{max_iterations=1}");
  relaxation.load(box_on_ground(0.5));
  relaxation.set_velocity(falling(1));
  ASSERT_EQ(relaxation.solve(), Claim::kIterationLimit);
  EXPECT_GT(relaxation.answer().z.norm(), 0) << "an iterate";
  EXPECT_EQ(relaxation.velocity(), falling(1));
  EXPECT_EQ(relaxation.normal_impulse(0), 0);
}

/// In a loop of few iterations per step, each step goes on from the last.
TEST(EmbeddingTest, StepsThatAreCutShortGetThere) {
  ContactSolver relaxation("psor{max_iterations=2}");
  relaxation.load(box_on_ground(0));
  int steps = 1;
  for (; steps < 10000; ++steps) {
    relaxation.set_velocity(falling());
    if (relaxation.solve() == Claim::kSolved) break;
  }
  EXPECT_GT(steps, 1);
  EXPECT_LT(steps, 10000);
}

TEST(EmbeddingTest, BadInputIsNamedAndLeavesTheSolverAsItWas) {
  ContactSolver solver("contact_lemke");
  solver.load(box_on_ground(0.5));
  solver.set_velocity(falling());
  const auto with = [](auto&& change) {
    RigidScene scene = box_on_ground(0.5);
    change(scene);
    return scene;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto of_scene = [&](auto&& change) { return refusal([&] { solver.load(with(change)); }); };
  EXPECT_EQ(of_scene([](RigidScene& s) { s.contacts[1].body_a = 1; }),
            "contacts[1].body_a is 1, expected one of 1 bodies, counted from 0");
  EXPECT_EQ(of_scene([](RigidScene& s) { s.contacts[2].body_b = -2; }),
            "contacts[2].body_b is -2, expected -1 (world) or one of 1 bodies, counted from 0");
  EXPECT_EQ(of_scene([](RigidScene& s) { s.contacts[2].body_b = 0; }), "contacts[2].body_b is body_a");
  EXPECT_EQ(of_scene([](RigidScene& s) { s.contacts[2] = {.body_a = -1, .body_b = 0}; }),
            "contacts[2].body_a is -1, the world, which has to be body_b: swap the bodies and turn the normal");
  EXPECT_EQ(of_scene([](RigidScene& s) { s.contacts[2].normal *= 2; }), "contacts[2].normal has length 2, expected 1");
  EXPECT_EQ(of_scene([](RigidScene& s) { s.contacts[2].tangent = s.contacts[2].normal; }),
            "contacts[2].tangent is not orthogonal to the normal: their scalar product is 1");
  EXPECT_EQ(of_scene([](RigidScene& s) { s.bodies[0].mass = 1e-320; }),
            "bodies[0].mass is 1e-320; its inverse overflows");
  EXPECT_EQ(of_scene([](RigidScene& s) { s.contacts[0].edges = 8; }), "contacts[0].edges is 8, expected 0 or 4");
  EXPECT_EQ(of_scene([&](RigidScene& s) { s.contacts[0].mu = nan; }),
            "contacts[0].mu is nan, expected a finite number >= 0");
  EXPECT_EQ(of_scene([&](RigidScene& s) { s.contacts[1].offset_t.y() = nan; }),
            "contacts[1].offset_t holds NaN or infinity");
  EXPECT_EQ(of_scene([](RigidScene& s) { s.contacts[3].edges = 0; }),
            "contacts[3].mu would be ignored: the contact has no edges");
  EXPECT_EQ(of_scene([](RigidScene& s) { s.contacts[3] = {.compliance_t = 0.1}; }),
            "contacts[3].compliance_t would be ignored: the contact has no edges");
  EXPECT_EQ(of_scene([&](RigidScene& s) { s.contacts[2].b = nan; }), "contacts[2].b is nan, expected a finite number");
  EXPECT_EQ(of_scene([](RigidScene& s) { s.bodies[0].mass = 0; }), "bodies[0].mass is 0, expected a finite number > 0");
  EXPECT_EQ(of_scene([&](RigidScene& s) { s.bodies[0].inertia(0, 1) = nan; }),
            "bodies[0].inertia holds NaN or infinity");
  EXPECT_EQ(of_scene([](RigidScene& s) { s.bodies[0].inertia(0, 1) = 1e-3; }), "bodies[0].inertia is not symmetric");
  EXPECT_EQ(of_scene([](RigidScene& s) { s.bodies[0].inertia(2, 2) = -1; }),
            "bodies[0].inertia is not positive definite");
  EXPECT_EQ(of_scene([&](RigidScene& s) { s.contacts[0].point.x() = nan; }), "contacts[0].point holds NaN or infinity");
  EXPECT_EQ(of_scene([&](RigidScene& s) { s.bodies[0].angular_velocity.y() = nan; }),
            "bodies[0].angular_velocity holds NaN or infinity");

  const auto of_contacts = [&](auto&& change) {
    ContactProblem contacts = contact_problem(box_on_ground(0.5));
    change(contacts);
    return refusal([&] { solver.load(contacts); });
  };
  EXPECT_EQ(of_contacts([](ContactProblem& c) { c.v.resize(5); }), "N is 6 x 4, expected 5 x 4");
  EXPECT_EQ(of_contacts([](ContactProblem& c) { c.edges[1] = 3; }), "edges[1] is 3, expected an even number >= 0");
  EXPECT_EQ(of_contacts([](ContactProblem& c) { c.edges[1] = 2; }), "D is 6 x 16, expected 6 x 14");
  EXPECT_EQ(of_contacts([](ContactProblem& c) { c.mu.resize(3); }), "mu has 3 entries, expected 4");
  const auto of_smooth = [&](auto&& change) {
    ContactProblem contacts = contact_problem(box_on_ground(0));
    change(contacts);
    return refusal([&] { solver.load(contacts); });
  };
  EXPECT_EQ(of_smooth([](ContactProblem& c) { c.compliance_t = Vector::Unit(4, 2); }),
            "compliance_t[2] would be ignored: the contact has no edges");
  EXPECT_EQ(of_smooth([](ContactProblem& c) { c.offset_t = Vector::Unit(8, 5); }),
            "offset_t[5] would be ignored: the contact has no edges");
  EXPECT_EQ(of_contacts([](ContactProblem& c) { c.inertia = DenseInertia{Matrix::Identity(5, 5)}; }),
            "inertia.G is 5 x 5, expected 6 x 6");
  EXPECT_EQ(of_contacts([](ContactProblem& c) { c.inertia = BlockInertia{{Matrix::Identity(3, 3)}}; }),
            "inertia.blocks together is 3 x 3, expected 6 x 6");

  EXPECT_EQ(refusal([&] { solver.set_velocity(Vector::Zero(7)); }), "v has 7 entries, expected 6");
  EXPECT_EQ(refusal([&] { solver.set_velocity(Vector::Constant(6, nan)); }), "v holds NaN or infinity");
  EXPECT_THROW(solver.normal_impulse(4), std::out_of_range);
  EXPECT_THROW(solver.friction_impulse(0, 2), std::out_of_range);

  ASSERT_EQ(solver.solve(), Claim::kSolved) << "after all this";
  EXPECT_LE(solver.velocity().norm(), 1e-15);
}

/// An arm of 2 kg m^2 that runs into its stop, which is 0.2 rad/s away, against the dry friction of its bearing.
ContactProblem arm() {
  ContactProblem arm;
  arm.v = Vector{{-1}};
  arm.N = arm.D = Matrix(1, 0);
  arm.inertia = BlockInertia{{Matrix{{2}}}};
  arm.rows = {.R = Matrix{{1, 1}}, .bounds = LcpBounds::nonnegative(2), .b = Vector{{0.2, 0}}, .is_angle = {1, 1}};
  arm.rows.bounds.lower(1) = -0.5;
  arm.rows.bounds.upper(1) = 0.5;
  return arm;
}

TEST(EmbeddingTest, BoundedRowsStandBesideContacts) {
  for (const char* spec : {"auto", "contact_lemke"}) {
    SCOPED_TRACE(spec);
    ContactSolver solver(spec);
    solver.load(arm());
    EXPECT_EQ(solver.row_impulse(0), 0);
    for (int step = 0; step < 2; ++step) {
      ASSERT_EQ(solver.solve(), Claim::kSolved) << solver.answer().detail;
      EXPECT_NEAR(solver.row_impulse(0), 1.1, 1e-12);
      EXPECT_NEAR(solver.row_impulse(1), 0.5, 1e-12);
      EXPECT_NEAR(solver.velocity()(0), -0.2, 1e-12);
      solver.update(arm(), {});
    }
    solver.set_velocity(Vector{{0.1}});  // which the friction stops
    ASSERT_EQ(solver.solve(), Claim::kSolved) << solver.answer().detail;
    EXPECT_NEAR(solver.velocity()(0), 0, 1e-12);
    EXPECT_NEAR(solver.row_impulse(1), -0.2, 1e-12);
    EXPECT_THROW(solver.row_impulse(2), std::out_of_range);
  }
}

TEST(EmbeddingTest, WrongBoundedRowsAreRefused) {
  ContactSolver solver("auto");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto of = [&](auto&& change) {
    ContactProblem changed = arm();
    change(changed.rows);
    return refusal([&] { solver.load(changed); });
  };
  EXPECT_EQ(of([](BoundedRows& rows) { rows.R = Matrix(2, 2); }), "rows.R is 2 x 2, expected 1 x 2");
  EXPECT_EQ(of([](BoundedRows& rows) { rows = {.R = Matrix(1, 2)}; }), "rows.R is 1 x 2, expected 1 x 0");
  EXPECT_EQ(of([](BoundedRows& rows) { rows.bounds.upper.resize(1); }), "rows.upper has 1 entries, expected 2");
  EXPECT_EQ(of([](BoundedRows& rows) { rows.bounds.mu.resize(1); }), "rows.mu has 1 entries, expected 2");
  EXPECT_EQ(of([](BoundedRows& rows) { rows.bounds.friction_of.clear(); }),
            "rows.friction_of has 0 entries, expected 2");
  EXPECT_EQ(of([](BoundedRows& rows) { rows.b.resize(1); }), "rows.b has 1 entries, expected 2");
  EXPECT_EQ(of([](BoundedRows& rows) { rows.compliance = Vector{{0, -1}}; }),
            "rows.compliance[1] is -1, expected a finite number >= 0");
  EXPECT_EQ(of([](BoundedRows& rows) { rows.is_angle.clear(); }), "rows.is_angle has 0 entries, expected 2");
  EXPECT_EQ(of([](BoundedRows& rows) { rows.names = {"stop"}; }), "rows.names has 1 entries, expected 2");
  EXPECT_EQ(of([&](BoundedRows& rows) { rows.bounds.lower(0) = nan; }), "rows.lower[0] is nan, expected at most 0");
  EXPECT_EQ(of([](BoundedRows& rows) { rows.bounds.upper(1) = -1; }), "rows.upper[1] is -1, expected at least 0");
  EXPECT_EQ(of([](BoundedRows& rows) { rows.bounds.upper(0) = 0; }),
            "rows.lower[0] and the upper bound are 0: leave the row out");
  EXPECT_EQ(of([](BoundedRows& rows) { rows.bounds.friction_of[1] = 2; }),
            "rows.friction_of[1] is 2, expected a row with the lower bound 0 of its own");
  EXPECT_EQ(of([](BoundedRows& rows) { rows.bounds.friction_of[0] = 1; }),
            "rows.friction_of[0] is 1, expected a row with the lower bound 0 of its own");
  EXPECT_EQ(of([](BoundedRows& rows) { rows.bounds.friction_of[1] = 0; }),
            "rows.lower[1] or the upper bound is given, but friction_of bounds this row");
  EXPECT_EQ(of([&](BoundedRows& rows) { rows.bounds.friction_of[1] = 0, rows.bounds.mu(1) = nan; }),
            "rows.mu[1] is nan, expected a finite number >= 0");
  EXPECT_EQ(of([&](BoundedRows& rows) { std::get<Matrix>(rows.R)(0, 1) = nan; }),
            "auto: the data hold NaN or infinity");
}

TEST(EmbeddingTest, ConstructionRefusesWhatItDoesNotKnow) {
  EXPECT_NE(refusal([] { ContactSolver("simplex"); }).find("unknown solver 'simplex'"), std::string::npos);
  EXPECT_NE(refusal([] { ContactSolver("contact_lemke{precision=half}"); }).find("precision"), std::string::npos);
  EigenLayout wider;
  wider.alignment *= 2;
  EXPECT_NE(refusal([&] { ContactSolver("contact_lemke", wider); }).find("same -m options"), std::string::npos);
  EigenLayout sanitized;
  sanitized.plain_malloc = !sanitized.plain_malloc;
  EXPECT_NE(refusal([&] { ContactSolver("contact_lemke", sanitized); }).find("-fsanitize"), std::string::npos);
  EigenLayout rows;
  rows.row_major = !rows.row_major;
  EXPECT_NE(refusal([&] { ContactSolver("contact_lemke", rows); }).find("row-major"), std::string::npos);
  ContactSolver empty("contact_lemke");
  EXPECT_THROW(empty.solve(), std::logic_error);
  EXPECT_THROW(empty.set_velocity(Vector::Zero(6)), std::logic_error);
}

TEST(EmbeddingTest, NoBodiesAndNoContactsAreFine) {
  ContactSolver solver("contact_lemke");
  solver.load(RigidScene{});
  EXPECT_EQ(solver.solve(), Claim::kSolved);
  RigidScene free = box_on_ground(0.5);
  free.contacts.clear();
  solver.load(free);
  solver.set_velocity(falling(1));
  EXPECT_EQ(solver.solve(), Claim::kSolved);
  EXPECT_EQ(solver.velocity(), falling(1));
}

// The contacts come in another order, one is gone, and the box is elsewhere: ids tell which is which.
TEST(EmbeddingTest, UpdatesFollowContactsByTheirIds) {
  RigidScene scene = box_on_ground(0.5);
  scene.bodies[0].linear_velocity.z() = -kGravity * kStep;
  ContactSolver solver("auto");
  solver.update(scene, std::vector<ContactId>{1, 2, 3, 4});  // the first one is a load
  ASSERT_EQ(solver.solve(), Claim::kSolved);
  std::swap(scene.contacts[0], scene.contacts[3]);
  scene.bodies[0].position.x() += 0.01;
  solver.update(scene, std::vector<ContactId>{4, 2, 3, 1});
  EXPECT_EQ(solver.normal_impulse(0), 0);  // there is no answer yet
  ASSERT_EQ(solver.solve(), Claim::kSolved);
  EXPECT_LE(solver.velocity().lpNorm<Eigen::Infinity>(), 1e-12);
  scene.contacts.pop_back();
  solver.update(scene, std::vector<ContactId>{4, 2, 3});
  ASSERT_EQ(solver.solve(), Claim::kSolved);
  double carried = 0;
  for (Index c = 0; c < 3; ++c) carried += solver.normal_impulse(c);
  EXPECT_NEAR(carried, 1.2 * kGravity * kStep, 1e-12);

  const auto too_few = [&] { solver.update(scene, std::vector<ContactId>{4, 2}); };
  EXPECT_EQ(refusal(too_few), "2 ids for 3 contacts");
  EXPECT_NEAR(solver.normal_impulse(0) + solver.normal_impulse(1) + solver.normal_impulse(2), carried, 0);
}

}  // namespace
}  // namespace lcpbench
