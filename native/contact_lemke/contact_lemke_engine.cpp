// Lemke's method on contacts. Compiled by lcpbench_engines() of native/CMakeLists.txt into the namespace
// LCPBENCH_LEVEL, which is baseline, avx2 or quad: the last in 113-bit arithmetic (LCPBENCH_QUAD). See
// contact_lemke/engine.h for what may cross the border.
#include "native/contact_lemke/engine.h"

#include "native/contact_lemke/completion.h"
#include "native/contact_lemke/path.h"

namespace lcpbench::contact_lemke::LCPBENCH_LEVEL {
namespace {

template <class Scalar>
class PathAndCompletion final : public Engine {
 public:
  void reserve(const Input& input) override {
    path_.reserve(input);
    completion_.reserve();
  }
  void load(const Input& input) override {
    path_.load(input);
    completion_.load();
  }
  void set_velocity(const double* v) override { path_.set_velocity(v); }
  Outcome solve(const Rules& rules, double* z) override { return path_.solve(rules, z); }
  Residual complete(double* z) override { return completion_.run(z); }
  void respond(const double* z, double* velocity) override { completion_.respond(z, velocity); }

 private:
  lemke::LCPBENCH_LEVEL::Path<Scalar> path_;
  lemke::LCPBENCH_LEVEL::Completion<Scalar> completion_{path_.contacts(), path_.response()};
};

}  // namespace

#if defined(LCPBENCH_QUAD)
Engine* create_engine() { return new PathAndCompletion<Quad>; }
#else
Engine* create_engine() { return new PathAndCompletion<double>; }
#endif

}  // namespace lcpbench::contact_lemke::LCPBENCH_LEVEL
