// Every stepper against closed forms: blocks on slopes, a ball that bounces, a ball in a bowl as a pendulum, the forces
// in a stack that rests, momentum.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/stepper.h"

namespace lcpbench::steppers_test {
namespace {

using Eigen::Vector3d;

constexpr double kGravity = 9.81;
constexpr double kStep = 0.005;

struct Shape {
  Vector3d half = Vector3d::Constant(0.5);
  bool ball = false;
};

/// Boxes and balls on a floor whose normal is z; the contacts are the lowest corners, or a ball's lowest point. Or a
/// ball in a bowl around the origin, in the plane of x and z.
class Simulation {
 public:
  explicit Simulation(const std::string& spec) : stepper_(make_stepper(parse_spec(spec))) {}

  RigidScene scene;
  std::vector<Shape> shapes;
  std::vector<Eigen::Quaterniond> turns;
  Vector3d gravity{0, 0, -kGravity};
  double mu = 0.5;
  double restitution = 0;
  double h = kStep;
  double bowl = 0;  ///< its radius [m]; 0: the floor is flat

  void add(const Vector3d& at, double mass, const Shape& shape = {}) {
    RigidBody body;
    body.mass = mass;
    const Vector3d s = shape.half.cwiseAbs2();
    body.inertia = mass / 3 * Vector3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y()).asDiagonal().toDenseMatrix();
    if (shape.ball) body.inertia = 0.4 * mass * s.x() * Eigen::Matrix3d::Identity();
    body.position = at;
    scene.bodies.push_back(body);
    shapes.push_back(shape);
    turns.push_back(Eigen::Quaterniond::Identity());
  }

  StepAnswer step() {
    StepAnswer answer;
    stepper_->step(problem(), answer);
    if (answer.velocity.size() == 0) throw std::runtime_error(answer.detail);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      RigidBody& body = scene.bodies[i];
      Eigen::Vector<double, 6> way = h * answer.velocity.segment<6>(static_cast<Index>(6 * i));
      if (answer.correction.size() > 0) way += answer.correction.segment<6>(static_cast<Index>(6 * i));
      body.linear_velocity = answer.velocity.segment<3>(static_cast<Index>(6 * i));
      body.angular_velocity = answer.velocity.segment<3>(static_cast<Index>(6 * i) + 3);
      body.position += way.head<3>();
      const Vector3d turn = way.tail<3>();
      if (turn.norm() > 0) turns[i] = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * turns[i];
    }
    return answer;
  }

  StepProblem problem() const {
    StepProblem step;
    RigidScene found = scene;
    step.force_change = Vector::Zero(static_cast<Index>(6 * scene.bodies.size()));
    for (std::size_t i = 0; i < found.bodies.size(); ++i) {
      step.force_change.segment<3>(static_cast<Index>(6 * i)) = h * gravity;
      found.bodies[i].linear_velocity += h * gravity;
      floor_contacts(i, found, step);
    }
    step.contacts = found;
    step.h = h;
    return step;
  }

 private:
  /// On the floor, or on the body below of a tower.
  void floor_contacts(std::size_t i, RigidScene& found, StepProblem& step) const {
    const bool tower = i > 0 && !shapes[i].ball;
    const double floor = tower ? scene.bodies[i - 1].position.z() + shapes[i - 1].half.z() : 0;
    const Vector3d& half = shapes[i].half;
    for (int corner = 0; corner < (shapes[i].ball ? 1 : 4); ++corner) {
      RigidContact contact;
      const Vector3d local(corner % 2 == 0 ? half.x() : -half.x(), corner < 2 ? half.y() : -half.y(), -half.z());
      if (bowl > 0) {
        contact.normal = -scene.bodies[i].position.normalized();
        contact.tangent = Vector3d::UnitY();
      }
      const Vector3d arm = shapes[i].ball ? Vector3d(-half.x() * contact.normal) : Vector3d(turns[i] * local);
      contact.body_a = static_cast<int>(i);
      contact.body_b = tower ? static_cast<int>(i) - 1 : RigidContact::kWorld;
      contact.point = scene.bodies[i].position + arm;
      contact.mu = mu;
      contact.edges = mu > 0 ? 4 : 0;
      const double gap = bowl > 0 ? bowl - contact.point.norm() : contact.point.z() - floor;
      if (gap > 0.05) continue;
      const RigidBody& body = scene.bodies[i];
      const double approach = contact.normal.dot(body.linear_velocity + body.angular_velocity.cross(arm));
      contact.b = gap > 0 ? gap / h : approach < -0.2 ? restitution * approach : 0;
      found.contacts.push_back(contact);
      step.gaps.push_back(gap);
      step.ids.push_back(10 * i + static_cast<std::size_t>(corner));
    }
  }

