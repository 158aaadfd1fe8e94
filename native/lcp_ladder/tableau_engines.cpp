#include "native/lcp_ladder/tableau_engine.h"

namespace lcpbench::tableau {

const Engine& engine_at([[maybe_unused]] IsaLevel level) {
#if defined(__x86_64__)
  if (level == IsaLevel::kAvx512) return avx512::kEngine;
  if (level == IsaLevel::kAvx2) return avx2::kEngine;
#endif
  return baseline::kEngine;
}

}  // namespace lcpbench::tableau
