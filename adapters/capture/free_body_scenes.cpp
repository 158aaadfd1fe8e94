#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "adapters/capture/scene.h"

namespace lcpbench::capture {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Angles of right triangles with whole sides: 3-4-5 (36.9 degrees) and 7-24-25 (16.3 degrees).
constexpr double kCos37 = 0.8;
constexpr double kSin37 = 0.6;
constexpr double kCos16 = 0.96;
constexpr double kSin16 = 0.28;

/// Numbers between -1 and 1 without a pattern, the same everywhere.
class Scatter {
 public:
  double next() {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(state_ >> 44U) / (1U << 19U) - 1;
  }

 private:
  std::uint64_t state_ = 18;
};

/// Marks all bodies that can move as ones that should stay at rest.
Scene standing(Scene scene) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].mass > 0) scene.stands.push_back(static_cast<int>(i));
  }
  return scene;
}

/// Boxes of 10 kg, 1 m wide, on top of each other without gaps; mu = 0.5.
Scene tower(std::string name, std::string summary, int count, double half_height) {
  Scene result = scene(std::move(name), std::move(summary), 0.5);
  for (int i = 0; i < count; ++i) {
    result.bodies.push_back(solid({box(0.5, 0.5, half_height)}, 10, {0, 0, half_height * (1 + 2 * i)}));
  }
  return standing(std::move(result));
}

/// Ten rows of boxes, each on the gaps of the row below.
Scene pyramid() {
  constexpr int kRows = 10;
  Scene result = scene("pyramid-55", "a pyramid of 55 cubes", 0.6);
  for (int row = 0; row < kRows; ++row) {
    for (int i = 0; i < kRows - row; ++i) {
      result.bodies.push_back(solid({box(0.25, 0.25, 0.25)}, 5, {0.51 * (i + 0.5 * row), 0, 0.25 + 0.5 * row}));
    }
  }
  return standing(std::move(result));
}

/// Blocks along a half circle. A wedge is made of three boxes, each as wide as fits inside.
Scene arch() {
  Scene result = scene("arch", "eleven blocks that hold each other as an arch", 0.7);
  constexpr int kBlocks = 11;
  constexpr double kRadius = 2;
  constexpr double kSlab = 0.1;  // half the thickness of a box
  constexpr double kPi = 3.141592653589793;
  const double slope = std::tan(kPi / (2 * kBlocks));
  for (int i = 0; i < kBlocks; ++i) {
    const double angle = kPi * (i + 0.5) / kBlocks;
    std::vector<Part> slabs;
    for (const double radius : {kRadius - 2 * kSlab, kRadius, kRadius + 2 * kSlab}) {
      const double half_width = slope * (radius - kSlab);
      slabs.push_back(box(kSlab, 0.4, half_width, {radius, 0, 0}));
    }
    Body block = solid(slabs, 5, Vector3d::Zero());
    const double out = block.position.x();  // the centre of mass, before the turn
    block.position = out * Vector3d(std::cos(angle), 0, std::sin(angle));
    block.orientation = turned_about_y(std::cos(angle), -std::sin(angle));
    result.bodies.push_back(block);
  }
  return standing(std::move(result));
}

/// The gap between storeys of cards, and half the gap at the top of two that lean [m]: detectors differ on edges that
/// just touch.
constexpr double kSlack = 0.001;

/// Two cards that lean against each other above x, on a floor of height z.
void lean(Scene& scene, double x, double z) {
  constexpr double kThickness = 0.04;  // half
  constexpr double kLength = 0.75;     // half
  const double height = kLength * kCos16 + kThickness * kSin16;
  const double distance = kLength * kSin16 + kThickness * kCos16 + kSlack;
  for (const int side : {-1, 1}) {
    Body card = solid({box(kThickness, 0.5, kLength)}, 1, {x + side * distance, 0, z + height});
    card.orientation = turned_about_y(kCos16, -side * kSin16);
    scene.bodies.push_back(card);
  }
}

