#pragma once

#include "core/scene.h"

namespace lcpbench::testing {

/// A row of planks on the ground that touch end to end: one island of 4 planks - 1 contacts. Each comes down at its
/// support and goes up, faster, at the two corners of its far end, until the support's impulse swings these down:
/// contacts that separate faster than any other approaches, and press nevertheless. They are half of all.
inline RigidScene seesaws(int planks, int edges) {
  RigidScene scene;
  constexpr double kSupport = 1, kFarEnd = -3;  // from the centre of mass along y
  const auto add = [&](RigidContact contact) {
    contact.mu = edges > 0 ? 0.25 : 0.0;
    contact.edges = edges;
    scene.contacts.push_back(contact);
  };
  for (int p = 0; p < planks; ++p) {
    RigidBody plank;
    plank.inertia = Eigen::Vector3d(0.125, 0.5, 0.5).asDiagonal();
    plank.position = {2.0 * p, 0, 0.5};
    // -1 m/s at the support and 1.5 m/s at the far end, with a little difference from plank to plank.
    const double size = 1 + 0.001 * (p % 7);
    plank.linear_velocity = {0, 0, -0.375 * size};
    plank.angular_velocity = {-0.625 * size, 0, 0};
    scene.bodies.push_back(plank);
    add({.body_a = p, .point = {2.0 * p, kSupport, 0.5}});
    for (const double x : {-0.25, 0.25}) add({.body_a = p, .point = {2.0 * p + x, kFarEnd, 0.5}});
    if (p == 0) continue;
    add({.body_a = p,
         .body_b = p - 1,
         .point = {2.0 * p - 1, 0, 0.75},
         .normal = Eigen::Vector3d::UnitX(),
         .tangent = Eigen::Vector3d::UnitY()});
  }
  return scene;
}

/// A plank at rest on a pivot. A stack of heavy cubes falls on its short arm; above its long arm a stack of light ones
/// flies apart, slower than the arm will strike it: of the contacts that separate faster than any approaches the lowest
/// press, and through them those above. One island of 4 (falling + flying + 1) contacts, 4 flying of which separate.
inline RigidScene catapult(int falling, int flying) {
  RigidScene scene;
  const auto add_body = [&](double mass, const Eigen::Vector3d& position, double rising) {
    RigidBody body;
    body.mass = mass;
    body.inertia = mass / 6 * Eigen::Matrix3d::Identity();
    body.position = position;
    body.linear_velocity = {0, 0, rising};
    scene.bodies.push_back(body);
    return static_cast<int>(scene.bodies.size()) - 1;
  };
  const auto add_contacts = [&](int upper, int lower, const Eigen::Vector3d& centre, double half_width) {
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-half_width, half_width}) {
        scene.contacts.push_back({.body_a = upper, .body_b = lower, .point = centre + Eigen::Vector3d(x, y, 0)});
      }
    }
  };
  constexpr double kShortArm = 1, kLongArm = -6;  // along y
  const int plank = add_body(1, {0, 0, 0}, 0);
  add_contacts(plank, RigidContact::kWorld, {0, 0, 0}, 0.01);
  const auto stack = [&](double y, int count, double mass, double rising, double faster) {
    for (int k = 0, below = plank; k < count; ++k) {
      const int cube = add_body(mass, {0, y, k + 0.5}, rising + faster * k);
      add_contacts(cube, below, {0, y, 1.0 * k}, 0.5);
      below = cube;
    }
  };
  stack(kShortArm, falling, 1000, -1, 0);
  stack(kLongArm, flying, 1, 1.1, 1.1);
  return scene;
}

}  // namespace lcpbench::testing
