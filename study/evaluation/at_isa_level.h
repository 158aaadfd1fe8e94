#pragma once

#include "core/isa.h"

namespace lcpbench {

/// Marks the one of two builds of a function that is for kAvx2 and above. No other processor has that level.
#if defined(__x86_64__)
#define LCPBENCH_AVX2 __attribute__((target("avx2,fma")))
#else
#define LCPBENCH_AVX2
#endif

/// The build of a function for the level in use.
template <class Function>
Function* at_isa_level(Function* baseline, Function* avx2) {
  return isa_level() >= IsaLevel::kAvx2 ? avx2 : baseline;
}

}  // namespace lcpbench
