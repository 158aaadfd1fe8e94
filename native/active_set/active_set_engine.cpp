// Compiled by lcpbench_engines() of native/CMakeLists.txt into the namespace LCPBENCH_LEVEL, which is baseline or avx2.
// See active_set_engine.h for what may cross the border.
#include "native/active_set/projection.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

Engine* create_engine() { return new Projection; }

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