Scene card_house() {
  Scene result = scene("card-house", "five cards that hold each other: two storeys", 0.8);
  constexpr double kStorey = 2 * (0.75 * kCos16 + 0.04 * kSin16) + kSlack;
  lean(result, -0.5, 0);
  lean(result, 0.5, 0);
  result.bodies.push_back(solid({box(1, 0.5, 0.04)}, 1, {0, 0, kStorey + 0.04}));
  lean(result, 0, kStorey + 0.08 + kSlack);
  return standing(std::move(result));
}

Scene wall() {
  Scene result = scene("wall", "a wall of bricks, six rows of five", 0.6);
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 5; ++column) {
      const double x = 1.02 * column + (row % 2 == 0 ? 0 : 0.5);
      result.bodies.push_back(solid({box(0.5, 0.25, 0.25)}, 5, {x, 0, 0.25 + 0.5 * row}));
    }
  }
  return standing(std::move(result));
}

/// @param ratio  the mass of the heavy box over that of each light one, which is 1 kg
Scene mass_ratio(std::string name, double ratio) {
  Scene result = scene(std::move(name), "a heavy box on three light ones", 0.5);
  result.bodies.push_back(solid({box(0.25, 0.25, 0.25)}, 1, {-0.6, -0.5, 0.25}));
  result.bodies.push_back(solid({box(0.25, 0.25, 0.25)}, 1, {0.6, -0.5, 0.25}));
  result.bodies.push_back(solid({box(0.25, 0.25, 0.25)}, 1, {0, 0.5, 0.25}));
  result.bodies.push_back(solid({box(1, 1, 0.5)}, ratio, {0, 0, 1}));
  return standing(std::move(result));
}

Scene wedge() {
  Scene result = scene("wedge", "a box and a ball between steep walls, with a load on top", 0.4);
  for (const int side : {-1, 1}) {
    result.bodies.push_back(fixed(box(0.2, 1, 1.5), {side * 0.95, 0, 1.4}, turned_about_y(kCos16, side * kSin16)));
  }
  Body jammed = solid({box(0.45, 0.4, 0.15)}, 2, {0, 0, 0.57});
  jammed.linear_velocity = {0, 0, -1};
  result.bodies.push_back(jammed);
  result.bodies.push_back(solid({sphere(0.75)}, 5, {0, 0, 1.55}));
  Body load = solid({box(0.5, 0.4, 0.25)}, 50, {0.05, 0, 2.57});
  load.linear_velocity = {0, 0, -1};
  result.bodies.push_back(load);
  return result;
}

/// Four walls about the origin, so that a pile stays a pile.
void enclose(Scene& scene, double half_width) {
  const double at = half_width + 0.2;
  for (const int side : {-1, 1}) {
    scene.bodies.push_back(fixed(box(0.2, at + 0.2, 1), {side * at, 0, 1}));
    scene.bodies.push_back(fixed(box(half_width, 0.2, 1), {0, side * at, 1}));
  }
}

/// @param wide  balls along each side of the bin
Scene sphere_pile(std::string name, int count, int wide, double half_width) {
  Scene result =
      scene(std::move(name), std::to_string(count) + " balls of three sizes fall into a bin and bounce", 0.4);
  result.restitution = 0.3;
  enclose(result, half_width);
  Scatter scatter;
  const double middle = 0.5 * (wide - 1);
  for (int i = 0; i < count; ++i) {
    const double radius = 0.18 + 0.04 * (i % 3);
    const double y = (i / wide % wide - middle) * 0.58 + 0.03 * scatter.next();
    const double x = (i % wide - middle) * 0.58 + 0.03 * scatter.next();
    const Vector3d at(x, y, 0.35 + 0.62 * (i / (wide * wide)));
    result.bodies.push_back(solid({sphere(radius)}, 8 * radius * radius * radius / 0.008, at));
  }
  return result;
}

