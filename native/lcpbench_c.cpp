#include "native/lcpbench_c.h"

#include <atomic>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <span>
#include <stdexcept>
#include <string>

#include "native/lcpbench.h"

/// What the name in the C header stands for.
struct lcpbench_solver {
  lcpbench::ContactSolver solver;
  lcpbench::RigidScene scene;  ///< what update reads into; keeps its memory
  bool is_loaded = false;
  std::size_t bodies = 0, contacts = 0;  ///< of what is loaded
  lcpbench_claim claim = LCPBENCH_NOT_SOLVED_YET;
  std::atomic_flag busy;

  explicit lcpbench_solver(const char* spec) : solver(spec) {}
};

namespace lcpbench {
namespace {

thread_local char error_text[1000] = "";  // an array: to fill it takes no memory, which may have run out

void say(const char* text) { std::snprintf(error_text, sizeof error_text, "%s", text); }

struct Misuse : std::logic_error {
  using std::logic_error::logic_error;
};

void need(bool holds, const char* otherwise) {
  if (!holds) throw Misuse(otherwise);
}

/// Runs the body; its exceptions become a status and the text.
int guarded(auto&& body) noexcept {
  try {
    say("");
    body();
    return LCPBENCH_OK;
  } catch (const InputError& error) {
    say(error.what());
    return LCPBENCH_BAD_INPUT;
  } catch (const Misuse& error) {
    say(error.what());
    return LCPBENCH_MISUSE;
  } catch (const std::exception& error) {
    say(error.what());
    return LCPBENCH_FAILED;
  }
}

/// The same for a call on a solver, which no other thread may be inside.
int guarded(lcpbench_solver* self, auto&& body) noexcept {
  return guarded([&] {
    need(self != nullptr, "solver is NULL");
    need(!self->busy.test_and_set(std::memory_order_acquire), "another thread uses this solver");
    struct Leave {
      std::atomic_flag& busy;
      ~Leave() { busy.clear(std::memory_order_release); }
    } leave{self->busy};
    body(*self);
  });
}

void need_size(std::size_t size, std::size_t expected, const char* name) {
  if (size == expected) return;
  throw InputError(std::string(name) + " has " + std::to_string(size) + " numbers, expected " +
                   std::to_string(expected));
}

Eigen::Vector3d row3(const double* numbers, std::size_t row) { return Eigen::Vector3d::Map(numbers + 3 * row); }

double at(const double* numbers, std::size_t i) { return numbers == nullptr ? 0.0 : numbers[i]; }

RigidBody body_of(const lcpbench_scene& scene, std::size_t i) {
  return {.mass = scene.mass[i],
          .inertia = Eigen::Matrix3d::Map(scene.inertia + 9 * i).transpose(),
          .position = row3(scene.position, i),
          .linear_velocity = row3(scene.velocity, 2 * i),
          .angular_velocity = row3(scene.velocity, 2 * i + 1)};
}

RigidContact contact_of(const lcpbench_scene& scene, std::size_t i) {
  RigidContact contact{.body_a = scene.body_a[i],
                       .body_b = scene.body_b[i],
                       .point = row3(scene.point, i),
                       .normal = row3(scene.normal, i),
                       .mu = at(scene.mu, i),
                       .b = at(scene.b, i),
                       .compliance_n = at(scene.compliance_n, i),
                       .compliance_t = at(scene.compliance_t, i)};
  contact.edges = contact.mu == 0 ? 0 : 4;
  contact.tangent = scene.tangent == nullptr ? contact.normal.unitOrthogonal() : row3(scene.tangent, i);
  if (scene.offset_t != nullptr) contact.offset_t = Eigen::Vector2d::Map(scene.offset_t + 2 * i);
  return contact;
}

void read_scene(const lcpbench_scene& from, RigidScene& to) {
  need(from.bodies == 0 || (from.mass && from.inertia && from.position && from.velocity),
       "scene: mass, inertia, position or velocity is NULL");
  need(from.contacts == 0 || (from.body_a && from.body_b && from.point && from.normal),
       "scene: body_a, body_b, point or normal is NULL");
  to.bodies.clear();
  to.contacts.clear();
  for (std::size_t i = 0; i < from.bodies; ++i) to.bodies.push_back(body_of(from, i));
  for (std::size_t i = 0; i < from.contacts; ++i) to.contacts.push_back(contact_of(from, i));
}

lcpbench_claim claim_of(Claim claim) {
  switch (claim) {
    case Claim::kSolved: return LCPBENCH_SOLVED;
    case Claim::kUnsolvable: return LCPBENCH_UNSOLVABLE;
    case Claim::kIterationLimit: return LCPBENCH_ITERATION_LIMIT;
    case Claim::kTimeLimit: return LCPBENCH_TIME_LIMIT;
    case Claim::kUnsupported: return LCPBENCH_UNSUPPORTED;
    case Claim::kNumericalFailure:
    case Claim::kCrashed: break;  // a native solver reports no crash
  }
  return LCPBENCH_NUMERICAL_FAILURE;
}

}  // namespace
}  // namespace lcpbench

