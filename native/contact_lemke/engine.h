#pragma once

#include "native/contacts/contact_arrays.h"
#include "native/kernels/engine_border.h"

// The border between the solver `contact_lemke` and its engines, which are compiled once for baseline, once for AVX2
// (packs of 8 are slower here) and once in 113 bits. Only plain structs, pointers and virtual functions cross it, for
// the reason that engine_border.h gives.

namespace lcpbench::contact_lemke {

/// How one path is to be followed.
struct Rules {
  /// false: the covering vector acts on normal rows only, and friction rows exist only where a contact presses.
  /// true: it is positive on every row, and all friction rows exist: Lemke's method as its proofs have it.
  bool classic = false;
  std::ptrdiff_t variant = 0;  ///< > 0: unequal entries in the covering vector, another path for each number
  bool reinvert = false;       ///< invert the kernel, the square system of a basis (kernel.h), afresh at each pivot
  /// From the basis with which the last solve ended, instead of from z = 0. kBreakdown unless that one ended with
  /// kSolved, and not by `classic` rules.
  bool resume = false;
  std::ptrdiff_t max_pivots = 0;  ///< 0: none may be made
  std::ptrdiff_t max_work = __PTRDIFF_MAX__;  ///< Outcome::work at which the path stops before its next pivot
  double deadline_s = 0;          ///< on the clock below; infinity: none
  double (*clock_s)() = nullptr;  ///< monotonic; read every 16 pivots; null: no time limit
};

using lemke::Ending;

struct Outcome {
  Ending ending = Ending::kBreakdown;
  std::ptrdiff_t pivots = 0;
  std::ptrdiff_t factorizations = 0;  ///< inversions of a whole kernel
  /// Multiplications of the engine's numbers in vectors, and what takes as long.
  std::ptrdiff_t work = 0;
  bool is_out_of_work = false;  ///< kPivotLimit because of Rules::max_work
};

/// Only reserve() and load() allocate.
class Engine {
 public:
  Engine() = default;
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;
  virtual ~Engine();  // not inline, so that no object of a level has what all levels share

  /// Allocates all that load() needs for a problem of these dimensions.
  virtual void reserve(const Input& input) = 0;
  /// Allocates what was not reserved.
  virtual void load(const Input& input) = 0;
  /// @param v ngc entries, not copied: they must stay as they are
  virtual void set_velocity(const double* v) = 0;
  /// Follows one path. When the ending is kSolved, the positive impulses of the last basis are written to z; when it is
  /// kRay and no contact has friction, impulses u >= 0 along the ray, with N u in null(G) and (N'v + b)'u < 0 but for
  /// rounding.
  /// @param z n entries, all zero
  virtual Outcome solve(const Rules& rules, double* z) = 0;
  /// Sets the lambdas of z to the least that its impulses allow and evaluates the answer.
  virtual Residual complete(double* z) = 0;
  /// The velocity (ngc; none for the coordinate of an offset) that the impulses of z lead to: v + G* [N D] z.
  virtual void respond(const double* z, double* velocity) = 0;
};

// The caller owns what these create.
namespace baseline {
Engine* create_engine();
}  // namespace baseline
namespace avx2 {
Engine* create_engine();
}  // namespace avx2
/// In 113 bits.
namespace quad {
Engine* create_engine();
}  // namespace quad

}  // namespace lcpbench::contact_lemke
