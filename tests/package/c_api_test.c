/* What a program in C99 relies on: the header and the library, and nothing else of this project. */
#include <lcpbench/lcpbench_c.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static int faults = 0;

static void expect(int holds, const char* what) {
  if (holds) return;
  ++faults;
  printf("does not hold: %s; the text is '%s'\n", what, lcpbench_error_text());
}
#define EXPECT(condition) expect(condition, #condition)

static int says(const char* words) { return strstr(lcpbench_error_text(), words) != NULL; }

/* A box on the floor and a smaller one on top of it, both falling for 10 ms: eight contacts with friction. */
static const double mass[2] = {1.2, 0.5};
static const double inertia[18] = {0.02, 1e-3, 0, 1e-3, 0.02, 0, 0, 0, 0.032, 0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01};
static const double position[6] = {0, 0, 0.1, 0, 0, 0.3};
static const double velocity[12] = {0.02, 0, -0.0981, 0, 0, 0, 0.02, 0, -0.0981, 0, 0, 0};
static double point[24], normal[24], mu[8];
static int32_t body_a[8], body_b[8];
static uint64_t id[8];

static lcpbench_scene boxes(void) {
  for (int i = 0; i < 8; ++i) {
    const int upper = i / 4;
    point[3 * i] = i % 2 ? 0.1 : -0.1;
    point[3 * i + 1] = i % 4 < 2 ? 0.1 : -0.1;
    point[3 * i + 2] = 0.2 * upper;
    normal[3 * i + 2] = 1;
    mu[i] = 0.5;
    body_a[i] = upper;
    body_b[i] = upper - 1;
    id[i] = (uint64_t)i + 1;
  }
  const lcpbench_scene scene = {.bodies = 2,
                                .mass = mass,
                                .inertia = inertia,
                                .position = position,
                                .velocity = velocity,
                                .contacts = 8,
                                .body_a = body_a,
                                .body_b = body_b,
                                .point = point,
                                .normal = normal,
                                .mu = mu,
                                .id = id};
  return scene;
}

static void boxes_stop(const char* spec) {
  lcpbench_scene scene = boxes();
  lcpbench_solver* solver = NULL;
  lcpbench_claim claim = LCPBENCH_NOT_SOLVED_YET;
  double v[12], impulses[24], lower = 0, upper = 0, sideways = 0;
  EXPECT(lcpbench_create(spec, &solver) == LCPBENCH_OK);
  EXPECT(lcpbench_update(solver, &scene) == LCPBENCH_OK);
  EXPECT(lcpbench_get_claim(solver, &claim) == LCPBENCH_OK && claim == LCPBENCH_NOT_SOLVED_YET);
  EXPECT(lcpbench_get_velocity(solver, v, 12) == LCPBENCH_OK && memcmp(v, velocity, sizeof v) == 0);
  for (int step = 0; step < 2; ++step) {
    EXPECT(lcpbench_solve(solver, INFINITY, &claim) == LCPBENCH_OK && claim == LCPBENCH_SOLVED);
    EXPECT(lcpbench_update(solver, &scene) == LCPBENCH_OK);
  }
  EXPECT(lcpbench_solve(solver, INFINITY, NULL) == LCPBENCH_OK && says(""));
  EXPECT(lcpbench_get_claim(solver, &claim) == LCPBENCH_OK && claim == LCPBENCH_SOLVED);
  EXPECT(lcpbench_get_velocity(solver, v, 12) == LCPBENCH_OK);
  EXPECT(lcpbench_get_impulses(solver, impulses, 24) == LCPBENCH_OK);
  for (int i = 0; i < 12; ++i) EXPECT(fabs(v[i]) <= 1e-9);
  for (int i = 0; i < 4; ++i) {
    lower += impulses[3 * i + 2];
    upper += impulses[12 + 3 * i + 2];
    sideways += impulses[3 * i];
  }
  EXPECT(fabs(lower - 1.7 * 0.0981) <= 1e-9);
  EXPECT(fabs(upper - 0.5 * 0.0981) <= 1e-9);
  EXPECT(fabs(sideways + 1.7 * 0.02) <= 1e-9);
  scene.mu = NULL; /* no friction: they slide on */
  EXPECT(lcpbench_update(solver, &scene) == LCPBENCH_OK);
  EXPECT(lcpbench_solve(solver, INFINITY, &claim) == LCPBENCH_OK && claim == LCPBENCH_SOLVED);
  EXPECT(lcpbench_get_velocity(solver, v, 12) == LCPBENCH_OK && fabs(v[0] - 0.02) <= 1e-9 && fabs(v[8]) <= 1e-9);
  lcpbench_destroy(solver);
}

