#include <algorithm>
#include <cmath>

#include "generators/made/scene.h"

// Balls, rods and boxes in rows, nets, layers and groups.

namespace lcpbench::made {
namespace {

/// Two bodies that may not come apart along the line of their centres, as links of a chain, and perhaps not nearer.
void couple(Scene& scene, int a, int b, bool both_ways) {
  const Triple between = b == kWorld ? kZ : unit(scene.centre(a) - scene.centre(b));
  const Triple middle = b == kWorld ? scene.centre(a) : 0.5 * (scene.centre(a) + scene.centre(b));
  scene.touch(a, b, middle, b == kWorld ? between : -between);
  if (both_ways) scene.touch(a, b, middle, b == kWorld ? -between : between);
}

// One ball, box, stack of boxes or ball in a groove, at `place` on the ground.
int add_island(Scene& scene, const Triple& place) {
  const double size = scene.log_uniform(0.05, 0.5);
  const double weight = scene.mass(1000 * size * size * size);
  const int kind = scene.integer(0, 3);
  const Axes axes = turned_about_z(scene.uniform(0, 1));
  if (kind == 0) {
    scene.touch(scene.sphere(weight, size, place + size * kZ), kWorld, place, kZ);
    return 1;
  }
  if (kind == 1) {
    const int ball = scene.sphere(weight, size, place + size * kZ);
    const auto [c, s] = cos_sin(scene.uniform(0.05, 0.15));
    for (const double side : {-1.0, 1.0}) {
      const Triple normal = c * kZ + side * s * axes[0];
      scene.touch(ball, kWorld, scene.centre(ball) - size * normal, normal);
    }
    return 2;
  }
  const int boxes = kind == 2 ? 1 : scene.integer(2, 4);
  int below = kWorld;
  for (int k = 0; k < boxes; ++k) {
    const Triple foot = place + size * k * kZ;
    const int box = scene.box(weight, {size, size, size}, foot + 0.5 * size * kZ, axes);
    scene.touch_face(box, below, foot, kZ, 0.45 * size * axes[0], 0.45 * size * axes[1]);
    below = box;
  }
  return 4 * boxes;
}

}  // namespace

// A row of balls on the ground. The first ones run into the others.
void build_cradle(Scene& scene) {
  const int balls = Scene::count(scene.goal() / 2, 5);
  const int runners = scene.integer(1, balls / 2);
  const bool is_struck = scene.chance(0.7);
  const double speed = scene.log_uniform(0.1, 3);
  for (int k = 0; k < balls; ++k) {
    const int ball = scene.sphere(scene.mass(1), 0.5, {1.0 * k, 0, 0.5});
    if (is_struck) scene.move(ball, (k < runners ? speed : 0.0) * kX - 0.05 * kZ, {});
    scene.touch(ball, kWorld, {1.0 * k, 0, 0}, kZ, true);
    if (k > 0) scene.touch(ball, ball - 1, {k - 0.5, 0, 0.5}, kX, true);
  }
}

// Small groups that do not touch each other.
void build_islands(Scene& scene) {
  const int goal = Scene::count(scene.goal(), 1);
  int contacts = 0;
  for (int k = 0; contacts < goal; ++k) contacts += add_island(scene, {2.0 * (k % 100), 2.0 * (k / 100), 0});
}

// A net of balls that hangs on its rim.
void build_net(Scene& scene) {
  const double both_ways = scene.chance(0.3) ? 0 : scene.uniform(0, 1);
  const int side = Scene::count(std::sqrt(scene.goal() / (2 * (1 + both_ways))), 2);
  const double sag = scene.uniform(0, 0.5);
  const auto along = [&](int k) { return 2 * (k + 0.5) / side - 1; };
  std::vector<int> balls;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const double depth = (1 - along(x) * along(x)) * (1 - along(y) * along(y));
      balls.push_back(scene.sphere(scene.mass(0.5), 0.3, {1.0 * x, 1.0 * y, -sag * side * depth}));
      const int own = balls.back();
      if (x > 0) couple(scene, own, own - 1, scene.chance(both_ways));
      if (y > 0) couple(scene, own, own - side, scene.chance(both_ways));
      const bool is_rim = x == 0 || y == 0 || x + 1 == side || y + 1 == side;
      if (is_rim && (x + y) % 2 == 0) couple(scene, own, kWorld, scene.chance(both_ways));
    }
  }
}

