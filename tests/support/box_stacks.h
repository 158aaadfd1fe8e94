#pragma once

#include "core/scene.h"

namespace lcpbench::testing {

/// Stacks of unit cubes that stand apart from each other on the ground z = 0, at the first instant after rest: each
/// cube falls with one step's gravity and is disturbed a little. One stack is one island.
struct BoxStacks {
  int stacks = 1;
  int height = 1;
  int edges = 4;        ///< friction directions of each contact; 0: frictionless
  double mu = 0.5;      ///< where edges > 0
  int lifted = 0;       ///< every so many-th stack flies up as one: none of its contacts approaches; 0: none
  double slide = 0;     ///< speed of all cubes along x
  double jitter = 0.1;  ///< disturbance as part of gravity's step
  double fresh = 1;     ///< part of the disturbance that each step draws anew; the rest is that of step 0
};

/// In [-1/2, 1/2], without pattern and the same everywhere: the number times the golden ratio, modulo 1.
inline double disturbance(long number) {
  const double phase = static_cast<double>(number) * 0.6180339887498949;
  return phase - static_cast<double>(static_cast<long>(phase)) - 0.5;
}

/// Velocity of all cubes in one time step, six entries per cube: gravity's 0.1 m/s and the step's own disturbance.
inline Vector falling_velocity(const BoxStacks& shape, int step) {
  const int bodies = shape.stacks * shape.height;
  Vector v(6 * bodies);
  for (int b = 0; b < bodies; ++b) {
    const bool up = shape.lifted > 0 && (b / shape.height) % shape.lifted == shape.lifted - 1;
    const double size = 0.1 * (up ? 0 : shape.jitter);
    const long number = 6L * (static_cast<long>(step) * bodies + b);
    for (int i = 0; i < 6; ++i) {
      const double lasting = disturbance(6L * b + i + 1);
      v(6 * b + i) = size * (shape.fresh * disturbance(number + i + 1) + (1 - shape.fresh) * lasting);
    }
    v(6 * b) += shape.slide;
    v(6 * b + 2) += up ? 0.5 + 0.25 * (b % shape.height) : -0.1;
  }
  return v;
}

inline RigidScene box_stacks(const BoxStacks& shape) {
  RigidScene scene;
  const Vector v = falling_velocity(shape, 0);
  for (int b = 0; b < shape.stacks * shape.height; ++b) {
    const int level = b % shape.height;
    const double x0 = 3.0 * (b / shape.height);
    RigidBody body;
    body.inertia = Eigen::Matrix3d::Identity() / 6;
    body.position = {x0, 0, level + 0.5};
    body.linear_velocity = v.segment<3>(6 * b);
    body.angular_velocity = v.segment<3>(6 * b + 3);
    scene.bodies.push_back(body);
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.5, 0.5}) {
        RigidContact contact;
        contact.body_a = b;
        contact.body_b = level == 0 ? RigidContact::kWorld : b - 1;
        contact.point = {x0 + x, y, static_cast<double>(level)};
        contact.mu = shape.edges > 0 ? shape.mu : 0.0;
        contact.edges = shape.edges;
        scene.contacts.push_back(contact);
      }
    }
  }
  return scene;
}

}  // namespace lcpbench::testing
