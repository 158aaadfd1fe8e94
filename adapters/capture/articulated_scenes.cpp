#include <string>
#include <utility>
#include <vector>

#include "adapters/capture/scene.h"

namespace lcpbench::capture {
namespace {

using Eigen::Vector3d;

constexpr double kHalfTurn = 3.141592653589793;

Joint hinge(int parent, const Vector3d& anchor, const Vector3d& axis, double lower, double upper) {
  return {.parent = parent, .anchor = anchor, .axis = axis, .lower = lower, .upper = upper};
}

/// @param stiffness  of the controller [N m / rad]; its damping is stiffness * 0.025 s. @param max_torque  [N m]
Joint driven(Joint joint, double stiffness, double max_torque, const Target& target) {
  joint.stiffness = stiffness;
  joint.damping = stiffness / 40;
  joint.max_torque = max_torque;
  joint.target = target;
  return joint;
}

int add(Scene& scene, Body body) {
  scene.bodies.push_back(std::move(body));
  return static_cast<int>(scene.bodies.size()) - 1;
}

int add(Scene& scene, Body body, const Joint& joint) {
  body.joint = joint;
  return add(scene, std::move(body));
}

/// A trunk and four legs of three hinges each, straight at first with the lowest points of the feet at height z [m].
/// Then the controllers bend them. Diagonal legs swing together, at 2 Hz.
/// @param stride  amplitude of the thighs [rad]; the knees have 1.2 times that. 0: it stands
void add_quadruped(Scene& scene, double z, double stride) {
  const int trunk = add(scene, solid({box(0.30, 0.12, 0.06)}, 12, {0, 0, z + 0.60}));
  for (int leg = 0; leg < 4; ++leg) {
    const double x = leg < 2 ? 0.25 : -0.25;
    const double y = leg % 2 == 0 ? 0.17 : -0.17;
    const double phase = leg == 0 || leg == 3 ? 0 : kHalfTurn;
    const int hip = add(scene, solid({box(0.04, 0.04, 0.04)}, 0.8, {x, y, z + 0.58}),
                        driven(hinge(trunk, {x, y, z + 0.58}, Vector3d::UnitX(), -0.5, 0.5), 80, 40, {}));
    const int thigh =
        add(scene, solid({box(0.025, 0.025, 0.13)}, 1.2, {x, y, z + 0.43}),
            driven(hinge(hip, {x, y, z + 0.58}, Vector3d::UnitY(), -1.2, 1.6), 80, 40, {0.5, stride, 2, phase}));
    add(scene, solid({box(0.018, 0.018, 0.11, {0, 0, 0.03}), sphere(0.03, {0, 0, -0.11})}, 0.5, {x, y, z + 0.14}),
        driven(hinge(thigh, {x, y, z + 0.29}, Vector3d::UnitY(), -2.2, 0.1), 80, 40,
               {-1, stride * 1.2, 2, phase + kHalfTurn / 2}));
  }
}

/// Twelve slabs side by side, 20 to 40 mm high.
void add_uneven_ground(Scene& scene) {
  constexpr int kHeights[] = {3, 1, 4, 2, 0, 3, 1, 2, 4, 0, 2, 3};  // above the lowest, in units of 5 mm
  for (int i = 0; i < 12; ++i) {
    const double height = 0.02 + 0.005 * kHeights[i];
    scene.bodies.push_back(fixed(box(0.2, 0.2, height / 2), {-0.6 + 0.4 * (i % 4), -0.4 + 0.4 * (i / 4), height / 2}));
  }
}

Scene quadruped(std::string name, std::string summary, double stride) {
  Scene result = scene(std::move(name), std::move(summary), 0.7);
  add_uneven_ground(result);
  add_quadruped(result, 0.05, stride);
  result.step = 0.0025;
  result.steps = 600;
  return result;
}

Scene hand() {
  Scene result = scene("hand", "a hand of three fingers with two hinges each turns a box on its palm", 0.8);
  const int palm = add(result, fixed(box(0.3, 0.3, 0.05), {0, 0, 0.5}));
  // Two fingers stand on one side of the box and push in turn, one stands on the other side.
  const Vector3d bases[] = {{0.27, 0.08, 0.55}, {0.27, -0.08, 0.55}, {-0.27, 0, 0.55}};
  for (int i = 0; i < 3; ++i) {
    const Vector3d base = bases[i];
    const Vector3d knuckle = base + Vector3d(0, 0, 0.25);
    const Vector3d closing = Vector3d::UnitY() * (i < 2 ? -1 : 1);  // a turn about this axis closes the finger
    const Target curl{0.4, i < 2 ? 0.2 : 0.0, 1.5, i * kHalfTurn};
    const int lower = add(result, solid({box(0.03, 0.03, 0.1, {0, 0, 0.13})}, 0.5, base),
                          driven(hinge(palm, base, closing, -0.3, 1.2), 40, 15, curl));
    add(result, solid({box(0.025, 0.025, 0.06, {0, 0, 0.08}), sphere(0.035, {0, 0, 0.175})}, 0.3, knuckle),
        driven(hinge(lower, knuckle, closing, -0.2, 1.4), 20, 10, {0.15, 0, 0, 0}));
  }
  add(result, solid({box(0.1, 0.12, 0.2)}, 1, {0, 0, 0.7505}));
  result.step = 0.0025;
  result.steps = 800;
  return result;
}

/// Six links in an upright ring that drops on its lowest link. Hinges join neighbouring links; the point constraint in
/// `loops` joins the last link to the first.
Scene closed_chain() {
  Scene result = scene("closed-chain", "a closed chain of six links drops on the floor", 0.6);
  constexpr double kHalf = 0.25;  // half the length of a link
  constexpr double kSin60 = 0.8660254037844386;
  const Vector3d corners[] = {{-kHalf, 0, 0},
                              {kHalf, 0, 0},
                              {2 * kHalf, 0, 2 * kHalf * kSin60},
                              {kHalf, 0, 4 * kHalf * kSin60},
                              {-kHalf, 0, 4 * kHalf * kSin60},
                              {-2 * kHalf, 0, 2 * kHalf * kSin60}};
  const Vector3d lift(0, 0, 0.1);
  int previous = -1;
  for (int i = 0; i < 6; ++i) {
    const Vector3d from = corners[i] + lift;
    const Vector3d to = corners[(i + 1) % 6] + lift;
    const Vector3d along = (to - from) / (2 * kHalf);
    Body link = solid({box(0.2, 0.06, 0.03)}, 1, (from + to) / 2);
    link.orientation = along.x() < -0.9 ? Eigen::Quaterniond(0, 0, 1, 0)  // upside down
                                        : turned_about_y(along.x(), -along.z());
    if (previous >= 0) link.joint = hinge(previous, from, Vector3d::UnitY(), -1.5, 1.5);
    previous = add(result, std::move(link));
  }
  result.loops.push_back({previous, previous - 5, corners[0] + lift});
  result.step = 0.0025;
  result.steps = 500;
  return result;
}

/// A level chain of five links of 1 kg from a post to a ball of 1e4 kg, which is 5 cm above the floor.
Scene chain() {
  Scene result = scene("chain-1e4", "a chain of five links from a post to a ball of 1e4 times their mass", 0.5);
  constexpr double kHeight = 0.5;
  constexpr double kLength = 0.3;
  int previous = add(result, fixed(box(0.05, 0.05, 0.2), {-0.1, 0, kHeight}));
  Vector3d joint(0, 0, kHeight);
  for (int i = 0; i < 5; ++i) {
    previous = add(result, solid({box(0.12, 0.04, 0.04)}, 1, joint + Vector3d(kLength / 2, 0, 0)),
                   hinge(previous, joint, Vector3d::UnitY(), -1.5, 1.5));
    joint.x() += kLength;
  }
  add(result, solid({sphere(0.45)}, 1e4, joint + Vector3d(0.5, 0, 0)),
      hinge(previous, joint, Vector3d::UnitY(), -1.5, 1.5));
  result.step = 0.0025;
  result.steps = 400;
  return result;
}

/// A torque in the engine's own solve; see Joint.
Joint with_effort(Joint joint, double effort, double speed) {
  joint.effort = effort;
  joint.speed = speed;
  return joint;
}

/// A push opens the door. Its hinge's dry friction and a crate bring it to rest.
Scene door() {
  Scene result = scene("door", "a door on a hinge with dry friction opens against a crate", 0.5);
  const int post = add(result, fixed(box(0.03, 0.03, 0.6), {0, 0, 0.6}));
  Body panel = solid({box(0.4, 0.02, 0.5)}, 10, {0.45, 0, 0.55});
  panel.push = {{0, 30, 0}, 0, 59};
  add(result, panel, with_effort(hinge(post, {0, 0, 0.55}, Vector3d::UnitZ(), -1.5, 1.5), 2, 0));
  add(result, solid({box(0.1, 0.1, 0.1)}, 5, {0.7, 0.25, 0.1}));
  result.step = 0.0025;
  result.steps = 500;
  return result;
}

/// A frame, a crank with dry friction, a coupler and a rocker, whose lower end `loops` joins to the frame. A push
/// starts it, a ball drops on the coupler, and the crank falls to its limit.
Scene four_bar() {
  Scene result = scene("four-bar", "a four-bar linkage with dry friction falls to a limit, and a ball on it", 0.5);
  const Vector3d crank_base(0, 0, 0.5), crank_end(0, 0, 0.8), rocker_end(0.6, 0, 1), rocker_base(0.6, 0, 0.5);
  const int frame = add(result, fixed(box(0.35, 0.05, 0.02), {0.3, 0, 0.45}));
  const int crank = add(result, solid({box(0.02, 0.02, 0.13)}, 1, (crank_base + crank_end) / 2),
                        with_effort(hinge(frame, crank_base, Vector3d::UnitY(), -1, 1), 0.2, 0));
  const Vector3d along = (rocker_end - crank_end).normalized();
  Body link = solid({box(0.28, 0.02, 0.02)}, 1, (crank_end + rocker_end) / 2);
  link.orientation = turned_about_y(along.x(), -along.z());
  link.push = {{4, 0, 0}, 0, 19};
  const int coupler = add(result, std::move(link), hinge(crank, crank_end, Vector3d::UnitY(), -2.5, 2.5));
  const int rocker = add(result, solid({box(0.02, 0.02, 0.23)}, 1, (rocker_base + rocker_end) / 2),
                         hinge(coupler, rocker_end, Vector3d::UnitY(), -2.5, 2.5));
  result.loops.push_back({rocker, frame, rocker_base});
  add(result, solid({sphere(0.05)}, 0.3, {0.25, 0, 1.05}));
  result.step = 0.0025;
  result.steps = 400;
  return result;
}

Scene motor() {
  Scene result = scene("motor", "a motor with little torque to spare lifts an arm and a box to a limit", 0.5);
  const int post = add(result, fixed(box(0.02, 0.02, 0.25), {0, 0, 0.25}));
  add(result, solid({box(0.25, 0.03, 0.02)}, 1, {0.27, 0, 0.5}),
      with_effort(hinge(post, {0, 0, 0.5}, -Vector3d::UnitY(), -0.1, 1), 4, 2));
  add(result, solid({box(0.03, 0.03, 0.03)}, 0.1, {0.2, 0, 0.55}));
  result.step = 0.0025;
  result.steps = 400;
  return result;
}

Joint slide(int parent, const Vector3d& anchor, const Vector3d& axis, double lower, double upper) {
  Joint joint = hinge(parent, anchor, axis, lower, upper);
  joint.slides = true;
  return joint;
}

/// A carriage that rises on a post, and two jaws that close on a box. All three slide by motors of limited force.
Scene jaws() {
  Scene result = scene("jaws", "a gripper with motors of limited force closes its jaws on a box and lifts it", 0.6);
  const int post = add(result, fixed(box(0.05, 0.05, 0.5), {0, 0.4, 0.5}));
  const int carriage = add(result, solid({box(0.2, 0.05, 0.03)}, 2, {0, 0.2, 0.3}),
                           with_effort(slide(post, {0, 0.2, 0.3}, Vector3d::UnitZ(), -0.05, 0.2), 60, 0.1));
  for (const int side : {-1, 1}) {
    const Vector3d at(side * 0.14, 0, 0.15);
    add(result, solid({box(0.02, 0.04, 0.08)}, 0.5, at),
        with_effort(slide(carriage, at, -side * Vector3d::UnitX(), -0.05, 0.1), 25, 0.2));
  }
  add(result, solid({box(0.08, 0.06, 0.1)}, 1, {0, 0, 0.1}));
  result.step = 0.0025;
  result.steps = 400;
  return result;
}

/// The humanoid that comes with MuJoCo. A scene of a model has the step, masses and friction of the model's file.
constexpr const char* kHumanoid = "humanoid/humanoid.xml";

}  // namespace

std::vector<Scene> articulated_scenes() {
  return {quadruped("quadruped-standing", "a robot with four legs stands on uneven ground", 0),
          quadruped("quadruped-trotting", "a robot with four legs trots on uneven ground", 0.25),
          hand(),
          closed_chain(),
          chain(),
          door(),
          four_bar(),
          motor(),
          jaws(),
          {.name = "humanoid-falling", .summary = "MuJoCo's humanoid falls", .steps = 400, .model = kHumanoid},
          {.name = "humanoid-lying",
           .summary = "MuJoCo's humanoid lies on the floor",
           .steps = 400,
           .model = kHumanoid,
           .model_height = -1.05,
           .model_tilt = 1.5},
          {.name = "humanoid-pushed",
           .summary = "MuJoCo's humanoid stands stiffly and is pushed from the side",
           .steps = 400,
           .model = kHumanoid,
           .model_stiffness = 200,
           .model_push = {{0, 250, 0}, 60, 90}},
          {.name = "humanoids-22",
           .summary = "22 of MuJoCo's humanoids fall",
           .steps = 400,
           .model = "humanoid/22_humanoids.xml"}};
}

}  // namespace lcpbench::capture
