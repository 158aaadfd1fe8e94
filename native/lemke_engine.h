#pragma once

#include <cstddef>

// The border between Lemke's solver and its engines, which are compiled once per instruction-set level. Only plain
// structs and pointers cross it: an inline function or template that both sides instantiate could be taken by the
// linker from the object compiled for a newer processor, and then crash the rest of the program on an older one.

namespace lcpbench::lemke {

/// Variables are numbered w_i = i, z_i = n + i, artificial = 2 n (i < n).
struct Input {
  std::ptrdiff_t n = 0;
  /// Order of the leading dense block of M: all of a bare LCP; the impulses (nc + friction) of a contact problem, whose
  /// remaining rows and columns, one per friction cone, are given by `friction_begin`, `cone_normal` and `mu`.
  std::ptrdiff_t dense = 0;
  std::ptrdiff_t cones = 0;
  const double* q = nullptr;  ///< n

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
  bool resolve = true;  ///< recompute the basic values from the basis at each pivot instead of updating them
  std::ptrdiff_t max_pivots = 0;
  double deadline_s = 0;          ///< on the clock below; infinity: none
  double (*clock_s)() = nullptr;  ///< monotonic clock, read every 16 pivots
  void (*on_pivot)(void* context, std::ptrdiff_t entering, std::ptrdiff_t leaving) = nullptr;  ///< nullptr: silent
  void* context = nullptr;
};

enum class Ending { kSolved, kRay, kPivotLimit, kTimeLimit, kBreakdown };

struct Outcome {
  Ending ending = Ending::kBreakdown;
  std::ptrdiff_t pivots = 0;  ///< without the first exchange, which brings the artificial variable in
  std::ptrdiff_t factorizations = 0;
};

/// One engine at one level. `create` gives an object that `destroy` ends; `load` copies all of the input and allocates
/// for it; `solve` writes z (n) when the ending is kSolved, and leaves it alone otherwise.
struct Engine {
  void* (*create)();
  void (*destroy)(void* engine);
  void (*load)(void* engine, const Input& input);
  Outcome (*solve)(void* engine, const Rules& rules, double* z);
};

namespace baseline {
extern const Engine kDenseEngine;
extern const Engine kKernelEngine;
}  // namespace baseline
namespace avx2 {
extern const Engine kDenseEngine;
extern const Engine kKernelEngine;
}  // namespace avx2
namespace avx512 {
extern const Engine kDenseEngine;
extern const Engine kKernelEngine;
}  // namespace avx512

/// 64-byte aligned memory for the engines. @throws std::bad_alloc
void* allocate_aligned(std::size_t bytes);
void free_aligned(void* memory);

}  // namespace lcpbench::lemke
