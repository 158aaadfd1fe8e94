#pragma once

#include <cstdint>
#include <vector>

#include "core/scene.h"

namespace lcpbench::testing {

struct SpherePile {
  int columns = 6;  ///< along x and y
  int layers = 8;
  double mu = 0;
  double disorder = 0.35;  ///< of the positions on the lattice, in diameters
  double speed = 0.02;     ///< of random velocities, beside one step's gravity
  std::uint64_t seed = 7;
  double spread = 0;  ///< of the diameters about 1, in [0, 1)
};

/// Spheres of diameter about 1 and of equal density near the places of a body-centred lattice, with a contact where two
/// overlap or one meets the ground. A pile as deep as it is wide has separators of the power 2/3 of its spheres.
inline RigidScene sphere_pile(const SpherePile& pile) {
  RigidScene scene;
  std::vector<double> radii;
  std::uint64_t state = pile.seed;
  const auto random = [&state] {  // in [-1, 1), the high bits of a linear congruence
    state = state * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(state >> 40) * 0x1p-23 - 1;
  };
  const auto number = [&pile](int x, int y, int layer) { return (layer * pile.columns + y) * pile.columns + x; };
  for (int layer = 0; layer < pile.layers; ++layer) {
    const double shift = layer % 2 == 0 ? 0.0 : 0.5;
    for (int y = 0; y < pile.columns; ++y) {
      for (int x = 0; x < pile.columns; ++x) {
        const double diameter = pile.spread > 0 ? 1 + pile.spread * random() : 1.0;
        radii.push_back(diameter / 2);
        RigidBody sphere;
        sphere.mass = diameter * diameter * diameter;
        sphere.inertia = 0.1 * sphere.mass * diameter * diameter * Eigen::Matrix3d::Identity();
        sphere.position = {x + shift, y + shift, 0.5 + 0.7071 * layer};
        for (double& coordinate : sphere.position) coordinate += pile.disorder * random();
        sphere.linear_velocity.z() = -0.0981;
        for (double& speed : sphere.linear_velocity) speed += pile.speed * random();
        for (double& speed : sphere.angular_velocity) speed = pile.speed * random();
        scene.bodies.push_back(sphere);
      }
    }
  }
  const auto add = [&](int above, int below) {
    const Eigen::Vector3d at = scene.bodies[static_cast<std::size_t>(above)].position;
    const double radius = radii[static_cast<std::size_t>(above)];
    RigidContact contact;
    contact.body_a = above;
    contact.body_b = below;
    contact.mu = pile.mu;
    contact.edges = pile.mu > 0 ? 4 : 0;
    if (below == RigidContact::kWorld) {
      if (at.z() > radius + 0.1) return;
      contact.point = {at.x(), at.y(), 0};
    } else {
      const Eigen::Vector3d apart = at - scene.bodies[static_cast<std::size_t>(below)].position;
      const double reach = radius + radii[static_cast<std::size_t>(below)];
      if (apart.squaredNorm() >= reach * reach) return;
      contact.normal = apart.normalized();
      contact.tangent = contact.normal.cross(Eigen::Vector3d::UnitX()).normalized();
      contact.point = at - radius / reach * apart;
    }
    scene.contacts.push_back(contact);
  };
  const auto is_inside = [&pile](int x, int y) { return x >= 0 && y >= 0 && x < pile.columns && y < pile.columns; };
  for (int layer = 0; layer < pile.layers; ++layer) {
    for (int y = 0; y < pile.columns; ++y) {
      for (int x = 0; x < pile.columns; ++x) {
        const int own = number(x, y, layer);
        add(own, RigidContact::kWorld);
        if (x > 0) add(own, number(x - 1, y, layer));
        if (y > 0) add(own, number(x, y - 1, layer));
        for (int k = 0; k < 9 && layer > 0; ++k) {
          const int other_x = x + k % 3 - 1;
          const int other_y = y + k / 3 - 1;
          if (is_inside(other_x, other_y)) add(own, number(other_x, other_y, layer - 1));
        }
      }
    }
  }
  return scene;
}

}  // namespace lcpbench::testing
