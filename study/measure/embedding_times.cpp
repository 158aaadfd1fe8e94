// What a time step costs a simulator: CSV rows for stacks of boxes with friction, thread CPU time. Not a test;
// results/native/README.md has its command.
//
//   embedding_times STEPS SOLVER...
//
// load: load(scene), as when contacts change; step: set_velocity, solve and velocity, under gravity and a push that
// changes from step to step. Means over STEPS of each.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include <lcpbench/lcpbench.h>

namespace {

using namespace lcpbench;

double cpu_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

/// Boxes of 0.4 m x 0.4 m x 0.2 m on one another, four contacts between each two.
RigidScene stack(int boxes) {
  RigidScene scene;
  for (int b = 0; b < boxes; ++b) {
    RigidBody& box = scene.bodies.emplace_back();
    box.mass = 1.2;
    box.inertia = Eigen::Vector3d(0.02, 0.02, 0.032).asDiagonal();
    box.position = {0, 0, 0.1 + 0.2 * b};
    for (const double x : {-0.2, 0.2}) {
      for (const double y : {-0.2, 0.2}) {
        scene.contacts.push_back({.body_a = b, .body_b = b - 1, .point = {x, y, 0.2 * b}, .mu = 0.5, .edges = 4});
      }
    }
  }
  return scene;
}

Vector velocity_of_step(int boxes, int step) {
  Vector v = Vector::Zero(6 * boxes);
  for (int b = 0; b < boxes; ++b) {
    v(6 * b) = 0.02 * std::sin(0.1 * step + b);
    v(6 * b + 2) = -0.0981;
  }
  return v;
}

void measure(const char* spec, int boxes, int steps) {
  ContactSolver solver(spec);
  const RigidScene scene = stack(boxes);
  solver.load(scene);
  solver.solve();
  double begin = cpu_us();
  for (int i = 0; i < steps; ++i) solver.load(scene);
  const double load_us = (cpu_us() - begin) / steps;
  double step_us = 0;
  int solved = 0;
  for (int step = 0; step < steps; ++step) {
    const Vector v = velocity_of_step(boxes, step);
    begin = cpu_us();
    solver.set_velocity(v);
    solved += solver.solve() == Claim::kSolved;
    step_us += cpu_us() - begin;
  }
  std::printf("\"%s\",%d,%zu,%d,%d,%.2f,%.2f\n", spec, boxes, scene.contacts.size(), steps, solved, load_us,
              step_us / steps);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "embedding_times STEPS SOLVER...\n");
    return 2;
  }
  std::printf("solver,boxes,contacts,steps,solved,load_us,step_us\n");
  for (int i = 2; i < argc; ++i) {
    for (const int boxes : {1, 2, 5, 10}) measure(argv[i], boxes, std::atoi(argv[1]));
  }
}
