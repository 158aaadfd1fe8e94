#include "native/tableau_engine.h"

namespace lcpbench::tableau {

Exchange exchange_at([[maybe_unused]] IsaLevel level) {
#if defined(__x86_64__)
  if (level == IsaLevel::kAvx512) return avx512::kExchange;
  if (level == IsaLevel::kAvx2) return avx2::kExchange;
#endif
  return baseline::kExchange;
}

}  // namespace lcpbench::tableau
