/* capture.h: writes the contact problems of a simulation's steps into an lcpbench `.scenes` file.
 *
 *   lcpbench_capture* c = lcpbench_capture_open("failing.scenes", "my scene", "my engine", "1.0", 0.01);
 *   lcpbench_capture_step(c, step, time);
 *   for each body:     lcpbench_capture_body(c, mass, inertia, position, linear_velocity, angular_velocity);
 *   for each contact:  lcpbench_capture_contact(c, a, b, point, normal, tangent, mu, 4, 0.0, NULL);
 *   lcpbench_capture_end_step(c);
 *   lcpbench_capture_close(c);
 *
 * Then: lcpbench solve 'failing.scenes#120'
 *
 * C99 and C++; no dependency but the C library (a C program links its mathematics with -lm). Velocities are those that
 * enter the impact: those of the last step plus step length times inverse inertia times forces, without contacts.
 * Units: m, kg, s. Every function accepts a null pointer for the capture and then does nothing.
 *
 * SPDX-License-Identifier: MIT
 *
 * Copyright 2026 the lcpbench maintainers
 *
 * Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated
 * documentation files (the "Software"), to deal in the Software without restriction, including without limitation the
 * rights to use, copy, modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to permit
 * persons to whom the Software is furnished to do so, subject to the following conditions:
 *
 * The above copyright notice and this permission notice shall be included in all copies or substantial portions of the
 * Software.
 *
 * THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE
 * WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR
 * COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR
 * OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.
 */
#ifndef LCPBENCH_CAPTURE_H
#define LCPBENCH_CAPTURE_H

#ifdef __GNUC__
#pragma GCC system_header
#endif

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- what a program calls ------------------------------------------------------------------------------------------ */

typedef struct lcpbench_capture lcpbench_capture;

/* Creates the file. NULL when that fails. */
static inline lcpbench_capture* lcpbench_capture_open(const char* file, const char* scene, const char* engine,
                                                      const char* engine_version, double step_length);

/* Before the first step, all optional. The loop is the solver whose impulses move the scene on: "engine", or a name. */
static inline void lcpbench_capture_loop(lcpbench_capture* c, const char* loop);
static inline void lcpbench_capture_gravity(lcpbench_capture* c, const double gravity[3]);
/* A shape of a body (-1: of the world), for pictures, in the body's frame: "box" with its three half lengths, "sphere"
 * with its radius, "capsule" and "cylinder" with radius and half length (along z), "plane" with normal and offset,
 * "hull" with x, y, z of 4 to 256 corners, which is drawn as their convex hull. */
static inline void lcpbench_capture_shape(lcpbench_capture* c, int body, const char* type, const double* size, int n);

/* Begins a step. Steps are not negative and must ascend. */
static inline void lcpbench_capture_step(lcpbench_capture* c, long step, double time);

/* A free rigid body; returns its index. The inertia is about the centre of mass, in world axes, row after row. */
static inline int lcpbench_capture_body(lcpbench_capture* c, double mass, const double inertia[9],
                                        const double position[3], const double linear_velocity[3],
                                        const double angular_velocity[3]);

/* A contact of two bodies, either of which may be -1, the world; returns its index. The normal is a unit vector from
 * body_b into body_a, the tangent a unit vector orthogonal to it: the first friction direction. edges: 4, or 0 for a
 * frictionless contact, whose tangent may be NULL. b: the offset of the normal row, w = normal velocity + b [m/s]: 0
 * where there is neither restitution nor a gap. id: a name that the contact keeps from step to step, or NULL.
 * Four edges are the pyramid |t1| + |t2| <= mu f_N. A solver that limits each tangent by itself, |t1| <= mu f_N and
 * |t2| <= mu f_N, has the pyramid of tangents turned by 45 degrees: give s (t1 + t2) as tangent with s = sqrt(0.5), mu / s
 * as mu, and s (f_t1 + f_t2), s (f_t2 - f_t1) as impulses. */
static inline int lcpbench_capture_contact(lcpbench_capture* c, int body_a, int body_b, const double point[3],
                                           const double normal[3], const double tangent[3], double mu, int edges,
                                           double b, const char* id);

/* Instead of bodies, for robots: a block of the inertia matrix (n x n, row after row) with its n generalized
 * velocities; returns the index of its first coordinate. */
static inline int lcpbench_capture_block(lcpbench_capture* c, int n, const double* G, const double* v);

/* A contact of blocks; returns its index. Its Jacobian's rows have `entries` numbers each, at these coordinates, none
 * of them named twice. tangent1 NULL: frictionless. edges: an even number, 0 for frictionless;
 * the friction directions are at equal angles, beginning with tangent1 and turning to tangent2. */
static inline int lcpbench_capture_rows(lcpbench_capture* c, int entries, const int* coordinates, const double* normal,
                                        const double* tangent1, const double* tangent2, double mu, int edges, double b,
                                        const char* id);

/* A bounded row of blocks, for a joint, a limit, a motor or dry friction in a joint; returns its index among these
 * rows. Its velocity is w = direction'v+ + b + compliance f. Its impulse f is between lower <= 0 and upper >= 0,
 * -INFINITY and INFINITY where there is no bound; w = 0 between them. unit: "m" where direction'v+ is in m/s and f in
 * N s, "rad" where they are in rad/s and N m s. name: for messages, or NULL. See docs/reference/problem-file.md,
 * "Bounded rows". */
static inline int lcpbench_capture_row(lcpbench_capture* c, int entries, const int* coordinates,
                                       const double* direction, double lower, double upper, double b, double compliance,
                                       const char* unit, const char* name);
/* Optional: the bounded row given last has the bounds -mu f and mu f in place of its own, f of the bounded row `of`. */
static inline void lcpbench_capture_row_friction(lcpbench_capture* c, int of, double mu);

/* Optional, for pictures: where a contact of blocks is, with the unit normal and the first unit tangent, in the world. */
static inline void lcpbench_capture_frame(lcpbench_capture* c, int contact, const double point[3],
                                          const double normal[3], const double tangent[3]);

/* Optional: the contact given last is soft, w_N = N'v+ + b + compliance_n f_N, and along each tangent the velocity is
 * offset by offset_t + compliance_t f_T [m/s per N s, m/s]. See docs/reference/problem-file.md. */
static inline void lcpbench_capture_soft(lcpbench_capture* c, double compliance_n, double compliance_t, double offset_t1,
                                         double offset_t2);

