#pragma once

#include "core/problem.h"
#include "core/scene.h"

namespace lcpbench::testing {

/// Cubes of unit mass and edge on each other, moved down by `fall` and along x by `slide`.
inline Problem cube_stack(int bodies, int edges, double fall, double slide) {
  RigidScene scene;
  for (int b = 0; b < bodies; ++b) {
    RigidBody body;
    body.inertia = Eigen::Matrix3d::Identity() / 6;
    body.position = {0, 0, b + 0.5};
    body.linear_velocity = {slide, 0.0, -fall};
    scene.bodies.push_back(body);
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.5, 0.5}) {
        RigidContact contact;
        contact.body_a = b;
        contact.body_b = b == 0 ? RigidContact::kWorld : b - 1;
        contact.point = {x, y, static_cast<double>(b)};
        contact.mu = edges > 0 ? 0.5 : 0.0;
        contact.edges = edges;
        scene.contacts.push_back(contact);
      }
    }
  }
  return Problem("stack", scene);
}

}  // namespace lcpbench::testing
