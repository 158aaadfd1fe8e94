#pragma once

#include "core/scene.h"

namespace lcpbench::testing {

/// A wall of bricks in running bond at the first instant after standing still: every brick falls with one step's
/// gravity and is disturbed a little. Frictionless.
///
/// Bricks measure 2 x 1 x 1 and weigh 2; each rests with four contacts on the overlap (1 x 1) with each brick below it,
/// those of the lowest row with four on the ground. Bed joints only: 4 columns + about 8 columns (rows - 1) contacts,
/// more than twice as many as the three coordinates of each brick that they act on.
inline RigidScene brick_wall(int rows, int columns) {
  RigidScene scene;
  const auto add_joint = [&](int above, int below, double left, double right, double height) {
    for (const double x : {left, right}) {
      for (const double y : {-0.5, 0.5}) {
        RigidContact contact;
        contact.body_a = above;
        contact.body_b = below;
        contact.point = {x, y, height};
        scene.contacts.push_back(contact);
      }
    }
  };
  for (int row = 0; row < rows; ++row) {
    const double shift = row % 2 == 0 ? 0.0 : 1.0;
    for (int column = 0; column < columns; ++column) {
      const int index = row * columns + column;
      RigidBody brick;
      brick.mass = 2;
      brick.inertia = Eigen::Vector3d(2, 5, 5).asDiagonal();
      brick.inertia /= 6;
      brick.position = {2.0 * column + shift, 0, row + 0.5};
      // Reproducible and without pattern: the index times the golden ratio, modulo 1.
      const double phase = index * 0.6180339887498949;
      const double disturbance = phase - static_cast<double>(static_cast<long>(phase)) - 0.5;
      brick.linear_velocity = {0, 0, -0.01 - 0.005 * disturbance};
      brick.angular_velocity = {0.01 * disturbance, -0.004 * disturbance, 0};
      scene.bodies.push_back(brick);
      const double x = brick.position.x();
      if (row == 0) {
        add_joint(index, RigidContact::kWorld, x - 1, x + 1, 0);
        continue;
      }
      const int left = column - (row % 2 == 0 ? 1 : 0);
      if (left >= 0) add_joint(index, (row - 1) * columns + left, x - 1, x, row);
      if (left + 1 < columns) add_joint(index, (row - 1) * columns + left + 1, x, x + 1, row);
    }
  }
  return scene;
}

/// The wall with Coulomb friction mu > 0 (four edges) at every contact, its bricks pushed sideways, along the wall and
/// out of it, by as much as they fall: some contacts stick, some slide, some open.
inline RigidScene frictional_brick_wall(int rows, int columns, double mu) {
  RigidScene scene = brick_wall(rows, columns);
  for (RigidContact& contact : scene.contacts) {
    contact.mu = mu;
    contact.edges = 4;
  }
  for (RigidBody& brick : scene.bodies) {
    const double disturbance = brick.angular_velocity.x();  // within 0.005 of 0
    brick.linear_velocity.x() = 2 * disturbance;
    brick.linear_velocity.y() = 0.005 - disturbance;
  }
  return scene;
}

}  // namespace lcpbench::testing