/* Optional. Gaps (m, negative: penetration) and impulses (N s, on body_a along normal, tangent, normal x tangent; of
 * rows: along the three rows) are written when every contact of the step has one, impulses when every bounded row has
 * one, too. */
static inline void lcpbench_capture_gap(lcpbench_capture* c, int contact, double gap);
static inline void lcpbench_capture_impulse(lcpbench_capture* c, int contact, double fn, double ft1, double ft2);
static inline void lcpbench_capture_row_impulse(lcpbench_capture* c, int row, double f);
/* The engine's own velocity after the impact: n generalized coordinates (6 a body, linear before angular). */
static inline void lcpbench_capture_velocity(lcpbench_capture* c, int n, const double* velocity);
/* The time that the engine's own solver took for the step [s]: the solver `engine` has it beside the others' times. */
static inline void lcpbench_capture_solve_time(lcpbench_capture* c, double seconds);
/* How the problem differs from the step that the engine took, as "what: how many"; any number of them. */
static inline void lcpbench_capture_note(lcpbench_capture* c, const char* note);
/* Where a body of the pictures stands: position and unit quaternion (w, x, y, z). */
static inline void lcpbench_capture_pose(lcpbench_capture* c, int body, const double position[3],
                                         const double rotation[4]);

/* Writes the step and flushes the file: what has been ended survives a crash of the program. */
static inline void lcpbench_capture_end_step(lcpbench_capture* c);

/* 0 when every step is in the file. Otherwise a message went to stderr when the first failure happened; a step with a
 * failure is left out. */
static inline int lcpbench_capture_close(lcpbench_capture* c);

/* ---- how it works -------------------------------------------------------------------------------------------------- */

typedef struct {
  char* data;
  size_t size, capacity;
} lcpbench_text_;

typedef struct {
  int edges;
  int turned; /* -1 when the bodies changed places because the first was the world, else 1 */
  int has_gap, has_impulse, has_frame;
  double gap;
  double impulse[3];
  double frame[9];
  double soft[4]; /* compliance_n, compliance_t, offset_t */
  size_t text_end; /* of a contact of bodies: of its fields in the step's text */
} lcpbench_contact_;

typedef struct {
  double numbers[4]; /* b, compliance, lower, upper */
  double mu, impulse;
  int of; /* the row whose impulse bounds this one, or -1 */
  int is_angle, has_impulse;
} lcpbench_row_;

typedef struct {
  int given;
  double numbers[7];
} lcpbench_pose_;

enum {
  LCPBENCH_HEADER_, /* the fields of the header behind the first ones */
  LCPBENCH_SHAPES_,
  LCPBENCH_BODIES_, /* from here on: texts of one step */
  LCPBENCH_CONTACTS_,
  LCPBENCH_BLOCKS_,
  LCPBENCH_V_,
  LCPBENCH_N_STARTS_,
  LCPBENCH_N_ROWS_,
  LCPBENCH_N_VALUES_,
  LCPBENCH_D_STARTS_,
  LCPBENCH_D_ROWS_,
  LCPBENCH_D_VALUES_,
  LCPBENCH_EDGES_,
  LCPBENCH_MU_,
  LCPBENCH_B_,
  LCPBENCH_R_STARTS_,
  LCPBENCH_R_ROWS_,
  LCPBENCH_R_VALUES_,
  LCPBENCH_ROW_NAMES_,
  LCPBENCH_IDS_,
  LCPBENCH_VELOCITY_,
  LCPBENCH_NOTES_,
  LCPBENCH_TEXTS_
};

struct lcpbench_capture {
  FILE* file;
  lcpbench_text_ scene;
  lcpbench_text_ text[LCPBENCH_TEXTS_];
  int header_written, in_step, step_failed, failed;
  long step;
  int any_step;
  double time;
  double solve_s; /* negative: not told */
  int bodies, blocks, coordinates, n_entries, d_entries, r_entries, has_b, has_soft, has_ids, has_friction, has_frames;
  lcpbench_contact_* contacts;
  int contact_count, contact_room;
  lcpbench_row_* rows;
  int row_count, row_room, has_row_names;
  lcpbench_pose_* poses;
  int pose_count, pose_room;
};

static inline void lcpbench_fail_(lcpbench_capture* c, const char* message) {
  if (!c->failed) fprintf(stderr, "lcpbench_capture: step %ld: %s\n", c->step, message);
  c->failed = 1;
  c->step_failed = 1;
}

/* Room for `count` items of `size` bytes; 0 when there is no memory. */
static inline int lcpbench_grow_(lcpbench_capture* c, void** data, size_t* room, size_t count, size_t size) {
  void* grown;
  size_t wanted = *room;
  if (count <= *room) return 1;
  while (wanted < count) wanted = wanted == 0 ? 64 : 2 * wanted;
  grown = realloc(*data, wanted * size);
  if (grown == NULL) {
    lcpbench_fail_(c, "out of memory");
    return 0;
  }
  *data = grown;
  *room = wanted;
  return 1;
}

static inline void lcpbench_bytes_(lcpbench_capture* c, lcpbench_text_* text, const char* bytes, size_t count) {
  void* data = text->data;
  if (!lcpbench_grow_(c, &data, &text->capacity, text->size + count + 1, 1)) return;
  text->data = (char*)data;
  if (count > 0) memcpy(text->data + text->size, bytes, count);
  text->size += count;
  text->data[text->size] = '\0';
}

static inline void lcpbench_add_(lcpbench_capture* c, lcpbench_text_* text, const char* words) {
  lcpbench_bytes_(c, text, words, strlen(words));
}

/* A comma between the items of a list. */
static inline void lcpbench_next_(lcpbench_capture* c, lcpbench_text_* text) {
  if (text->size > 0 && text->data[text->size - 1] != '[') lcpbench_add_(c, text, ",");
}

static inline void lcpbench_integer_(lcpbench_capture* c, lcpbench_text_* text, long value) {
  char digits[32];
  snprintf(digits, sizeof digits, "%ld", value);
  lcpbench_add_(c, text, digits);
}

static inline void lcpbench_not_finite_(lcpbench_capture* c, const char* list, int index, const char* field, int size) {
  char words[160];
  if (index < 0)
    snprintf(words, sizeof words, "%.*s is not finite", size, field);
  else
    snprintf(words, sizeof words, "%s[%d].%.*s is not finite", list, index, size, field);
  lcpbench_fail_(c, words);
}

