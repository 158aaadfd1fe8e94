// Lemke's method on contacts. Compiled once per instruction-set level into the namespace LCPBENCH_LEVEL, and once in
// 113-bit arithmetic (LCPBENCH_QUAD); see contact_lemke/engine.h for what may cross the border.
#include <new>

#include "native/contact_lemke/completion.h"
#include "native/contact_lemke/engine.h"
#include "native/contact_lemke/path.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {
namespace {

template <class Scalar>
struct Loaded {
  Path<Scalar> path;
  Completion<Scalar> completion{path.contacts(), path.response()};
};

template <class Scalar>
struct ContactInterface {
  using Object = Loaded<Scalar>;
  static Object& object(void* memory) { return *static_cast<Object*>(memory); }

  static void* create() { return new (allocate_aligned(sizeof(Object))) Object; }
  static void destroy(void* memory) {
    object(memory).~Object();
    free_aligned(memory);
  }
  static void reserve(void* memory, const contact_lemke::Input& input) {
    object(memory).path.reserve(input);
    object(memory).completion.reserve();
  }
  static void load(void* memory, const contact_lemke::Input& input) {
    object(memory).path.load(input);
    object(memory).completion.load();
  }
  static void set_velocity(void* memory, const double* v) { object(memory).path.set_velocity(v); }
  static contact_lemke::Outcome solve(void* memory, const contact_lemke::Rules& rules, double* z) {
    return object(memory).path.solve(rules, z);
  }
  static contact_lemke::Residual complete(void* memory, double* z) { return object(memory).completion.run(z); }
  static void respond(void* memory, const double* z, double* velocity) {
    object(memory).completion.respond(z, velocity);
  }
  static double lost(void* memory) { return object(memory).completion.lost(); }
};

template <class Scalar>
constexpr contact_lemke::Engine contact_engine() {
  using I = ContactInterface<Scalar>;
  return {I::create, I::destroy,  I::reserve, I::load, I::set_velocity,
          I::solve,  I::complete, I::respond, I::lost};
}

}  // namespace

#if defined(LCPBENCH_QUAD)
const contact_lemke::Engine kContactEngine = contact_engine<Quad>();
#else
const contact_lemke::Engine kContactEngine = contact_engine<double>();
#endif

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
