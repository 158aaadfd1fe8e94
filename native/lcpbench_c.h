#ifndef LCPBENCH_C_H
#define LCPBENCH_C_H

#include <stddef.h>
#include <stdint.h>

/* Contact solvers for programs in C99 and for whatever calls C: a thin layer over ContactSolver of
 * <lcpbench/lcpbench.h>, for rigid bodies. Installed as <lcpbench/lcpbench_c.h>; docs/howto/embedding.md shows its use.
 *
 * Every function returns 0 (LCPBENCH_OK) or another lcpbench_status, and then lcpbench_error_text() says why, in one
 * line. A call that is refused leaves the solver as it was. Nothing is thrown. One solver is for one thread at a time:
 * a call while another thread is inside the same solver is LCPBENCH_MISUSE. Solvers share nothing. Arrays belong to the
 * caller, and are read or written during the call alone. Units are SI: kg, m, s; velocities m/s and rad/s; impulses N
 * s.
 */
#ifdef __cplusplus
extern "C" {
#endif

typedef enum lcpbench_status {
  LCPBENCH_OK = 0,
  LCPBENCH_BAD_INPUT = 1, /* a name, a number or a size: the text names it */
  LCPBENCH_MISUSE = 2,    /* a null pointer, a solve before the first update, a solver that another thread uses */
  LCPBENCH_FAILED = 3     /* no memory, or a defect of lcpbench */
} lcpbench_status;

typedef enum lcpbench_claim {
  LCPBENCH_SOLVED = 0,     /* every condition holds to the solver's tolerance */
  LCPBENCH_UNSOLVABLE = 1, /* no impulses satisfy the normal rows: only with a negative b */
  LCPBENCH_ITERATION_LIMIT = 2,
  LCPBENCH_TIME_LIMIT = 3,
  LCPBENCH_NUMERICAL_FAILURE = 4,
  LCPBENCH_UNSUPPORTED = 5,
  LCPBENCH_NOT_SOLVED_YET = 6 /* since the last update or new velocity */
} lcpbench_claim;

/* Free bodies and their contacts, in world axes, row by row. The conditions on each number are those of RigidScene. */
typedef struct lcpbench_scene {
  size_t bodies;
  const double* mass;     /* bodies */
  const double* inertia;  /* bodies x 9, about the centre of mass */
  const double* position; /* bodies x 3, of the centre of mass */
  const double* velocity; /* bodies x 6, without contacts: linear, angular */

  size_t contacts;
  const int32_t* body_a; /* contacts: the body that the normal points into, from 0 */
  const int32_t* body_b; /* contacts: the other one; -1 is the immovable world */
  const double* point;   /* contacts x 3 */
  const double* normal;  /* contacts x 3, unit vectors */
  const double* tangent; /* contacts x 3, unit vectors: the first direction of friction; NULL: any */
  const double* mu;      /* contacts; NULL: no friction. Where it is 0 the contact has none */

  /* From here on NULL stands for zeros. */
  const double* b;            /* contacts: offset of the normal velocity, for gaps, restitution, corrections */
  const double* compliance_n; /* contacts: m/s per N s */
  const double* compliance_t; /* contacts: the same, 0 without friction */
  const double* offset_t;     /* contacts x 2: offset of the velocity along both tangents */
  const uint64_t* id; /* contacts: the name that a contact keeps from step to step; NULL: every step starts anew */
} lcpbench_scene;

typedef struct lcpbench_solver lcpbench_solver;

/* Makes a solver, such as "auto" or "contact_lemke{precision=double}", or sets *solver to NULL. */
int lcpbench_create(const char* spec, lcpbench_solver** solver);

/* NULL is allowed. No call may be under way, nor follow. */
void lcpbench_destroy(lcpbench_solver* solver);

/* Takes the bodies and contacts of a step; the next solve starts from the last impulses, contact by contact as the ids
 * match. Copies the arrays. O(bodies + contacts) and the solver's own work on the matrices. */
int lcpbench_update(lcpbench_solver* solver, const lcpbench_scene* scene);

/* Another velocity, size = 6 bodies numbers, for the same bodies and contacts. */
int lcpbench_set_velocity(lcpbench_solver* solver, const double* velocity, size_t size);

/* Solves what is loaded in at most `seconds` of wall clock (INFINITY: no limit; only some solvers obey it). *claim
 * (unless NULL) gets the claim. Any claim is LCPBENCH_OK; where it is not solved, lcpbench_error_text() has the reason.
 */
int lcpbench_solve(lcpbench_solver* solver, double seconds, lcpbench_claim* claim);

/* The claim of the last solve. */
int lcpbench_get_claim(lcpbench_solver* solver, lcpbench_claim* claim);

/* Writes the velocities after the impact, size = 6 bodies; those given unless solved. */
int lcpbench_get_velocity(lcpbench_solver* solver, double* velocity, size_t size);

/* Writes the impulse on body_a of each contact, in world axes, size = 3 contacts; 0 unless solved. body_b gets its
 * negative. */
int lcpbench_get_impulses(lcpbench_solver* solver, double* impulses, size_t size);

/* One line on the last call of this thread that did not return LCPBENCH_OK, or on a solve that did not solve; else "".
 * Valid until the next call of this thread. */
const char* lcpbench_error_text(void);

#ifdef __cplusplus
}
#endif

#endif