/* The number that comes next in the text is not finite. The text's last field names it, or what the text is for. */
static inline void lcpbench_bad_number_(lcpbench_capture* c, const lcpbench_text_* text) {
  static const struct {
    int text;
    const char* list;
    const char* field;
  } kTexts[6] = {{LCPBENCH_V_, "blocks", "v"},
                 {LCPBENCH_R_VALUES_, "rows", "direction"},
                 {LCPBENCH_N_VALUES_, "contacts", "normal"},
                 {LCPBENCH_D_VALUES_, "contacts", "tangent"},
                 {LCPBENCH_MU_, "contacts", "mu"},
                 {LCPBENCH_B_, "contacts", "b"}};
  const char* const end = text->size > 0 ? strrchr(text->data, '"') : NULL;
  const char* begin = end;
  int i;
  for (i = 0; i < 6; ++i) {
    const int index = i == 0 ? c->blocks : i == 1 ? c->row_count : c->contact_count;
    if (text != &c->text[kTexts[i].text]) continue;
    lcpbench_not_finite_(c, kTexts[i].list, index, kTexts[i].field, 16);
    return;
  }
  if (text == &c->text[LCPBENCH_BLOCKS_]) {
    lcpbench_not_finite_(c, "blocks", c->blocks, "G", 1);
  } else if (end != NULL) {
    while (begin[-1] != '"') --begin;
    lcpbench_not_finite_(c, text == &c->text[LCPBENCH_BODIES_] ? "bodies" : "contacts",
                         text == &c->text[LCPBENCH_BODIES_]     ? c->bodies
                         : text == &c->text[LCPBENCH_CONTACTS_] ? c->contact_count
                                                                : -1,
                         begin, (int)(end - begin));
  }
}

/* The shortest of the decimals with 15 to 17 digits that reads back to the same double. */
static inline void lcpbench_number_(lcpbench_capture* c, lcpbench_text_* text, double value) {
  char digits[40];
  int precision;
  char* comma;
  if (!(value - value == 0)) {
    lcpbench_bad_number_(c, text);
    return;
  }
  for (precision = 15; precision <= 17; ++precision) {
    snprintf(digits, sizeof digits, "%.*g", precision, value);
    if (strtod(digits, NULL) == value) break;
  }
  comma = strchr(digits, ','); /* of some languages' settings */
  if (comma != NULL) *comma = '.';
  lcpbench_add_(c, text, value == 0 && 1 / value < 0 ? "-0.0" : digits);
}

static inline void lcpbench_numbers_(lcpbench_capture* c, lcpbench_text_* text, const double* values, int count) {
  int i;
  lcpbench_add_(c, text, "[");
  for (i = 0; i < count; ++i) {
    if (i > 0) lcpbench_add_(c, text, ",");
    lcpbench_number_(c, text, values[i]);
  }
  lcpbench_add_(c, text, "]");
}

/* A symmetric matrix from one that is so up to rounding. */
static inline void lcpbench_symmetric_(lcpbench_capture* c, lcpbench_text_* text, const double* matrix, int n) {
  int i, j;
  lcpbench_add_(c, text, "[");
  for (i = 0; i < n; ++i) {
    lcpbench_add_(c, text, i > 0 ? ",[" : "[");
    for (j = 0; j < n; ++j) {
      if (j > 0) lcpbench_add_(c, text, ",");
      lcpbench_number_(c, text, 0.5 * matrix[i * n + j] + 0.5 * matrix[j * n + i]);
    }
    lcpbench_add_(c, text, "]");
  }
  lcpbench_add_(c, text, "]");
}

static inline void lcpbench_words_(lcpbench_capture* c, lcpbench_text_* text, const char* words) {
  lcpbench_add_(c, text, "\"");
  for (; words != NULL && *words != '\0'; ++words) {
    const char byte = *words;
    if (byte == '"' || byte == '\\') lcpbench_add_(c, text, "\\");
    if ((unsigned char)byte < 0x20 || byte == 0x7F) lcpbench_add_(c, text, " ");
    else lcpbench_bytes_(c, text, &byte, 1);
  }
  lcpbench_add_(c, text, "\"");
}

static inline void lcpbench_field_(lcpbench_capture* c, const char* name, const lcpbench_text_* list) {
  fprintf(c->file, ",\"%s\":[%s]", name, list->size > 0 ? list->data : "");
}

/* Leaves out what was added to the header since it had this size, if a number of it was none. */
static inline void lcpbench_check_header_(lcpbench_capture* c, lcpbench_text_* text, size_t size) {
  if (!c->step_failed) return;
  c->step_failed = 0;
  text->size = size;
  if (text->data != NULL) text->data[size] = '\0';
}

static inline lcpbench_capture* lcpbench_capture_open(const char* file, const char* scene, const char* engine,
                                                      const char* engine_version, double step_length) {
  lcpbench_text_* header;
  size_t size;
  lcpbench_capture* c = (lcpbench_capture*)calloc(1, sizeof(lcpbench_capture));
  if (c == NULL) return NULL;
  c->file = fopen(file, "wb");
  if (c->file == NULL) {
    free(c);
    return NULL;
  }
  lcpbench_words_(c, &c->scene, scene != NULL && scene[0] != '\0' ? scene : "scene");
  header = &c->text[LCPBENCH_HEADER_];
  lcpbench_add_(c, header, ",\"engine\":");
  lcpbench_words_(c, header, engine);
  lcpbench_add_(c, header, ",\"engine_version\":");
  lcpbench_words_(c, header, engine_version);
  size = header->size;
  lcpbench_add_(c, header, ",\"step_length\":");
  lcpbench_number_(c, header, step_length);
  lcpbench_check_header_(c, header, size);
  return c;
}

/* The header goes out with the first step. */
static inline int lcpbench_in_header_(lcpbench_capture* c) {
  if (c == NULL) return 0;
  if (c->header_written) lcpbench_fail_(c, "what belongs to the header came behind the first step");
  return !c->header_written;
}

static inline void lcpbench_capture_loop(lcpbench_capture* c, const char* loop) {
  if (!lcpbench_in_header_(c)) return;
  lcpbench_add_(c, &c->text[LCPBENCH_HEADER_], ",\"loop\":");
  lcpbench_words_(c, &c->text[LCPBENCH_HEADER_], loop);
}

static inline void lcpbench_capture_gravity(lcpbench_capture* c, const double gravity[3]) {
  lcpbench_text_* header;
  size_t size;
  if (!lcpbench_in_header_(c)) return;
  header = &c->text[LCPBENCH_HEADER_];
  size = header->size;
  lcpbench_add_(c, header, ",\"gravity\":");
  lcpbench_numbers_(c, header, gravity, 3);
  lcpbench_check_header_(c, header, size);
}

