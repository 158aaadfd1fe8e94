// The active-set method in 113-bit arithmetic, the same at every instruction-set level.
#define LCPBENCH_LEVEL portable
#define LCPBENCH_QUAD
#include "native/active_set/engine.h"

namespace lcpbench::active_set::portable {

const Engine kQuadEngine = engine_over<Quad>();

}  // namespace lcpbench::active_set::portable
