#pragma once

#include <cstddef>

// What all engines share at the border to their solvers. Engines are compiled once per instruction-set level. Only
// plain structs and pointers cross the border: an inline function or template that both sides instantiate could be
// taken by the linker from the object compiled for a newer processor, and then crash the rest of the program on an
// older one.

namespace lcpbench::lemke {

/// How a path ends.
enum class Ending { kSolved, kRay, kPivotLimit, kTimeLimit, kBreakdown };

/// At least `bytes` of uninitialised memory, 64-byte aligned, never null. Only free_aligned() may free it.
/// @throws std::bad_alloc
void* allocate_aligned(std::size_t bytes);
void free_aligned(void* memory);  ///< null is ignored

}  // namespace lcpbench::lemke