static inline void lcpbench_capture_shape(lcpbench_capture* c, int body, const char* type, const double* size, int n) {
  lcpbench_text_* shapes;
  size_t before;
  if (!lcpbench_in_header_(c)) return;
  shapes = &c->text[LCPBENCH_SHAPES_];
  before = shapes->size;
  if (type != NULL && strcmp(type, "hull") == 0 && (n % 3 != 0 || n < 3 * 4 || n > 3 * 256)) {
    lcpbench_fail_(c, "shapes: a hull has three numbers for each of 4 to 256 corners");
  }
  lcpbench_next_(c, shapes);
  lcpbench_add_(c, shapes, "{\"body\":");
  lcpbench_integer_(c, shapes, body);
  lcpbench_add_(c, shapes, ",\"type\":");
  lcpbench_words_(c, shapes, type);
  lcpbench_add_(c, shapes, ",\"size\":");
  lcpbench_numbers_(c, shapes, size, n);
  lcpbench_add_(c, shapes, "}");
  lcpbench_check_header_(c, shapes, before);
}

static inline void lcpbench_header_(lcpbench_capture* c) {
  if (c->header_written) return;
  c->header_written = 1;
  fprintf(c->file, "{\"format\":\"lcpbench-scenes\",\"version\":1,\"scene\":%s%s", c->scene.data,
          c->text[LCPBENCH_HEADER_].data);
  if (c->text[LCPBENCH_SHAPES_].size > 0) lcpbench_field_(c, "shapes", &c->text[LCPBENCH_SHAPES_]);
  fputs("}\n", c->file);
}

static inline void lcpbench_capture_step(lcpbench_capture* c, long step, double time) {
  int i;
  if (c == NULL) return;
  lcpbench_header_(c);
  if (c->in_step) lcpbench_fail_(c, "no end of this step before the next one");
  c->step_failed = 0;
  if (step < 0) {
    lcpbench_fail_(c, "behind it comes a negative step");
  } else if (c->any_step && step <= c->step) {
    lcpbench_fail_(c, "the next one does not ascend");
  } else {
    c->any_step = 1;
    c->step = step;
  }
  c->in_step = 1;
  c->time = time;
  c->solve_s = -1;
  for (i = LCPBENCH_BODIES_; i < LCPBENCH_TEXTS_; ++i) c->text[i].size = 0;
  c->bodies = c->blocks = c->coordinates = c->n_entries = c->d_entries = c->r_entries = 0;
  c->row_count = c->has_row_names = 0;
  c->has_b = c->has_soft = c->has_ids = c->has_friction = c->has_frames = c->contact_count = c->pose_count = 0;
}

static inline int lcpbench_in_step_(lcpbench_capture* c) {
  if (c == NULL) return 0;
  if (!c->in_step) lcpbench_fail_(c, "data outside of a step: call lcpbench_capture_step first");
  return c->in_step;
}

static inline int lcpbench_capture_body(lcpbench_capture* c, double mass, const double inertia[9],
                                        const double position[3], const double linear_velocity[3],
                                        const double angular_velocity[3]) {
  lcpbench_text_* text;
  if (!lcpbench_in_step_(c)) return -1;
  if (c->blocks > 0) lcpbench_fail_(c, "bodies and blocks in one step: give the bodies as blocks too");
  text = &c->text[LCPBENCH_BODIES_];
  lcpbench_next_(c, text);
  lcpbench_add_(c, text, "{\"mass\":");
  lcpbench_number_(c, text, mass);
  lcpbench_add_(c, text, ",\"inertia\":");
  lcpbench_symmetric_(c, text, inertia, 3);
  lcpbench_add_(c, text, ",\"position\":");
  lcpbench_numbers_(c, text, position, 3);
  lcpbench_add_(c, text, ",\"linear_velocity\":");
  lcpbench_numbers_(c, text, linear_velocity, 3);
  lcpbench_add_(c, text, ",\"angular_velocity\":");
  lcpbench_numbers_(c, text, angular_velocity, 3);
  lcpbench_add_(c, text, "}");
  return c->bodies++;
}

/* What contacts of both kinds have; the new contact's index, -1 without memory. */
static inline int lcpbench_new_contact_(lcpbench_capture* c, int edges, int turned, const char* id) {
  lcpbench_contact_ contact = {0, 0, 0, 0, 0, 0, {0, 0, 0}, {0, 0, 0, 0, 0, 0, 0, 0, 0}, {0, 0, 0, 0}, 0};
  void* data = c->contacts;
  size_t room = (size_t)c->contact_room;
  if (!lcpbench_grow_(c, &data, &room, (size_t)c->contact_count + 1, sizeof contact)) return -1;
  c->contacts = (lcpbench_contact_*)data;
  c->contact_room = (int)room;
  contact.edges = edges;
  contact.turned = turned;
  c->contacts[c->contact_count] = contact;
  lcpbench_next_(c, &c->text[LCPBENCH_IDS_]);
  lcpbench_words_(c, &c->text[LCPBENCH_IDS_], id);
  if (id != NULL) c->has_ids = 1;
  if (edges > 0) c->has_friction = 1;
  return c->contact_count++;
}

static inline void lcpbench_turned_(lcpbench_capture* c, lcpbench_text_* text, const double direction[3], int turned) {
  double result[3];
  int i;
  for (i = 0; i < 3; ++i) result[i] = turned < 0 ? 0.0 - direction[i] : direction[i];
  lcpbench_numbers_(c, text, result, 3);
}

static inline int lcpbench_capture_contact(lcpbench_capture* c, int body_a, int body_b, const double point[3],
                                           const double normal[3], const double tangent[3], double mu, int edges,
                                           double b, const char* id) {
  const int turned = body_a < 0 ? -1 : 1;
  const int pushed = turned < 0 ? body_b : body_a;
  lcpbench_text_* text;
  size_t end;
  int index;
  if (!lcpbench_in_step_(c)) return -1;
  if (edges != 0 && edges != 4) lcpbench_fail_(c, "a contact of bodies has 0 or 4 edges");
  if (pushed < 0 || pushed >= c->bodies || body_b >= c->bodies) {
    lcpbench_fail_(c, "a contact needs one body, and bodies are given before contacts");
  }
  if (edges != 0 && tangent == NULL) {
    lcpbench_fail_(c, "a contact with friction needs a tangent");
    return -1;
  }
  text = &c->text[LCPBENCH_CONTACTS_];
  lcpbench_next_(c, text);
  lcpbench_add_(c, text, "{\"body_a\":");
  lcpbench_integer_(c, text, pushed);
  lcpbench_add_(c, text, ",\"body_b\":");
  lcpbench_integer_(c, text, turned < 0 || body_b < 0 ? -1 : body_b);
  lcpbench_add_(c, text, ",\"point\":");
  lcpbench_numbers_(c, text, point, 3);
  lcpbench_add_(c, text, ",\"normal\":");
  lcpbench_turned_(c, text, normal, turned);
  if (edges != 0) {
    lcpbench_add_(c, text, ",\"tangent\":");
    lcpbench_turned_(c, text, tangent, turned);
    lcpbench_add_(c, text, ",\"mu\":");
    lcpbench_number_(c, text, mu);
    lcpbench_add_(c, text, ",\"edges\":4");
  }
  if (b != 0) {
    lcpbench_add_(c, text, ",\"b\":");
    lcpbench_number_(c, text, b);
  }
  end = text->size;
  lcpbench_add_(c, text, "}");
  index = lcpbench_new_contact_(c, edges, turned, id);
  if (index >= 0) c->contacts[index].text_end = end;
  return index;
}

