#include <algorithm>
#include <cmath>

#include "generators/made/scene.h"

// Disordered lattices of balls and cubes.

namespace lcpbench::made {
namespace {

constexpr double kLayer = 0.7071;  ///< height of a layer [m]: close-packed balls of diameter 1 m, in square layers

struct Grain {
  int body = kWorld;
  double radius = 0;
  bool is_cube = false;
};

/// Grains near the places of a close packing in a square box: columns^2 in each of the layers.
class Pile {
 public:
  Pile(Scene& scene, int columns, int layers, double cubes) : scene_(scene), columns_(columns), layers_(layers) {
    const double disorder = scene.uniform(0.02, 0.2);
    const double spread = scene.uniform(0, 0.15);
    const auto moved = [&] { return scene.uniform(-disorder, disorder); };
    for_each_place([&](int x, int y, int z) {
      const double radius = 0.5 * (1 + scene.uniform(-spread, spread));
      const double shift = z % 2 == 0 ? 0 : 0.5;
      const Triple centre = Triple{x + shift, y + shift, 0.5 + kLayer * z} + Triple{moved(), moved(), moved()};
      const bool is_cube = scene.chance(cubes);
      const double mass = scene.mass(2000 * radius * radius * radius);
      const double edge = 1.6 * radius;
      const int body = is_cube ? scene.box(mass, {edge, edge, edge}, centre) : scene.sphere(mass, radius, centre);
      grains_.push_back({body, radius, is_cube});
    });
  }

  /// Contacts of each grain with the ground, with what touch_more(grain) adds, and with grains before it.
  template <class TouchMore>
  void touch_all(TouchMore touch_more) {
    for_each_place([&](int x, int y, int z) {
      const Grain& own = at(x, y, z);
      const Triple& centre = scene_.centre(own.body);
      if (centre[2] < own.radius + 0.1) touch(own, {}, {centre[0], centre[1], 0}, kZ);
      touch_more(own);
      if (x > 0) meet(own, at(x - 1, y, z));
      if (y > 0) meet(own, at(x, y - 1, z));
      for (int k = 0; k < 4 && z > 0; ++k) {
        const int shift = z % 2 == 0 ? -1 : 0;
        const int other_x = x + k % 2 + shift;
        const int other_y = y + k / 2 + shift;
        if (other_x < 0 || other_y < 0 || other_x >= columns_ || other_y >= columns_) continue;
        meet(own, at(other_x, other_y, z - 1));
      }
    });
  }

  /// A contact, normal from b to a. A cube touches a cube or the world with a face, anything else in a point.
  void touch(const Grain& a, const Grain& b, const Triple& point, const Triple& normal) {
    const bool is_face = a.is_cube && (b.is_cube || b.body == kWorld);
    if (!is_face) return scene_.touch(a.body, b.body, point, normal);
    const Triple along = unit(cross(normal, std::abs(normal[2]) < 0.7 ? kZ : kX));
    scene_.touch_face(a.body, b.body, point, normal, 0.25 * along, 0.25 * cross(normal, along));
  }

  /// The grain at place x, y of layer z. @pre 0 <= x, y < columns and 0 <= z < layers
  const Grain& at(int x, int y, int z) const {
    return grains_[static_cast<std::size_t>((z * columns_ + y) * columns_ + x)];
  }

 private:
  template <class Action>
  void for_each_place(Action action) const {
    for (int z = 0; z < layers_; ++z) {
      for (int y = 0; y < columns_; ++y) {
        for (int x = 0; x < columns_; ++x) action(x, y, z);
      }
    }
  }

  void meet(const Grain& a, const Grain& b) {
    const Triple apart = scene_.centre(a.body) - scene_.centre(b.body);
    const double distance = length(apart);
    if (distance >= a.radius + b.radius) return;
    touch(a, b, scene_.centre(b.body) + b.radius / (a.radius + b.radius) * apart, 1 / distance * apart);
  }

  Scene& scene_;
  int columns_, layers_;
  std::vector<Grain> grains_;
};

}  // namespace

// Balls and cubes in a box, under a heavy lid. Odd layers are shifted by half a metre: their far walls stand that much
// further out, and they touch no near wall.
void build_packing(Scene& scene) {
  const double cubes = scene.chance(0.5) ? 0 : scene.uniform(0, 0.6);
  const double per_grain = 3.4 + 6 * cubes * cubes;
  const double grains = scene.goal() / per_grain;
  const int layers = Scene::count(std::sqrt(std::sqrt(grains)) * scene.uniform(0.7, 2), 1);
  const int columns = Scene::count(std::sqrt(grains / layers) + 0.5, 1);
  Pile pile(scene, columns, layers, cubes);
  const bool has_lid = scene.chance(0.7);
  const double top = 0.5 + kLayer * (layers - 1) + 0.5;
  const double lid_mass = 1000.0 * columns * columns * scene.log_uniform(1, 100);
  const Grain lid{has_lid ? scene.box(lid_mass, {1.0 * columns, 1.0 * columns, 0.2},
                                      {0.5 * columns - 0.25, 0.5 * columns - 0.25, top + 0.1})
                          : kWorld,
                  0.5, true};
  pile.touch_all([&](const Grain& grain) {
    const Triple& centre = scene.centre(grain.body);
    const double far = columns - 0.5;
    for (const std::size_t axis : {0U, 1U}) {
      const Triple inward = kWorldAxes[axis];
      if (centre[axis] + 0.5 < grain.radius + 0.05) pile.touch(grain, {}, centre - grain.radius * inward, inward);
      if (far - centre[axis] < grain.radius + 0.05) pile.touch(grain, {}, centre + grain.radius * inward, -inward);
    }
    if (has_lid && top - centre[2] < grain.radius + 0.2) {
      pile.touch({lid.body, 0.5, grain.is_cube}, grain, {centre[0], centre[1], top}, kZ);
    }
  });
}

// A robot that lies on a heap of balls.
void build_robot_pile(Scene& scene) {
  const double goal = scene.goal();
  const int layers = Scene::count(std::sqrt(std::sqrt(goal)) / 2, 1);
  const int columns = Scene::count(std::sqrt(goal / (2.6 * layers)), 2);
  Pile pile(scene, columns, layers, 0);
  pile.touch_all([](const Grain&) {});
  const double top = kLayer * (layers - 1) + 1;
  const double middle = 0.5 * (columns - 1);
  const int link_count = scene.integer(6, Scene::count(std::min(goal / 3, 54.0), 6));
  const double condition = scene.log_uniform(1e2, 1e6);
  const std::vector<Link> links = random_tree(scene, {middle, middle, top}, link_count, 0.5, 5, 1 / condition);
  const int robot = scene.robot(50, {middle, middle, top + 0.1}, true, links, condition);
  for (int k = 0; k <= link_count; ++k) {
    const Triple& centre = scene.centre(robot + k);
    const auto column = [&](double x) { return x < 0 ? 0 : (x > columns - 1 ? columns - 1 : static_cast<int>(x)); };
    const double shift = (layers - 1) % 2 == 0 ? 0.5 : 0;
    const Grain& grain = pile.at(column(centre[0] + shift), column(centre[1] + shift), layers - 1);
    const Triple& below = scene.centre(grain.body);
    const Triple apart = centre - below;
    const Triple normal = unit({0.5 * apart[0], 0.5 * apart[1], 1});
    scene.touch(robot + k, grain.body, below + grain.radius * normal, normal);
  }
}

}  // namespace lcpbench::made
