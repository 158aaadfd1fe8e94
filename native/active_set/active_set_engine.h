#pragma once

#include <cstddef>

// The border between the active-set solver and its engines, which are compiled once for baseline and once for AVX2
// (packs of 8 are slower here). Only plain structs, pointers and virtual functions cross it, for the reason that
// engine_border.h gives.

namespace lcpbench::active_set {

enum class InertiaForm { kDense, kFactors, kInverse };

/// A frictionless contact problem. Matrices by columns; not owned. All but v and alpha must stay valid until the
/// next load().
struct Input {
  std::ptrdiff_t ngc = 0;
  std::ptrdiff_t nc = 0;
  std::ptrdiff_t soft = 0;  ///< contacts that may have a compliance: nc or 0
  const double* v = nullptr;  ///< ngc
  const double* N = nullptr;  ///< ngc x nc
  const double* b = nullptr;  ///< nc, the offset: N'u + b >= 0; nullptr: zero
  const double* compliance = nullptr;  ///< nc, r_n: N'u + b + r_n z >= 0; nullptr: zero
  /// nc / 3 coefficients of friction: three columns of N, with their b and compliance > 0, are then the normal and the
  /// two tangents of a contact, and z of tangents has either sign. Of such a problem `solve` writes z alone, does not
  /// test it, and takes no limit on work. nullptr: no friction.
  const double* mu = nullptr;
  InertiaForm form = InertiaForm::kDense;
  const double* matrix = nullptr;  ///< kDense: G; kInverse: G*, both ngc x ngc; kFactors: X, ngc x factors
  std::ptrdiff_t factors = 0;
  const double* alpha = nullptr;  ///< kFactors: weights > 0
  /// Parts that nothing couples: answers are measured by the scale of each. nullptr: all is one part. -1: of none.
  std::ptrdiff_t islands = 1;
  const std::ptrdiff_t* island_of_contact = nullptr;     ///< nc
  const std::ptrdiff_t* island_of_coordinate = nullptr;  ///< ngc
};

struct Rules {
  double accept_residual = 0;     ///< of the engine's own test, its rounding included; relative to each island's scale
  std::ptrdiff_t max_steps = 0;   ///< changes of the active set
  std::ptrdiff_t max_work = __PTRDIFF_MAX__;  ///< Outcome::work at which it stops before its next step
  double time_limit_s = 0;        ///< infinity: none
  double begin_s = 0;             ///< from when the limit counts, on the clock below; NaN: from its first reading
  double (*clock_s)() = nullptr;  ///< monotonic clock, read every 16 steps where there is a limit
  const double* start = nullptr;  ///< nc: contacts with a positive entry are active at the start; nullptr: none
};

enum class Ending {
  kSolved,
  kInfeasible,  ///< the normals of some contacts depend on each other and their velocities cannot all become >= 0
  kRejected,    ///< an optimal active set was found, but its answer does not pass the engine's own test
  kStepLimit,
  kTimeLimit,
  kWorkLimit,
  kBreakdown  ///< inertia indefinite, or singular to double; overflow
};

struct Outcome {
  Ending ending = Ending::kBreakdown;
  std::ptrdiff_t steps = 0;           ///< contacts added to or dropped from the active set, warm start included
  std::ptrdiff_t factorizations = 0;  ///< of a whole active set
  /// Multiplications in vectors, and what takes as long; the whole test of the answer aside.
  std::ptrdiff_t work = 0;
  bool has_velocity = false;  ///< the velocity that is written is that of the impulses: see VelocityTest
};

/// `update` and `solve` allocate nothing.
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
  /// Another velocity (ngc), which is copied, for the same contacts.
  virtual void update(const double* v) = 0;
  /// Writes z (nc) and velocity (ngc) when the ending is kSolved or kRejected, u (nc) when it is kInfeasible: u >= 0
  /// with N u in null(G) and (N'v + b)'u < 0, to rounding.
  virtual Outcome solve(const Rules& rules, double* z, double* velocity, double* u) = 0;
  /// The residual of z (nc) in the test that solve() makes of its own answer, of the worst island relative to its
  /// scale, without a bound on its rounding.
  virtual double residual(const double* z) = 0;
};

// The caller owns what these create.
namespace baseline {
Engine* create_engine();
}  // namespace baseline
namespace avx2 {
Engine* create_engine();
}  // namespace avx2

}  // namespace lcpbench::active_set
