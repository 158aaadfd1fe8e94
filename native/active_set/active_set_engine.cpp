// Compiled by lcpbench_engines() of native/CMakeLists.txt into the namespace LCPBENCH_LEVEL, which is baseline, avx2 or
// quad: the last in 113-bit arithmetic (LCPBENCH_QUAD). See active_set_engine.h for what may cross the border.
#include "native/active_set/dual_method.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

#if defined(LCPBENCH_QUAD)
Engine* create_engine() { return new DualMethod<Quad>; }
#else
Engine* create_engine() { return new DualMethod<double>; }
#endif

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
