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

}  // namespace lcpbench::testing
