// Compiled once per instruction-set level into the namespace LCPBENCH_LEVEL, and in sums of two doubles
// (LCPBENCH_DOUBLE_DOUBLE) with and without the processor's fused multiply-add; see active_set_engine.h for
// what may cross the border.
#include "native/active_set/engine.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

#if defined(LCPBENCH_DOUBLE_DOUBLE)
const Engine kDoubleDoubleEngine = engine_over<DoubleDouble>();
#else
const Engine kDoubleEngine = engine_over<double>();
#endif

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
