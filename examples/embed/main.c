/* The box of main.cpp in C99. docs/howto/embedding.md says how to link it. */
#include <lcpbench/lcpbench_c.h>
#include <math.h>
#include <stdio.h>

int main(void) {
  const double mass = 1.2, inertia[9] = {0.02, 0, 0, 0, 0.02, 0, 0, 0, 0.032}, position[3] = {0, 0, 0.1};
  const double point[12] = {-0.2, -0.2, 0, -0.2, 0.2, 0, 0.2, -0.2, 0, 0.2, 0.2, 0};
  const double normal[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, mu[4] = {0.3, 0.3, 0.3, 0.3};
  const double tangent[12] = {1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0};
  const int32_t body[4] = {0, 0, 0, 0}, world[4] = {-1, -1, -1, -1};
  const double h = 0.01, slope = 20 * 3.14159265358979323846 / 180;
  double v[6] = {0, 0, 0, 0, 0, 0}, impulses[12];
  const lcpbench_scene scene = {.bodies = 1,
                                .mass = &mass,
                                .inertia = inertia,
                                .position = position,
                                .velocity = v,
                                .contacts = 4,
                                .body_a = body,
                                .body_b = world,
                                .point = point,
                                .normal = normal,
                                .tangent = tangent,
                                .mu = mu};
  lcpbench_solver* solver;
  lcpbench_claim claim = LCPBENCH_NOT_SOLVED_YET;
  int failed = lcpbench_create("auto", &solver) || lcpbench_update(solver, &scene);
  for (int step = 0; step < 100 && !failed; ++step) {
    v[0] += h * 9.81 * sin(slope);
    v[2] -= h * 9.81 * cos(slope);
    failed = lcpbench_set_velocity(solver, v, 6) || lcpbench_solve(solver, INFINITY, &claim) ||
             claim != LCPBENCH_SOLVED || lcpbench_get_velocity(solver, v, 6);
  }
  failed = failed || lcpbench_get_impulses(solver, impulses, 12);
  if (failed)
    fprintf(stderr, "%s\n", lcpbench_error_text());
  else
    printf("speed %.6f m/s, force on a lower corner %.4f N\n", v[0],
           sqrt(impulses[6] * impulses[6] + impulses[8] * impulses[8]) / h);
  lcpbench_destroy(solver);
  return failed;
}