Scene box_pile() {
  Scene result = scene("box-pile", "24 boxes of several shapes fall into a bin", 0.5);
  enclose(result, 0.9);
  Scatter scatter;
  for (int i = 0; i < 24; ++i) {
    const double y = (i / 2 % 2 - 0.5) * 0.85 + 0.05 * scatter.next();
    const double x = (i % 2 - 0.5) * 0.85 + 0.05 * scatter.next();
    const Vector3d at(x, y, 0.5 + 0.85 * (i / 4));
    Body body = solid({box(0.2 + 0.03 * (i % 3), 0.25, 0.15 + 0.04 * (i % 2))}, 5 + i % 4, at);
    const double about_z = scatter.next();
    const double about_y = scatter.next();
    const double about_x = scatter.next();
    body.orientation = Quaterniond(2, about_x, about_y, about_z).normalized();
    result.bodies.push_back(body);
  }
  return result;
}

Scene uneven_table() {
  Scene result = scene("uneven-table", "a table with a load, its legs on blocks of unequal height", 0.5);
  std::vector<Part> parts{box(1, 0.6, 0.05, {0, 0, 1.05})};
  for (const int x : {-1, 1}) {
    for (const int y : {-1, 1}) parts.push_back(box(0.06, 0.06, 0.5, {0.9 * x, 0.5 * y, 0.5}));
  }
  constexpr double kHeights[] = {0.10, 0.11, 0.105, 0.10};
  for (int i = 0; i < 4; ++i) {
    const double height = kHeights[i];
    result.bodies.push_back(
        fixed(box(0.3, 0.3, height / 2), {i < 2 ? -0.9 : 0.9, i % 2 == 0 ? -0.5 : 0.5, height / 2}));
  }
  result.bodies.push_back(solid(parts, 20, {0, 0, 0.112}));
  result.bodies.push_back(solid({box(0.2, 0.2, 0.2)}, 10, {0.5, 0.2, 1.42}));
  return standing(std::move(result));
}

Scene gripper() {
  Scene result = scene("gripper", "two fingers squeeze a box and lift it", 0.6);
  constexpr double kGravity = 9.81;
  constexpr double kFinger = 4;  // kg
  constexpr double kBox = 2;     // kg
  result.bodies.push_back(solid({box(0.2, 0.2, 0.2)}, kBox, {0, 0, 0.2}));
  for (const int side : {-1, 1}) {
    Body finger = solid({box(0.05, 0.15, 0.15)}, kFinger, {side * 0.26, 0, 0.25});
    finger.push.force = {-side * 60.0, 0, kGravity * (kFinger + kBox / 2) + 2};
    result.grips.push_back({.held = 1, .by = static_cast<int>(result.bodies.size())});
    result.bodies.push_back(finger);
  }
  return result;
}

/// In steps that are long enough to see how far a convex model lifts what slides.
Scene sliding_cube() {
  Scene result = scene("sliding-cube", "a cube that slides on the ground at 6 m/s, in steps of 50 ms", 0.5);
  result.step = 0.05;
  result.steps = 30;
  Body cube = solid({box(0.2, 0.2, 0.2)}, 8, {0, 0, 0.2});
  cube.linear_velocity = {6, 0, 0};
  result.bodies.push_back(cube);
  return result;
}

Scene dominoes() {
  Scene result = scene("dominoes", "ten dominoes in a row, the first one pushed", 0.4);
  for (int i = 0; i < 10; ++i) {
    Body domino = solid({box(0.06, 0.25, 0.5)}, 1, {0.5 * i, 0, 0.5});
    if (i == 0) {
      domino.angular_velocity = {0, 1.5, 0};
      domino.linear_velocity = {0.75, 0, 0};
    }
    result.bodies.push_back(domino);
  }
  return result;
}

Scene slope() {
  Scene result = scene("slope",
                       "four boxes on a slope at the angle of friction: one moves up, one rests, one moves down, a "
                       "tall one tips",
                       0.75);
  result.bodies[0].orientation = turned_about_y(kCos37, kSin37);
  result.bodies[0].position = Vector3d(-kSin37, 0, -kCos37);
  const Vector3d up(kSin37, 0, kCos37);
  const Vector3d down(kCos37, 0, -kSin37);
  for (int i = 0; i < 3; ++i) {
    Body body = solid({box(0.3, 0.3, 0.2)}, 5, 0.2 * up + Vector3d(0, 1.5 * (i - 1), 0));
    body.orientation = result.bodies[0].orientation;
    body.linear_velocity = 0.5 * (i - 1) * down;
    if (i == 1) result.stands.push_back(static_cast<int>(result.bodies.size()));
    result.bodies.push_back(body);
  }
  Body tall = solid({box(0.15, 0.3, 0.4)}, 5, 0.4 * up + Vector3d(0, 3, 0));
  tall.orientation = result.bodies[0].orientation;
  result.bodies.push_back(tall);
  return result;
}