using lcpbench::guarded;
using lcpbench::need;

extern "C" {

int lcpbench_create(const char* spec, lcpbench_solver** solver) {
  return guarded([&] {
    need(solver != nullptr, "the place for the solver is NULL");
    *solver = nullptr;
    need(spec != nullptr, "spec is NULL");
    *solver = new lcpbench_solver(spec);
  });
}

void lcpbench_destroy(lcpbench_solver* solver) { delete solver; }

int lcpbench_update(lcpbench_solver* solver, const lcpbench_scene* scene) {
  return guarded(solver, [&](lcpbench_solver& self) {
    need(scene != nullptr, "scene is NULL");
    lcpbench::read_scene(*scene, self.scene);
    const std::size_t ids = scene->id == nullptr ? 0 : scene->contacts;
    self.solver.update(self.scene, std::span(scene->id, ids));
    self.bodies = scene->bodies;
    self.contacts = scene->contacts;
    self.claim = LCPBENCH_NOT_SOLVED_YET;
    self.is_loaded = true;
  });
}

int lcpbench_set_velocity(lcpbench_solver* solver, const double* velocity, size_t size) {
  return guarded(solver, [&](lcpbench_solver& self) {
    need(self.is_loaded, "nothing was loaded: call lcpbench_update first");
    need(velocity != nullptr || size == 0, "velocity is NULL");
    lcpbench::need_size(size, 6 * self.bodies, "velocity");
    self.solver.set_velocity(lcpbench::Vector::Map(velocity, static_cast<lcpbench::Index>(size)));
    self.claim = LCPBENCH_NOT_SOLVED_YET;
  });
}

int lcpbench_solve(lcpbench_solver* solver, double seconds, lcpbench_claim* claim) {
  return guarded(solver, [&](lcpbench_solver& self) {
    need(self.is_loaded, "nothing was loaded: call lcpbench_update first");
    if (!(seconds >= 0))
      throw lcpbench::InputError("seconds is " + std::to_string(seconds) + ", expected a number >= 0");
    self.claim = lcpbench::claim_of(self.solver.solve(seconds));
    if (claim != nullptr) *claim = self.claim;
    const lcpbench::Answer& answer = self.solver.answer();
    if (self.claim != LCPBENCH_SOLVED) {
      lcpbench::say(answer.detail.empty() ? to_string(answer.claim) : answer.detail.c_str());
    }
  });
}

int lcpbench_get_claim(lcpbench_solver* solver, lcpbench_claim* claim) {
  return guarded(solver, [&](lcpbench_solver& self) {
    need(claim != nullptr, "claim is NULL");
    *claim = self.claim;
  });
}

int lcpbench_get_velocity(lcpbench_solver* solver, double* velocity, size_t size) {
  return guarded(solver, [&](lcpbench_solver& self) {
    need(self.is_loaded, "nothing was loaded: call lcpbench_update first");
    need(velocity != nullptr || size == 0, "velocity is NULL");
    lcpbench::need_size(size, 6 * self.bodies, "velocity");
    lcpbench::Vector::Map(velocity, static_cast<lcpbench::Index>(size)) = self.solver.velocity();
  });
}

int lcpbench_get_impulses(lcpbench_solver* solver, double* impulses, size_t size) {
  return guarded(solver, [&](lcpbench_solver& self) {
    need(self.is_loaded, "nothing was loaded: call lcpbench_update first");
    need(impulses != nullptr || size == 0, "impulses is NULL");
    lcpbench::need_size(size, 3 * self.contacts, "impulses");
    for (std::size_t i = 0; i < self.contacts; ++i) {
      Eigen::Vector3d::Map(impulses + 3 * i) = self.solver.impulse(static_cast<lcpbench::Index>(i));
    }
  });
}

const char* lcpbench_error_text(void) { return lcpbench::error_text; }

}  // extern "C"