static inline int lcpbench_capture_block(lcpbench_capture* c, int n, const double* G, const double* v) {
  int i;
  if (!lcpbench_in_step_(c)) return -1;
  if (c->bodies > 0) lcpbench_fail_(c, "bodies and blocks in one step: give the bodies as blocks too");
  lcpbench_next_(c, &c->text[LCPBENCH_BLOCKS_]);
  lcpbench_symmetric_(c, &c->text[LCPBENCH_BLOCKS_], G, n);
  for (i = 0; i < n; ++i) {
    lcpbench_next_(c, &c->text[LCPBENCH_V_]);
    lcpbench_number_(c, &c->text[LCPBENCH_V_], v[i]);
  }
  ++c->blocks;
  c->coordinates += n;
  return c->coordinates - n;
}

/* One column of N (first = LCPBENCH_N_STARTS_) or D: cosine * a + sine * b at the coordinates, zeros left out. */
static inline void lcpbench_column_(lcpbench_capture* c, int first, int* total, int entries, const int* coordinates,
                                    const double* a, double cosine, const double* b, double sine) {
  int i;
  for (i = 0; i < entries; ++i) {
    const double value = sine == 0 ? cosine * a[i] : cosine == 0 ? sine * b[i] : cosine * a[i] + sine * b[i];
    if (coordinates[i] < 0 || coordinates[i] >= c->coordinates) {
      lcpbench_fail_(c, "a coordinate of no block; blocks are given before rows");
    }
    if (value == 0) continue;
    lcpbench_next_(c, &c->text[first + 1]);
    lcpbench_integer_(c, &c->text[first + 1], coordinates[i]);
    lcpbench_next_(c, &c->text[first + 2]);
    lcpbench_number_(c, &c->text[first + 2], value);
    ++*total;
  }
  lcpbench_add_(c, &c->text[first], ",");
  lcpbench_integer_(c, &c->text[first], *total);
}

/* Direction `index` of a pyramid's first half: t1 and t2 exactly where it meets them. */
static inline void lcpbench_direction_(int edges, int index, double* cosine, double* sine) {
  const double angle = 6.283185307179586 * index / edges;
  *cosine = 4 * index == edges ? 0.0 : cos(angle);
  *sine = index == 0 ? 0.0 : sin(angle);
}

static inline int lcpbench_capture_rows(lcpbench_capture* c, int entries, const int* coordinates, const double* normal,
                                        const double* tangent1, const double* tangent2, double mu, int edges, double b,
                                        const char* id) {
  const int pyramid = tangent1 == NULL ? 0 : edges;
  int sign, k;
  if (!lcpbench_in_step_(c)) return -1;
  if (pyramid < 0 || pyramid % 2 != 0) lcpbench_fail_(c, "edges: not an even number");
  if (pyramid > 2 && tangent2 == NULL) {
    lcpbench_fail_(c, "more than two edges need a second tangent");
    return -1;
  }
  lcpbench_column_(c, LCPBENCH_N_STARTS_, &c->n_entries, entries, coordinates, normal, 1, NULL, 0);
  for (sign = 1; sign >= -1; sign -= 2) {
    for (k = 0; k < pyramid / 2; ++k) {
      double cosine, sine;
      lcpbench_direction_(pyramid, k, &cosine, &sine);
      lcpbench_column_(c, LCPBENCH_D_STARTS_, &c->d_entries, entries, coordinates, tangent1, sign * cosine, tangent2,
                       sign * sine);
    }
  }
  lcpbench_next_(c, &c->text[LCPBENCH_EDGES_]);
  lcpbench_integer_(c, &c->text[LCPBENCH_EDGES_], pyramid);
  lcpbench_next_(c, &c->text[LCPBENCH_MU_]);
  lcpbench_number_(c, &c->text[LCPBENCH_MU_], pyramid > 0 ? mu : 0.0);
  lcpbench_next_(c, &c->text[LCPBENCH_B_]);
  lcpbench_number_(c, &c->text[LCPBENCH_B_], b);
  if (b != 0) c->has_b = 1;
  return lcpbench_new_contact_(c, pyramid, 1, id);
}

/* Fails with what is wrong in the bounded row that comes next. */
static inline void lcpbench_bad_row_(lcpbench_capture* c, const char* what) {
  char words[160];
  snprintf(words, sizeof words, "rows[%d]: %s", c->row_count, what);
  lcpbench_fail_(c, words);
}

static inline int lcpbench_capture_row(lcpbench_capture* c, int entries, const int* coordinates,
                                       const double* direction, double lower, double upper, double b, double compliance,
                                       const char* unit, const char* name) {
  lcpbench_row_ row = {{0, 0, 0, 0}, 0, 0, -1, 0, 0};
  void* data;
  size_t room;
  if (!lcpbench_in_step_(c)) return -1;
  data = c->rows;
  room = (size_t)c->row_room;
  row.is_angle = unit != NULL && strcmp(unit, "rad") == 0;
  if (c->bodies > 0) lcpbench_bad_row_(c, "rows and bodies in one step: give the bodies as blocks");
  if (!(b - b == 0)) lcpbench_bad_row_(c, "b is not finite");
  if (!(compliance >= 0 && compliance - compliance == 0)) lcpbench_bad_row_(c, "compliance is no number >= 0");
  if (!(lower <= 0 && upper >= 0 && lower < upper)) lcpbench_bad_row_(c, "needs lower <= 0 <= upper, not both 0");
  if (unit != NULL && !row.is_angle && strcmp(unit, "m") != 0) lcpbench_bad_row_(c, "unit is neither m nor rad");
  lcpbench_column_(c, LCPBENCH_R_STARTS_, &c->r_entries, entries, coordinates, direction, 1, NULL, 0);
  if (!lcpbench_grow_(c, &data, &room, (size_t)c->row_count + 1, sizeof row)) return -1;
  c->rows = (lcpbench_row_*)data;
  c->row_room = (int)room;
  row.numbers[0] = b;
  row.numbers[1] = compliance;
  row.numbers[2] = lower;
  row.numbers[3] = upper;
  c->rows[c->row_count] = row;
  lcpbench_next_(c, &c->text[LCPBENCH_ROW_NAMES_]);
  lcpbench_words_(c, &c->text[LCPBENCH_ROW_NAMES_], name);
  if (name != NULL) c->has_row_names = 1;
  return c->row_count++;
}