  std::unique_ptr<Stepper> stepper_;
};

class EveryStepper : public ::testing::TestWithParam<std::string> {};
std::string case_name(const ::testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(All, EveryStepper,
                         ::testing::Values("exact", "exact{solver=cone_ipm{cone=true}}", "convex", "pgs{iterations=30}",
                                           "pgs{substeps=10,iterations=3}", "sequential_impulses{iterations=30}",
                                           "soft_step", "xpbd", "admm", "apgd"),
                         case_name);

TEST(Steppers, SpecsAreCanonicalAndMistakesAreNamed) {
  EXPECT_EQ(canonical_stepper_spec(parse_spec("exact{solver=lemke{engine=dense},warm=true}")).text(),
            "exact{solver=lemke{engine=dense}}");
  EXPECT_EQ(canonical_stepper_spec(parse_spec("exact{solver=lemke{engine=kernel}}")).text(), "exact{solver=lemke}");
  EXPECT_EQ(canonical_stepper_spec(parse_spec("pgs{iterations=10}")).text(), "pgs");
  EXPECT_EQ(stepper_label(parse_spec("exact{solver=psor}")), "psor");
  EXPECT_EQ(stepper_label(parse_spec("exact")), "auto");
  EXPECT_EQ(stepper_label(parse_spec("exact{warm=false}")), "exact{warm=false}");
  EXPECT_THROW(make_stepper(parse_spec("pgs{substeps=0}")), InputError);
  EXPECT_THROW(make_stepper(parse_spec("exact{solver=lemk}")), InputError);
  try {
    make_stepper(parse_spec("soft_stop"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean 'soft_step'?"), std::string::npos) << error.what();
  }
}

TEST_P(EveryStepper, ABlockSlidesDownASlopeAsCoulombSays) {
  Simulation block(GetParam());
  block.add({0, 0, 0.1}, 2, {{0.5, 0.5, 0.1}});
  const double angle = std::atan(0.8);
  block.gravity = kGravity * Vector3d(std::sin(angle), 0, -std::cos(angle));
  for (int i = 0; i < 200; ++i) block.step();
  const double wanted = kGravity * (std::sin(angle) - 0.5 * std::cos(angle)) * 200 * kStep;
  // xpbd counts what lifts a body out of the ground as a force that presses it there.
  const double tolerance = GetParam() == "xpbd" ? 0.06 : 0.02;
  EXPECT_NEAR(block.scene.bodies[0].linear_velocity.x(), wanted, tolerance * wanted);
}

TEST_P(EveryStepper, ABlockBelowTheFrictionAngleStays) {
  Simulation block(GetParam());
  block.add({0, 0, 0.1}, 2, {{0.5, 0.5, 0.1}});
  const double angle = std::atan(0.45);
  block.gravity = kGravity * Vector3d(std::sin(angle), 0, -std::cos(angle));
  for (int i = 0; i < 200; ++i) block.step();
  EXPECT_LT(block.scene.bodies[0].position.head<2>().norm(), 0.005);
}

TEST_P(EveryStepper, ABallBouncesWithItsRestitution) {
  for (const double gravity : {kGravity, 0.0}) {  // without, nothing presses it on the floor before it bounces off
    for (const double speed : {2.0, 0.25}) {      // a slow ball comes within the slop in the first substeps
      Simulation ball(GetParam());
      ball.gravity = {0, 0, -gravity};
      ball.restitution = 0.5;
      ball.add({0, 0, speed > 1 ? 0.4999 : 0.5}, 1, {Vector3d::Constant(0.5), true});
      ball.scene.bodies[0].linear_velocity = {0, 0, -speed};
      ball.step();
      EXPECT_NEAR(ball.scene.bodies[0].linear_velocity.z(), speed / 2, 0.06) << gravity << " " << speed;
    }
  }
}

/// Of a step with substeps, all of them together close what was open before it.
TEST_P(EveryStepper, ABallReachesTheFloorWithinTheStep) {
  Simulation ball(GetParam());
  ball.gravity.setZero();
  ball.add({0, 0, 0.51}, 1, {Vector3d::Constant(0.5), true});
  ball.scene.bodies[0].linear_velocity = {0, 0, -0.02 / kStep};
  ball.step();
  EXPECT_NEAR(ball.scene.bodies[0].position.z(), 0.5, 1e-3);
}

TEST(Steppers, SequentialImpulsesLeaveFiveMillimetresOfDepth) {
  Simulation ball("sequential_impulses{iterations=30}");
  ball.add({0, 0, 0.48}, 1, {Vector3d::Constant(0.5), true});
  for (int i = 0; i < 200; ++i) ball.step();
  EXPECT_NEAR(ball.scene.bodies[0].position.z(), 0.495, 1e-3);
}

/// A ball in a bowl is a pendulum as long as its centre is from the bowl's: without friction it glides, with friction
/// it rolls, which makes 7/5 of its inertia. From its outermost point to the lowest it takes a quarter of the period.
TEST_P(EveryStepper, ABallInABowlSwingsAsAPendulum) {
  for (const double mu : {0.0, 0.5}) {
    constexpr double kRadius = 0.25;
    constexpr double kLength = 1;
    constexpr double kAngle = 0.3;
    Simulation ball(GetParam());
    ball.h = kStep / 4;
    ball.bowl = kLength + kRadius;
    ball.mu = mu;
    ball.add(kLength * Vector3d(-std::sin(kAngle), 0, -std::cos(kAngle)), 3, {Vector3d::Constant(kRadius), true});
    const RigidBody& body = ball.scene.bodies[0];
    double time = 0;
    for (; body.position.x() < 0 && time < 2; time += ball.h) ball.step();
    time -= body.position.x() / body.linear_velocity.x();
    const double inertia = mu > 0 ? 1.4 : 1;
    const double quarter = std::acos(0) * std::sqrt(inertia * kLength / kGravity) * (1 + kAngle * kAngle / 16);
    EXPECT_NEAR(time, quarter, 0.01 * quarter) << mu;
    const double speed = std::sqrt(2 * kGravity * kLength * (1 - std::cos(kAngle)) / inertia);
    EXPECT_NEAR(body.linear_velocity.x(), speed, 0.01 * speed) << mu;
  }
}

TEST_P(EveryStepper, AStackRestsAndEachFaceBearsTheWeightAbove) {
  Simulation stack(GetParam());
  for (int i = 0; i < 5; ++i) stack.add({0, 0, 0.5 + i}, 10);
  // Penetration that is taken back by velocity (pgs), or turned into one (xpbd), keeps a stack from coming quite to
  // rest.
  const bool restless = GetParam().find("pgs") == 0 || GetParam() == "xpbd";
  const double speed = restless ? 0.15 : 0.01;
  double force[5] = {};  // of all contacts of a cube, in the mean
  for (int i = 0; i < 400; ++i) {
    const StepProblem before = stack.problem();
    stack.step();
    if (i < 300) continue;
    for (std::size_t k = 0; k < 5; ++k) {
      const RigidBody& falling = std::get<RigidScene>(before.contacts).bodies[k];
      force[k] += falling.mass * (stack.scene.bodies[k].linear_velocity - falling.linear_velocity).z() / kStep / 100;
    }
  }
  double borne = 0;  // by what is below a cube: its own weight, and that of all above
  for (int i = 4; i >= 0; --i) {
    borne += force[i];
    const double weight = 10 * (5 - i) * kGravity;
    EXPECT_NEAR(borne, weight, (restless ? 0.05 : 0.01) * weight) << i;
    EXPECT_LT((stack.scene.bodies[static_cast<std::size_t>(i)].position - Vector3d(0, 0, 0.5 + i)).norm(), 0.02) << i;
    EXPECT_LT(stack.scene.bodies[static_cast<std::size_t>(i)].linear_velocity.norm(), speed) << i;
  }
}

/// Else the positions of ever shorter steps have no limit: they keep a depth that depends on how contacts were found.
TEST(Steppers, TheDepthThatExactLeavesFallsWithTheSquareOfTheStep) {
  for (const int divide : {1, 4, 16}) {
    Simulation block("exact");
    block.h = kStep / divide;
    block.add({0, 0, 0.499}, 1);
    for (int i = 0; i < 100; ++i) block.step();
    const double allowed = 1e-4 / (divide * divide);
    EXPECT_GT(0.5 - block.scene.bodies[0].position.z(), allowed - 1e-12) << divide;
    EXPECT_LT(0.5 - block.scene.bodies[0].position.z(), 1.1 * allowed + 1e-12) << divide;
  }
}

/// Whatever solves the velocities, and however far the widest gap is open, a correction is right to a few per cent.
TEST(Steppers, ACorrectionOpensNoOtherPenetration) {
  for (const int count : {1, 30}) {
    for (const double gap : {1e-5, 0.04}) {
      Simulation blocks("exact{solver=psor{max_iterations=1}}");
      blocks.gravity.setZero();
      for (int i = 0; i < count; ++i) blocks.add({0, 0, 0.5 + 0.999 * i - 1e-3}, 1);
      blocks.add({0, 0, 0.5 + 0.999 * count + gap}, 100);
      const StepAnswer answer = blocks.step();
      ASSERT_EQ(answer.correction.size(), 6 * (count + 1));
      double below = 0;
      for (int i = 0; i <= count; ++i) {
        const double change = answer.correction(6 * i + 2) - below;
        below += change;
        EXPECT_GT(change, i < count ? 0.95 * 1.8e-4 : -gap - 0.05 * 1.8e-4) << i << " of " << count << ", " << gap;
      }
    }
  }
}

TEST_P(EveryStepper, BodiesThatMeetKeepTheirMomentum) {
  Simulation bodies(GetParam());
  bodies.gravity.setZero();
  bodies.add({0, 0, 2}, 1);
  bodies.add({0.2, 0.1, 2.9999}, 100);
  bodies.scene.bodies[1].linear_velocity = {1, 0, -1};
  const auto momentum = [&] {
    Eigen::Vector<double, 6> sum = Eigen::Vector<double, 6>::Zero();
    for (const RigidBody& body : bodies.scene.bodies) {
      const Vector3d p = body.mass * body.linear_velocity;
      sum.head<3>() += p;
      sum.tail<3>() += body.position.cross(p) + body.inertia * body.angular_velocity;
    }
    return sum;
  };
  const Eigen::Vector<double, 6> before = momentum();
  const RigidScene start = bodies.scene;
  bodies.step();
  for (std::size_t i = 0; i < 2; ++i) bodies.scene.bodies[i].position = start.bodies[i].position;
  EXPECT_LT(bodies.scene.bodies[0].linear_velocity.z(), -0.5);  // they did meet
  EXPECT_LT((momentum() - before).head<3>().norm(), 1e-9 * before.norm());
  // Impulses of later substeps act on arms that have moved.
  const bool substeps =
      GetParam() == "xpbd" || GetParam() == "soft_step" || GetParam().find("substeps") != std::string::npos;
  EXPECT_LT((momentum() - before).tail<3>().norm(), (substeps ? 1e-2 : 1e-9) * before.norm());
}

TEST_P(EveryStepper, NumbersThatAreNoneGiveNoVelocityThatIsOne) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Simulation block(GetParam());
    block.add({0, 0, 0.5}, 1);
    block.scene.bodies[0].linear_velocity.x() = bad;
    try {
      const StepAnswer answer = block.step();
      EXPECT_NE(answer.claim, Claim::kSolved);
      EXPECT_FALSE(answer.velocity.allFinite());
    } catch (const std::runtime_error& none) {
      EXPECT_STRNE(none.what(), "");
    }
  }
}

/// Those whose model of a frictionless step is the contact problem itself, in one step of many iterations.
class Converging : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(All, Converging,
                         ::testing::Values("pgs{iterations=20000,erp=0}", "sequential_impulses{iterations=20000}",
                                           "admm{iterations=20000,tolerance=1e-12}",
                                           "apgd{iterations=20000,tolerance=1e-12}", "convex"),
                         case_name);

TEST_P(Converging, WithoutFrictionIsTheSolutionOfTheContactProblem) {
  Vector velocity[2];
  for (const bool iterated : {false, true}) {
    Simulation stack(iterated ? GetParam() : "exact{solver=lemke}");
    stack.mu = 0;
    for (int i = 0; i < 4; ++i) {
      stack.add({0.05 * i, 0, 0.5 + i}, 1 + i);
      stack.scene.bodies.back().linear_velocity = {0.1 * i, 0, -1};
      stack.scene.bodies.back().angular_velocity = {0.3, 0.2 * i, 0.1};
    }
    velocity[iterated ? 1 : 0] = stack.step().velocity;
  }
  EXPECT_LT((velocity[1] - velocity[0]).lpNorm<Eigen::Infinity>(), 1e-6);
}

TEST(Steppers, ThoseThatKnowBodiesRefuseJointsByName) {
  StepProblem step;
  ContactProblem contact;
  contact.v = Vector::Constant(1, -1);
  contact.N = Matrix::Identity(1, 1);
  contact.D = Matrix(1, 0);
  contact.edges = {0};
  contact.mu = Vector::Zero(1);
  contact.inertia = BlockInertia{{2 * Matrix::Identity(1, 1)}};
  step.contacts = contact;
  step.force_change = Vector::Zero(1);
  step.gaps = {-1};
  step.ids = {1};
  step.h = kStep;
  for (const StepperDefinition& definition : registered_steppers()) {
    StepAnswer answer;
    make_stepper({definition.name, {}})->step(step, answer);
    if (definition.bodies_only) {
      EXPECT_EQ(answer.claim, Claim::kUnsupported) << definition.name;
      EXPECT_EQ(answer.detail, "it knows free bodies only, and the scene has joints");
    } else if (definition.name == "nothing") {
      EXPECT_EQ(answer.velocity, contact.v);
    } else {
      ASSERT_EQ(answer.velocity.size(), 1) << definition.name << ": " << answer.detail;
      EXPECT_NEAR(answer.velocity(0), 0, 1e-9) << definition.name;
      EXPECT_NEAR(answer.correction(0), 0.2 * (1 - 1e-4), 0.01) << definition.name;
    }
  }
}

TEST(Steppers, AStepWithoutFiniteVelocitiesDoesNotSpoilTheNextOne) {
  for (const char* name : {"pgs", "sequential_impulses", "soft_step"}) {
    Simulation block(name);
    block.add({0, 0, 0.5}, 1);
    const StepProblem sound = block.problem();
    StepProblem broken = sound;
    broken.force_change.setConstant(std::numeric_limits<double>::quiet_NaN());
    const std::unique_ptr<Stepper> stepper = make_stepper({name, {}});
    StepAnswer answer;
    stepper->step(broken, answer);
    EXPECT_EQ(answer.claim, Claim::kNumericalFailure) << name;
    EXPECT_EQ(answer.velocity.size(), 0) << name;
    stepper->step(sound, answer);
    EXPECT_EQ(answer.claim, Claim::kIterationLimit) << name << ": " << answer.detail;
  }
}

/// A heavy body on a light one: few cold sweeps let it sink, the same sweeps from the last impulses hold it.
TEST(Steppers, TheLastImpulsesHoldAStackThatColdSweepsLose) {
  double sunk[2];
  for (const bool warm : {false, true}) {
    Simulation stack(std::string("sequential_impulses{iterations=10,warm=") + (warm ? "true}" : "false}"));
    for (int i = 0; i < 10; ++i) stack.add({0, 0, 0.5 + i}, 10);
    for (int i = 0; i < 200; ++i) stack.step();
    sunk[warm ? 1 : 0] = 9.5 - stack.scene.bodies.back().position.z();
  }
  EXPECT_LT(sunk[1], 0.05);  // the slop of ten contacts
  EXPECT_GT(sunk[0], 0.1);
}

}  // namespace
}  // namespace lcpbench::steppers_test
