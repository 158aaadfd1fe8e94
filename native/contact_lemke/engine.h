#pragma once

#include "native/lemke/lemke_engine.h"

// The border between the solver `contact_lemke` and its engine, which is compiled once per instruction-set level and
// once in 113-bit arithmetic. Only plain structs and pointers cross it, for the reason given in
// native/lemke/lemke_engine.h.

namespace lcpbench::contact_lemke {

/// How the inertia is given; the arrays are read during load() only.
struct InertiaInput {
  std::ptrdiff_t blocks = 0;                ///< G = diag(blocks); 0 when it is given otherwise
  const std::ptrdiff_t* offsets = nullptr;  ///< blocks + 1
  const double* const* G = nullptr;         ///< each block by columns
  std::ptrdiff_t factors = -1;              ///< G = X diag(alpha) X' when >= 0
  const double* X = nullptr;                ///< ngc x factors by columns
  const double* alpha = nullptr;
  const double* Ginv = nullptr;  ///< G* itself, ngc x ngc, or nullptr
};

/// A contact problem. v, N, D, friction_begin and mu must stay valid until the next load().
///
/// An offset b of the normal rows comes as one coordinate more, the last: no impulse moves it, so that the inertia has
/// no row for it, nor have velocities that are returned. With its speed s in v and b / s in N, velocities that N'v
/// gives have b in them.
struct Input {
  std::ptrdiff_t ngc = 0;
  bool has_offset = false;
  std::ptrdiff_t nc = 0;
  const double* v = nullptr;                       ///< ngc
  const double* N = nullptr;                       ///< ngc x nc by columns
  const double* D = nullptr;                       ///< ngc x friction_begin[nc] by columns
  const std::ptrdiff_t* friction_begin = nullptr;  ///< nc + 1
  const double* mu = nullptr;                      ///< nc
  // Of soft contacts: all of these, or none where no contact is soft.
  const double* compliance_n = nullptr;  ///< nc
  const double* compliance_t = nullptr;  ///< nc
  const double* offset_t = nullptr;      ///< 2 nc
  const double* tangents = nullptr;      ///< 2 x friction_begin[nc] by columns: D by the two tangents of its contact
  /// Parts that nothing couples: answers are measured by the scale of each. nullptr: all is one part. -1: of none.
  std::ptrdiff_t islands = 1;
  const std::ptrdiff_t* island_of_contact = nullptr;     ///< nc
  const std::ptrdiff_t* island_of_coordinate = nullptr;  ///< ngc
  InertiaInput inertia;
};

/// How one path is to be followed.
struct Rules {
  /// false: the covering vector acts on normal rows only, and friction rows exist only where a contact presses.
  /// true: it is positive on every row, and so are friction rows there: Lemke's method as its proofs have it.
  bool classic = false;
  std::ptrdiff_t variant = 0;  ///< > 0: unequal entries in the covering vector, another path for each number
  bool reinvert = false;       ///< invert the kernel afresh at each pivot
  /// From the basis with which the last solve ended, instead of from z = 0. A breakdown where there is none.
  bool resume = false;
  std::ptrdiff_t max_pivots = 0;
  /// Outcome::work at which the path stops before its next pivot, to go on from there or not.
  std::ptrdiff_t max_work = __PTRDIFF_MAX__;
  /// From where the last path stopped at its max_work, by the same rules. Nothing else may have been solved meanwhile.
  bool goes_on = false;
  double deadline_s = 0;          ///< on the clock below; infinity: none
  double (*clock_s)() = nullptr;  ///< monotonic; read every 16 pivots
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

/// What an answer is worth, evaluated from v, N, D, mu and the inertia in the engine's arithmetic, each island relative
/// to its own scale: max|q| or, where that is less, 1e4 times the rounding of q in double. Of the islands the worst.
struct Residual {
  double velocity = 0;  ///< bound on the velocity residual: max |w_i| where z_i > 0, max(0, -w_i) elsewhere
  /// The same with a bound on its rounding added, that of G's factors included: infinite where they have lost all.
  double certain = 0;
};

/// One engine at one level. `create` gives an object that `destroy` ends. `reserve` allocates all that `load` needs for
/// a problem of these dimensions, `load` what was not reserved; nothing else allocates.
struct Engine {
  void* (*create)();
  void (*destroy)(void* engine);
  void (*reserve)(void* engine, const Input& input);
  void (*load)(void* engine, const Input& input);
  void (*set_velocity)(void* engine, const double* v);
  /// Follows one path. Impulses of the last basis go to z (all n entries; lambdas are zero) when the ending is kSolved.
  Outcome (*solve)(void* engine, const Rules& rules, double* z);
  /// Sets the lambdas of z to the least that its impulses allow and evaluates the answer.
  Residual (*complete)(void* engine, double* z);
  /// The velocity (ngc) that the impulses of z lead to: v + G* [N D] z.
  void (*respond)(void* engine, const double* z, double* velocity);
  /// At most the share of the least eigenvalue of G, scaled to unit diagonal, that rounding takes; infinite where the
  /// factors are not those of G.
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