static inline void lcpbench_capture_row_friction(lcpbench_capture* c, int of, double mu) {
  lcpbench_row_* row;
  if (!lcpbench_in_step_(c)) return;
  if (of < 0 || of >= c->row_count - 1 || c->rows[of].of >= 0 || c->rows[of].numbers[2] != 0) {
    lcpbench_fail_(c, "friction of a row needs an earlier row whose lower bound is 0");
    return;
  }
  if (!(mu >= 0 && mu - mu == 0)) lcpbench_fail_(c, "friction of a row needs mu >= 0");
  row = &c->rows[c->row_count - 1];
  row->of = of;
  row->mu = mu;
}

static inline void lcpbench_capture_row_impulse(lcpbench_capture* c, int row, double f) {
  if (!lcpbench_in_step_(c)) return;
  if (row < 0 || row >= c->row_count) {
    lcpbench_fail_(c, "no such bounded row in this step");
    return;
  }
  if (!(f - f == 0)) lcpbench_not_finite_(c, "rows", row, "impulse", 7);
  c->rows[row].impulse = f;
  c->rows[row].has_impulse = 1;
}

/* The compliance of all contacts: fields of the problem, or of contact `one` alone. */
static inline void lcpbench_soft_(lcpbench_capture* c, lcpbench_text_* line, int one) {
  static const char* const kNames[3] = {"compliance_n", "compliance_t", "offset_t"};
  const int first = one < 0 ? 0 : one;
  const int end = one < 0 ? c->contact_count : one + 1;
  int field, i, k;
  for (field = 0; field < 3; ++field) {
    const int from = field, to = field == 2 ? 4 : field + 1;
    int any = 0;
    for (i = first; i < end; ++i) {
      for (k = from; k < to; ++k) any = any || c->contacts[i].soft[k] != 0;
    }
    if (!any) continue;
    lcpbench_add_(c, line, ",\"");
    lcpbench_add_(c, line, kNames[field]);
    lcpbench_add_(c, line, one >= 0 && field < 2 ? "\":" : "\":[");
    for (i = first; i < end; ++i) {
      for (k = from; k < to; ++k) {
        if (i > first || k > from) lcpbench_add_(c, line, ",");
        lcpbench_number_(c, line, c->contacts[i].soft[k]);
      }
    }
    if (one < 0 || field == 2) lcpbench_add_(c, line, "]");
  }
}

static inline void lcpbench_capture_soft(lcpbench_capture* c, double compliance_n, double compliance_t, double offset_t1,
                                         double offset_t2) {
  double values[4];
  int k;
  lcpbench_contact_* contact;
  lcpbench_text_* text;
  if (!lcpbench_in_step_(c)) return;
  if (c->contact_count == 0) {
    lcpbench_fail_(c, "what is soft is told behind its contact");
    return;
  }
  contact = &c->contacts[c->contact_count - 1];
  if (!(compliance_n >= 0 && compliance_t >= 0)) lcpbench_fail_(c, "a compliance that is no number >= 0");
  values[0] = compliance_n;
  values[1] = contact->edges > 0 ? compliance_t : 0.0;
  values[2] = contact->edges > 0 ? offset_t1 : 0.0;
  values[3] = contact->edges > 0 ? contact->turned * offset_t2 : 0.0;
  for (k = 0; k < 4; ++k) {
    contact->soft[k] = values[k];
    if (values[k] != 0) c->has_soft = 1;
  }
  if (c->blocks > 0) return;
  text = &c->text[LCPBENCH_CONTACTS_];
  text->size = contact->text_end;
  lcpbench_soft_(c, text, c->contact_count - 1);
  lcpbench_add_(c, text, "}");
}

static inline int lcpbench_is_contact_(lcpbench_capture* c, int contact) {
  if (!lcpbench_in_step_(c)) return 0;
  if (contact >= 0 && contact < c->contact_count) return 1;
  lcpbench_fail_(c, "no such contact in this step");
  return 0;
}

static inline void lcpbench_capture_gap(lcpbench_capture* c, int contact, double gap) {
  if (!lcpbench_is_contact_(c, contact)) return;
  if (!(gap - gap == 0)) lcpbench_not_finite_(c, "contacts", contact, "gap", 3);
  c->contacts[contact].gap = gap;
  c->contacts[contact].has_gap = 1;
}

static inline void lcpbench_capture_impulse(lcpbench_capture* c, int contact, double fn, double ft1, double ft2) {
  if (!lcpbench_is_contact_(c, contact)) return;
  if (!(fn - fn == 0 && ft1 - ft1 == 0 && ft2 - ft2 == 0)) lcpbench_not_finite_(c, "contacts", contact, "impulse", 7);
  c->contacts[contact].impulse[0] = fn;
  c->contacts[contact].impulse[1] = ft1;
  c->contacts[contact].impulse[2] = c->contacts[contact].turned < 0 ? -ft2 : ft2;
  c->contacts[contact].has_impulse = 1;
}

static inline void lcpbench_capture_frame(lcpbench_capture* c, int contact, const double point[3],
                                          const double normal[3], const double tangent[3]) {
  if (!lcpbench_is_contact_(c, contact)) return;
  if (c->blocks == 0) {
    lcpbench_fail_(c, "a frame of a contact of bodies, which has its own");
    return;
  }
  memcpy(c->contacts[contact].frame, point, 3 * sizeof(double));
  memcpy(c->contacts[contact].frame + 3, normal, 3 * sizeof(double));
  memcpy(c->contacts[contact].frame + 6, tangent, 3 * sizeof(double));
  c->contacts[contact].has_frame = c->has_frames = 1;
}

