#pragma once

#include "native/contacts/contact_arrays.h"
#include "native/kernels/engine_border.h"

// The border between the solver `contact_lemke` and its engine, which is compiled once per instruction-set level and
// once in 113-bit arithmetic.

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
  std::ptrdiff_t max_pivots = 0;  ///< over all parts of a path; 0: none may be made
  /// Outcome::work at which the path stops before its next pivot, to go on from there or not.
  std::ptrdiff_t max_work = __PTRDIFF_MAX__;
  /// From where the last path stopped at its max_work, by the same rules. Nothing else may have been solved meanwhile.
  bool goes_on = false;
  double deadline_s = 0;          ///< on the clock below; infinity: none
  double (*clock_s)() = nullptr;  ///< monotonic; read every 16 pivots; null: no time limit
};

using lemke::Ending;

struct Outcome {
  Ending ending = Ending::kBreakdown;
  std::ptrdiff_t pivots = 0;
  std::ptrdiff_t factorizations = 0;  ///< inversions of a whole kernel
  /// Multiplications of the engine's numbers in vectors, and what takes as long. Like `pivots` over all parts of a
  /// path.
  std::ptrdiff_t work = 0;
  bool can_go_on = false;  ///< kPivotLimit because of Rules::max_work
  bool cycles = false;     ///< kPivotLimit because a basis came back, which no larger limit mends
};

/// One engine at one level. `create` gives an object that `destroy` ends. `reserve` allocates all that `load` needs for
/// a problem of these dimensions, `load` what was not reserved; nothing else allocates.
struct Engine {
  void* (*create)();
  void (*destroy)(void* engine);
  void (*reserve)(void* engine, const Input& input);
  void (*load)(void* engine, const Input& input);
  /// @param v ngc entries, not copied: they must stay as they are
  void (*set_velocity)(void* engine, const double* v);
  /// Follows one path. When the ending is kSolved, the positive impulses of the last basis are written to z.
  /// @param z n entries, all zero
  Outcome (*solve)(void* engine, const Rules& rules, double* z);
  /// Sets the lambdas of z to the least that its impulses allow and evaluates the answer.
  Residual (*complete)(void* engine, double* z);
  /// The velocity (ngc; none for the coordinate of an offset) that the impulses of z lead to: v + G* [N D] z.
  void (*respond)(void* engine, const double* z, double* velocity);
  /// An upper bound of the share of the least eigenvalue of G, scaled to unit diagonal, that rounding may take;
  /// infinite where the factors are not those of G.
  double (*lost)(void* engine);
};

}  // namespace lcpbench::contact_lemke

namespace lcpbench::lemke {

namespace baseline {
extern const contact_lemke::Engine kContactEngine;
}  // namespace baseline
namespace avx2 {
extern const contact_lemke::Engine kContactEngine;
}  // namespace avx2
namespace quad {
extern const contact_lemke::Engine kContactEngine;
}

}  // namespace lcpbench::lemke
