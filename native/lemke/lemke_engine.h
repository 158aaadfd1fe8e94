#pragma once

#include "native/kernels/engine_border.h"

// The border between Lemke's solver and its engines, which are compiled once per instruction-set level.

namespace lcpbench::lemke {

/// Variables are numbered w_i = i, z_i = n + i, artificial = 2 n (i < n).
struct Input {
  std::ptrdiff_t n = 0;
  /// Order of the leading dense block of M: all of a bare LCP; the impulses (nc + friction) of a contact problem, whose
  /// remaining rows and columns, one per friction cone, are given by `friction_begin`, `cone_normal` and `mu`.
  std::ptrdiff_t dense = 0;
  std::ptrdiff_t cones = 0;
  const double* q = nullptr;  ///< n
  /// The covering vector is 1 where q < 0, else 0; with covers_all different numbers from 1 to 2, but 0 in cone rows.
  bool covers_all = false;

  const double* M = nullptr;  ///< dense x dense by columns, or nullptr when the block is J' Ginv J
  std::ptrdiff_t ngc = 0;
  const double* J = nullptr;     ///< ngc x dense by rows, one row per generalized coordinate
  const double* Ginv = nullptr;  ///< ngc x ngc

  const std::ptrdiff_t* friction_begin = nullptr;  ///< cones + 1 offsets into the rows of the dense block
  const std::ptrdiff_t* cone_normal = nullptr;     ///< cones: row of the cone's normal impulse
  const double* mu = nullptr;                      ///< cones
};

struct Rules {
  double pivot_tolerance = 0;
  double zero_tolerance = 0;
  std::ptrdiff_t max_pivots = 0;
  double deadline_s = 0;          ///< on the clock below; infinity: none
  double (*clock_s)() = nullptr;  ///< monotonic clock, read every 16 pivots
  void (*on_pivot)(void* context, std::ptrdiff_t entering, std::ptrdiff_t leaving) = nullptr;  ///< nullptr: silent
  void* context = nullptr;
};

struct Outcome {
  Ending ending = Ending::kBreakdown;
  std::ptrdiff_t pivots = 0;  ///< without the first exchange, which brings the artificial variable in
  std::ptrdiff_t factorizations = 0;
};

class Engine {
 public:
  Engine() = default;
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;
  virtual ~Engine();  // not inline, so that no object of a level has what all levels share

  /// Copies all of the input and allocates for it.
  virtual void load(const Input& input) = 0;
  /// Writes the basic entries of z (n) when the ending is kSolved, and leaves it alone otherwise.
  virtual Outcome solve(const Rules& rules, double* z) = 0;
};

namespace baseline {
Engine* create_dense_engine();
Engine* create_kernel_engine();
}  // namespace baseline
namespace avx2 {
Engine* create_dense_engine();
Engine* create_kernel_engine();
}  // namespace avx2
namespace avx512 {
Engine* create_dense_engine();
Engine* create_kernel_engine();
}  // namespace avx512

}  // namespace lcpbench::lemke