// One body on many points of flat or uneven ground.
void build_patch(Scene& scene) {
  const int points = Scene::count(scene.goal(), 3);
  const double tilt = scene.chance(0.5) ? 0 : scene.uniform(0, 0.1);
  const double size = scene.log_uniform(0.1, 10);
  const int body = scene.box(scene.mass(500 * size * size * size), {size, size, size / 2}, size / 4 * kZ);
  for (int k = 0; k < points; ++k) {
    const double radius = 0.5 * size * std::sqrt(scene.uniform(0, 1));
    const Triple point = radius * turned_about_z(scene.uniform(0, 1))[0];
    const Triple normal = unit({scene.uniform(-tilt, tilt), scene.uniform(-tilt, tilt), 1});
    scene.touch(body, kWorld, point, normal, true);
  }
}

// A chain of balls in a bent pipe: each ball lies on two or three points of the wall.
void build_pipe(Scene& scene) {
  const double tightness = scene.chance(0.5) ? 0 : scene.uniform(0, 1);
  const double both_ways = scene.uniform(0, 1);
  const int balls = Scene::count(scene.goal() / (3 + tightness + both_ways), 2);
  const double bend = scene.chance(0.3) ? 0 : scene.uniform(-1, 1) / balls;
  const double slope = scene.uniform(-0.2, 0.2);
  const bool is_pushed = scene.chance(0.5);
  Triple centre{0, 0, 0.5};
  int last = kWorld;
  for (int k = 0; k < balls; ++k) {
    const Axes level = turned_about_z(bend * k);
    const auto [c, s] = cos_sin(slope);
    const Triple ahead = c * level[0] + s * kZ;
    const Triple up = c * kZ - s * level[0];
    const int ball = scene.sphere(scene.mass(1), 0.5, centre);
    if (k == 0 && is_pushed) scene.move(ball, ahead, {});
    if (last != kWorld) couple(scene, ball, last, scene.chance(both_ways));
    const double around = scene.uniform(0.05, 0.2);
    const auto wall = [&](double turns) {
      const auto [upwards, sideways] = cos_sin(turns);
      const Triple normal = upwards * up + sideways * level[1];
      scene.touch(ball, kWorld, centre - 0.5 * normal, normal);
    };
    wall(around);
    wall(-around);
    if (scene.chance(tightness)) wall(0.5);
    if (k + 1 == balls) scene.touch(ball, kWorld, centre + 0.5 * ahead, -ahead);
    last = ball;
    centre = centre + ahead;
  }
}

// Layers of parallel rods, each about a quarter turn from the layer below. A rod touches every rod of the layer below
// where they cross; one of the lowest layer touches the ground at two points.
void build_sticks(Scene& scene) {
  const double thickness = scene.uniform(0.05, 0.3);
  const int widest = Scene::count(std::sqrt(scene.goal()), 2);
  const int rods = scene.integer(2, std::min(widest, 12));
  const int layers = Scene::count(scene.goal() / (rods * rods), 2);
  const double jitter = scene.uniform(0, 0.3) / rods;
  const double slope = scene.uniform(0, 0.15);
  struct Rod {
    int body;
    Triple centre, along;
  };
  std::vector<Rod> below;
  for (int layer = 0; layer < layers; ++layer) {
    const double height = thickness * (layer + 0.5);
    const double direction = 0.25 * layer + scene.uniform(-0.04, 0.04);
    std::vector<Rod> here;
    for (int k = 0; k < rods; ++k) {
      const Axes axes = turned_about_z(direction + 0.1 * scene.uniform(-jitter, jitter));
      const double shift = k - 0.5 * (rods - 1) + scene.uniform(-jitter, jitter);
      const Triple centre = shift * axes[1] + height * kZ;
      const double rod_length = 1.6 * rods;
      const Triple along = unit(axes[0] + scene.uniform(-slope, slope) * kZ);
      const double mass = scene.mass(700 * thickness * thickness * rod_length);
      const int body = scene.box(mass, {rod_length, thickness, thickness}, centre,
                                 {along, axes[1], cross(along, axes[1])});
      if (layer == 0) {
        for (const double end : {-0.7, 0.7}) {
          const Triple point = centre + end * rod_length / 2 * axes[0];
          scene.touch(body, kWorld, {point[0], point[1], 0}, kZ);
        }
      }
      for (const Rod& rod : below) {
        const Triple normal = unit(cross(rod.along, along));
        const Triple apart = centre - rod.centre;
        // Where the two lines cross, as seen from above.
        const double determinant = rod.along[0] * along[1] - rod.along[1] * along[0];
        const double at = (apart[0] * along[1] - apart[1] * along[0]) / determinant;
        const Triple crossing = rod.centre + at * rod.along;
        scene.touch(body, rod.body, {crossing[0], crossing[1], thickness * layer}, normal[2] > 0 ? normal : -normal);
      }
      here.push_back({body, centre, along});
    }
    below = here;
  }
}

}  // namespace lcpbench::made