/// Blocks on planes whose slopes are 0.8, 0.9, 1, 1.1 and 1.2 times the friction coefficient.
Scene slopes() {
  Scene result = scene("slopes", "five blocks on planes around the angle at which friction gives way", 0.5);
  for (int i = 0; i < 5; ++i) {
    const double tangent = 0.5 * (0.8 + 0.1 * i);
    const double cosine = 1 / std::sqrt(1 + tangent * tangent);
    const Quaterniond turn = turned_about_y(cosine, cosine * tangent);
    const Vector3d middle(0, 2.0 * (i - 2), 5);
    result.bodies.push_back(fixed(box(8, 0.6, 0.5), middle, turn));
    Body block = solid({box(0.3, 0.3, 0.2)}, 5, middle + turn * Vector3d(-5, 0, 0.7));
    block.orientation = turn;
    if (i < 2) result.stands.push_back(static_cast<int>(result.bodies.size()));
    result.bodies.push_back(block);
  }
  return result;
}

Scene heavy_ball() {
  Scene result = scene("heavy-ball", "a ball of 1000 kg on three boxes of 1 kg on top of each other", 0.5);
  for (int i = 0; i < 3; ++i) result.bodies.push_back(solid({box(0.5, 0.5, 0.25)}, 1, {0, 0, 0.25 + 0.5 * i}));
  result.bodies.push_back(solid({sphere(0.5)}, 1000, {0, 0, 2}));
  return standing(std::move(result));
}

Scene spinning_plate() {
  Scene result = scene("spinning-plate", "a flat plate that spins and slides on the floor, and one on its edge", 0.3);
  Body flat = solid({box(0.5, 0.5, 0.05)}, 5, {0, 0, 0.05});
  flat.angular_velocity = {0, 0, 12};
  flat.linear_velocity = {1, 0, 0};
  result.bodies.push_back(flat);
  Body tilted = solid({box(0.5, 0.5, 0.05)}, 5, {3, 0, 0.5 * kSin37 + 0.05 * kCos37});
  tilted.orientation = turned_about_y(kCos37, kSin37);
  tilted.angular_velocity = {0, 0, 10};
  result.bodies.push_back(tilted);
  return result;
}

Scene bouncing_balls() {
  Scene result = scene("bouncing-balls", "balls that bounce on a floor and on each other", 0.3);
  result.restitution = 0.7;
  for (int i = 0; i < 6; ++i) {
    Body ball = solid({sphere(0.25)}, 1 + i, {0.6 * (i % 3), 0.05 * i, 0.4 + 0.75 * (i / 3) + 0.1 * (i % 3)});
    ball.angular_velocity = {0, 4.0 * (i - 2), 3};
    result.bodies.push_back(ball);
  }
  return result;
}

}  // namespace

std::vector<Scene> free_body_scenes() {
  return {tower("stack", "ten boxes on top of each other", 10, 0.25),
          tower("cubes-3", "3 cubes on top of each other", 3, 0.5),
          tower("cubes-10", "10 cubes on top of each other", 10, 0.5),
          tower("cubes-20", "20 cubes on top of each other", 20, 0.5),
          pyramid(),
          arch(),
          heavy_ball(),
          slopes(),
          card_house(),
          wall(),
          mass_ratio("mass-ratio-1e4", 1e4),
          mass_ratio("mass-ratio-1e6", 1e6),
          wedge(),
          sphere_pile("sphere-pile", 36, 3, 0.9),
          sphere_pile("sphere-pile-500", 500, 8, 2.4),
          box_pile(),
          uneven_table(),
          gripper(),
          sliding_cube(),
          dominoes(),
          slope(),
          spinning_plate(),
          bouncing_balls()};
}

}  // namespace lcpbench::capture
