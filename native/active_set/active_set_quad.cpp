// The active-set method in 113-bit arithmetic, the same at every instruction-set level.
#define LCPBENCH_LEVEL portable
#define LCPBENCH_QUAD
#include "native/active_set/dual_method.h"

namespace lcpbench::active_set::portable {

Engine* create_engine() { return new DualMethod<Quad>; }

}  // namespace lcpbench::active_set::portable