static inline void lcpbench_capture_velocity(lcpbench_capture* c, int n, const double* velocity) {
  if (!lcpbench_in_step_(c)) return;
  c->text[LCPBENCH_VELOCITY_].size = 0;
  lcpbench_numbers_(c, &c->text[LCPBENCH_VELOCITY_], velocity, n);
}

static inline void lcpbench_capture_note(lcpbench_capture* c, const char* note) {
  if (!lcpbench_in_step_(c)) return;
  lcpbench_next_(c, &c->text[LCPBENCH_NOTES_]);
  lcpbench_words_(c, &c->text[LCPBENCH_NOTES_], note);
}

static inline void lcpbench_capture_solve_time(lcpbench_capture* c, double seconds) {
  if (!lcpbench_in_step_(c)) return;
  if (!(seconds >= 0)) lcpbench_fail_(c, "the time of the solver is negative or not a number");
  c->solve_s = seconds;
}

static inline void lcpbench_capture_pose(lcpbench_capture* c, int body, const double position[3],
                                         const double rotation[4]) {
  void* data;
  size_t room;
  if (!lcpbench_in_step_(c)) return;
  if (body < 0) {
    lcpbench_fail_(c, "a pose of the world");
    return;
  }
  data = c->poses;
  room = (size_t)c->pose_room;
  if (!lcpbench_grow_(c, &data, &room, (size_t)body + 1, sizeof(lcpbench_pose_))) return;
  c->poses = (lcpbench_pose_*)data;
  c->pose_room = (int)room;
  for (; c->pose_count <= body; ++c->pose_count) c->poses[c->pose_count].given = 0;
  c->poses[body].given = 1;
  memcpy(c->poses[body].numbers, position, 3 * sizeof(double));
  memcpy(c->poses[body].numbers + 3, rotation, 4 * sizeof(double));
}

/* The impulses along a pyramid's edges that make up (x, y) along its two tangents: those of the two edges beside it. */
static inline void lcpbench_friction_(lcpbench_capture* c, lcpbench_text_* text, int edges, double x, double y) {
  int k;
  for (k = 0; k < edges; ++k) {
    const double sign = k < edges / 2 ? 1.0 : -1.0;
    double cosine, sine, share;
    lcpbench_direction_(edges, k % (edges / 2), &cosine, &sine);
    share = sign * (cosine * x + sine * y);
    if (edges > 4) {
      const double width = 6.283185307179586 / edges;
      share -= fabs(cosine * y - sine * x) * cos(width) / sin(width);
    }
    lcpbench_add_(c, text, ",");
    lcpbench_number_(c, text, share > 0 ? share : 0.0);
  }
}

/* Whether every contact has what `offset` (of has_gap or has_impulse) says. */
static inline int lcpbench_all_have_(const lcpbench_capture* c, size_t offset) {
  int i;
  for (i = 0; i < c->contact_count; ++i) {
    if (*(const int*)((const char*)&c->contacts[i] + offset) == 0) return 0;
  }
  return c->contact_count > 0;
}

static inline void lcpbench_gaps_(lcpbench_capture* c, lcpbench_text_* line) {
  int i;
  lcpbench_add_(c, line, ",\"gap\":[");
  for (i = 0; i < c->contact_count; ++i) {
    lcpbench_next_(c, line);
    lcpbench_number_(c, line, c->contacts[i].gap);
  }
  lcpbench_add_(c, line, "]");
}

/* f_N of every contact, f_D of every friction direction, f_R of every bounded row: z without lambda. */
static inline void lcpbench_impulses_(lcpbench_capture* c, lcpbench_text_* line) {
  int i;
  lcpbench_add_(c, line, "\"impulses\":[");
  for (i = 0; i < c->contact_count; ++i) {
    lcpbench_next_(c, line);
    lcpbench_number_(c, line, c->contacts[i].impulse[0]);
  }
  for (i = 0; i < c->contact_count; ++i) {
    const lcpbench_contact_ contact = c->contacts[i];
    lcpbench_friction_(c, line, contact.edges, contact.impulse[1], contact.impulse[2]);
  }
  for (i = 0; i < c->row_count; ++i) {
    lcpbench_next_(c, line);
    lcpbench_number_(c, line, c->rows[i].impulse);
  }
  lcpbench_add_(c, line, "]");
}

static inline void lcpbench_frames_(lcpbench_capture* c, lcpbench_text_* line) {
  int i;
  lcpbench_add_(c, line, ",\"contact_frames\":[");
  for (i = 0; i < c->contact_count; ++i) {
    lcpbench_next_(c, line);
    lcpbench_numbers_(c, line, c->contacts[i].frame, c->contacts[i].has_frame ? 9 : 0);
  }
  lcpbench_add_(c, line, "]");
}

static inline void lcpbench_poses_(lcpbench_capture* c, lcpbench_text_* line) {
  int i;
  lcpbench_add_(c, line, ",\"poses\":[");
  for (i = 0; i < c->pose_count; ++i) {
    lcpbench_next_(c, line);
    lcpbench_numbers_(c, line, c->poses[i].numbers, c->poses[i].given ? 7 : 0);
  }
  lcpbench_add_(c, line, "]");
}

static inline void lcpbench_list_(lcpbench_capture* c, lcpbench_text_* line, const char* before, int text,
                                  const char* after) {
  lcpbench_add_(c, line, before);
  lcpbench_bytes_(c, line, c->text[text].data, c->text[text].size);
  lcpbench_add_(c, line, after);
}

