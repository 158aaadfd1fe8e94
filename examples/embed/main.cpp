// A box slides down a slope of 20 degrees for one second: one contact problem per step of 10 ms.
#include <cmath>
#include <cstdio>

#include <lcpbench/lcpbench.h>

int main() {
  lcpbench::RigidScene scene;
  scene.bodies.resize(1);
  scene.bodies[0].mass = 1.2;
  scene.bodies[0].inertia = Eigen::Vector3d(0.02, 0.02, 0.032).asDiagonal();
  scene.bodies[0].position = {0, 0, 0.1};  // axes of the slope: x down, z out of it
  for (const double x : {-0.2, 0.2}) {
    for (const double y : {-0.2, 0.2}) scene.contacts.push_back({.point = {x, y, 0}, .mu = 0.3, .edges = 4});
  }
  const double h = 0.01, slope = 20 * M_PI / 180;
  const Eigen::Vector3d gravity = 9.81 * Eigen::Vector3d(std::sin(slope), 0, -std::cos(slope));
  Eigen::VectorXd v = Eigen::VectorXd::Zero(6);  // m/s, rad/s
  lcpbench::ContactSolver solver("auto");
  solver.load(scene);  // and update(scene, ids) whenever contacts or inertia change
  for (int step = 0; step < 100; ++step) {
    v.head<3>() += h * gravity;
    solver.set_velocity(v);
    if (solver.solve() != lcpbench::Claim::kSolved) return std::puts(solver.answer().detail.c_str()), 1;
    v = solver.velocity();
  }
  std::printf("speed %.6f m/s, g (sin - mu cos) = %.6f m/s; ", v(0), gravity(0) + 0.3 * gravity(2));
  std::printf("force on a lower corner %.4f N\n", solver.impulse(2).norm() / h);
}