/* Two sweeps a step do not suffice, but each step goes on from the last: as the ids say. */
static int steps_until_solved(const uint64_t* ids) {
  lcpbench_scene scene = boxes();
  lcpbench_solver* solver = NULL;
  lcpbench_claim claim = LCPBENCH_NOT_SOLVED_YET;
  int steps = 0;
  scene.id = ids;
  EXPECT(lcpbench_create("psor{max_iterations=2}", &solver) == LCPBENCH_OK);
  while (claim != LCPBENCH_SOLVED && steps < 3000) {
    ++steps;
    EXPECT(lcpbench_update(solver, &scene) == LCPBENCH_OK);
    EXPECT(lcpbench_solve(solver, INFINITY, &claim) == LCPBENCH_OK);
  }
  lcpbench_destroy(solver);
  return steps;
}

static void misuse_is_an_error(void) {
  lcpbench_scene scene = boxes();
  lcpbench_solver* solver = NULL;
  lcpbench_claim claim = LCPBENCH_SOLVED;
  double v[12], impulses[24];
  EXPECT(lcpbench_create("simplex", &solver) == LCPBENCH_BAD_INPUT && solver == NULL &&
         says("unknown solver 'simplex'"));
  EXPECT(lcpbench_create(NULL, &solver) == LCPBENCH_MISUSE && says("spec is NULL"));
  EXPECT(lcpbench_create("auto", NULL) == LCPBENCH_MISUSE);
  EXPECT(lcpbench_solve(NULL, 1, NULL) == LCPBENCH_MISUSE && says("solver is NULL"));
  lcpbench_destroy(NULL);
  EXPECT(lcpbench_create("contact_lemke", &solver) == LCPBENCH_OK && strlen(lcpbench_error_text()) == 0);
  EXPECT(lcpbench_solve(solver, 1, NULL) == LCPBENCH_MISUSE && says("lcpbench_update"));
  EXPECT(lcpbench_set_velocity(solver, velocity, 12) == LCPBENCH_MISUSE);
  EXPECT(lcpbench_get_velocity(solver, v, 12) == LCPBENCH_MISUSE);
  EXPECT(lcpbench_get_impulses(solver, impulses, 24) == LCPBENCH_MISUSE);
  EXPECT(lcpbench_update(solver, NULL) == LCPBENCH_MISUSE && says("scene is NULL"));
  scene.normal = NULL;
  EXPECT(lcpbench_update(solver, &scene) == LCPBENCH_MISUSE && says("normal is NULL"));
  scene = boxes();
  EXPECT(lcpbench_update(solver, &scene) == LCPBENCH_OK);
  body_a[3] = 7;
  EXPECT(lcpbench_update(solver, &scene) == LCPBENCH_BAD_INPUT && says("contacts[3].body_a is 7"));
  scene = boxes();
  normal[11] = 0;
  EXPECT(lcpbench_update(solver, &scene) == LCPBENCH_BAD_INPUT && says("contacts[3].normal has length 0, expected 1"));
  EXPECT(lcpbench_set_velocity(solver, velocity, 6) == LCPBENCH_BAD_INPUT && says("6 numbers, expected 12"));
  EXPECT(lcpbench_get_velocity(solver, v, 11) == LCPBENCH_BAD_INPUT);
  EXPECT(lcpbench_get_impulses(solver, NULL, 24) == LCPBENCH_MISUSE);
  EXPECT(lcpbench_solve(solver, NAN, NULL) == LCPBENCH_BAD_INPUT && says("seconds"));
  EXPECT(lcpbench_solve(solver, 0, &claim) == LCPBENCH_OK && claim == LCPBENCH_TIME_LIMIT);
  EXPECT(lcpbench_get_impulses(solver, impulses, 24) == LCPBENCH_OK && impulses[2] == 0);
  EXPECT(lcpbench_solve(solver, INFINITY, &claim) == LCPBENCH_OK && claim == LCPBENCH_SOLVED); /* after all this */
  lcpbench_destroy(solver);
}

int main(void) {
  boxes_stop("auto");
  boxes_stop("contact_lemke");
  const int steps = steps_until_solved(id);
  EXPECT(steps > 1 && steps < 3000 && steps_until_solved(NULL) == 3000);
  misuse_is_an_error();
  printf("%d faults\n", faults);
  return faults != 0;
}