/* The field `rows` of the problem. */
static inline void lcpbench_rows_(lcpbench_capture* c, lcpbench_text_* line) {
  static const char* const kNames[4] = {",\"b\":[", ",\"compliance\":[", ",\"lower\":[", ",\"upper\":["};
  int field, i, angles = 0, friction = 0;
  for (i = 0; i < c->row_count; ++i) {
    angles = angles || c->rows[i].is_angle;
    friction = friction || c->rows[i].of >= 0;
  }
  lcpbench_list_(c, line, ",\"rows\":{\"R\":{\"starts\":[0", LCPBENCH_R_STARTS_, "]");
  lcpbench_list_(c, line, ",\"rows\":[", LCPBENCH_R_ROWS_, "]");
  lcpbench_list_(c, line, ",\"values\":[", LCPBENCH_R_VALUES_, "]}");
  for (field = 0; field < 4; ++field) {
    lcpbench_add_(c, line, kNames[field]);
    for (i = 0; i < c->row_count; ++i) {
      const double value = c->rows[i].numbers[field];
      lcpbench_next_(c, line);
      if (field > 1 && (value - value != 0 || c->rows[i].of >= 0))
        lcpbench_add_(c, line, "null");
      else
        lcpbench_number_(c, line, value);
    }
    lcpbench_add_(c, line, "]");
  }
  for (field = 0; friction && field < 2; ++field) {
    lcpbench_add_(c, line, field == 0 ? ",\"friction_of\":[" : ",\"mu\":[");
    for (i = 0; i < c->row_count; ++i) {
      lcpbench_next_(c, line);
      if (c->rows[i].of < 0)
        lcpbench_add_(c, line, "null");
      else
        lcpbench_number_(c, line, field == 0 ? c->rows[i].of : c->rows[i].mu);
    }
    lcpbench_add_(c, line, "]");
  }
  if (angles) {
    lcpbench_add_(c, line, ",\"unit\":[");
    for (i = 0; i < c->row_count; ++i) {
      lcpbench_next_(c, line);
      lcpbench_add_(c, line, c->rows[i].is_angle ? "\"rad\"" : "\"m\"");
    }
    lcpbench_add_(c, line, "]");
  }
  if (c->has_row_names) lcpbench_list_(c, line, ",\"names\":[", LCPBENCH_ROW_NAMES_, "]");
  lcpbench_add_(c, line, "}");
}

/* The fields of the problem file's kind "contact". */
static inline void lcpbench_blocks_(lcpbench_capture* c, lcpbench_text_* line) {
  lcpbench_list_(c, line, "\"contact\",\"v\":[", LCPBENCH_V_, "]");
  lcpbench_list_(c, line, ",\"N\":{\"starts\":[0", LCPBENCH_N_STARTS_, "]");
  lcpbench_list_(c, line, ",\"rows\":[", LCPBENCH_N_ROWS_, "]");
  lcpbench_list_(c, line, ",\"values\":[", LCPBENCH_N_VALUES_, "]}");
  if (c->has_friction) {
    lcpbench_list_(c, line, ",\"D\":{\"starts\":[0", LCPBENCH_D_STARTS_, "]");
    lcpbench_list_(c, line, ",\"rows\":[", LCPBENCH_D_ROWS_, "]");
    lcpbench_list_(c, line, ",\"values\":[", LCPBENCH_D_VALUES_, "]}");
    lcpbench_list_(c, line, ",\"edges\":[", LCPBENCH_EDGES_, "]");
    lcpbench_list_(c, line, ",\"mu\":[", LCPBENCH_MU_, "]");
  }
  if (c->has_b) lcpbench_list_(c, line, ",\"b\":[", LCPBENCH_B_, "]");
  if (c->has_soft) lcpbench_soft_(c, line, -1);
  if (c->row_count > 0) lcpbench_rows_(c, line);
  lcpbench_list_(c, line, ",\"G_blocks\":[", LCPBENCH_BLOCKS_, "]");
}

static inline void lcpbench_capture_end_step(lcpbench_capture* c) {
  lcpbench_text_ line = {NULL, 0, 0};
  const int velocity = c != NULL && c->text[LCPBENCH_VELOCITY_].size > 0;
  int impulses, i;
  if (!lcpbench_in_step_(c)) return;
  c->in_step = 0;
  impulses = c->contact_count > 0 ? lcpbench_all_have_(c, offsetof(lcpbench_contact_, has_impulse)) : c->row_count > 0;
  for (i = 0; i < c->row_count; ++i) impulses = impulses && c->rows[i].has_impulse;
  lcpbench_add_(c, &line, "{\"step\":");
  lcpbench_integer_(c, &line, c->step);
  lcpbench_add_(c, &line, ",\"time\":");
  lcpbench_number_(c, &line, c->time);
  lcpbench_add_(c, &line, ",\"problem\":{\"format\":\"lcpbench-problem\",\"version\":1,\"name\":");
  lcpbench_bytes_(c, &line, c->scene.data, c->scene.size - 1);
  lcpbench_add_(c, &line, " step ");
  lcpbench_integer_(c, &line, c->step);
  lcpbench_add_(c, &line, "\",\"kind\":");
  if (c->blocks > 0) {
    lcpbench_blocks_(c, &line);
  } else {
    lcpbench_list_(c, &line, "\"scene\",\"bodies\":[", LCPBENCH_BODIES_, "]");
    lcpbench_list_(c, &line, ",\"contacts\":[", LCPBENCH_CONTACTS_, "]");
  }
  lcpbench_add_(c, &line, "}");
  if (lcpbench_all_have_(c, offsetof(lcpbench_contact_, has_gap))) lcpbench_gaps_(c, &line);
  if (c->has_ids) lcpbench_list_(c, &line, ",\"contact_ids\":[", LCPBENCH_IDS_, "]");
  if (c->has_frames) lcpbench_frames_(c, &line);
  if (c->pose_count > 0) lcpbench_poses_(c, &line);
  if (c->text[LCPBENCH_NOTES_].size > 0) lcpbench_list_(c, &line, ",\"notes\":[", LCPBENCH_NOTES_, "]");
  if (impulses || velocity || c->solve_s >= 0) {
    lcpbench_add_(c, &line, ",\"engine\":{");
    if (impulses) lcpbench_impulses_(c, &line);
    if (velocity) lcpbench_list_(c, &line, impulses ? ",\"velocity\":" : "\"velocity\":", LCPBENCH_VELOCITY_, "");
    if (c->solve_s >= 0) {
      lcpbench_add_(c, &line, impulses || velocity ? ",\"solve_s\":" : "\"solve_s\":");
      lcpbench_number_(c, &line, c->solve_s);
    }
    lcpbench_add_(c, &line, "}");
  }
  lcpbench_add_(c, &line, "}\n");
  if (!c->step_failed) {
    const int written = fwrite(line.data, 1, line.size, c->file) == line.size;
    if (fflush(c->file) != 0 || !written) lcpbench_fail_(c, "the file cannot be written");
  }
  free(line.data);
}

static inline int lcpbench_capture_close(lcpbench_capture* c) {
  int i, failed;
  if (c == NULL) return -1;
  if (c->in_step) lcpbench_fail_(c, "closed before the step's end");
  lcpbench_header_(c);
  if (fclose(c->file) != 0) lcpbench_fail_(c, "the file cannot be written");
  failed = c->failed;
  for (i = 0; i < LCPBENCH_TEXTS_; ++i) free(c->text[i].data);
  free(c->scene.data);
  free(c->contacts);
  free(c->rows);
  free(c->poses);
  free(c);
  return failed ? -1 : 0;
}

#endif
