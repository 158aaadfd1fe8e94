// Compiled once per instruction-set level into the namespace LCPBENCH_LEVEL; see active_set_engine.h for what may cross
// the border.
#include "native/active_set/engine.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

const Engine kDoubleEngine = engine_over<double>();

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
