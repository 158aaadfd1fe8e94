#pragma once

#include <cstddef>

#include "core/isa.h"

// The border between dense tableaus and their kernel, which is compiled once per instruction-set level. Only plain
// pointers cross it, for the reason that lemke_engine.h gives.

namespace lcpbench::tableau {

/// Columns have a multiple of so many entries, and the first begins at a multiple of as many doubles: else half of the
/// time goes to vectors that lie across two lines of the cache.
inline constexpr std::ptrdiff_t kLine = 8;

/// Exchanges the basic variable of `row` with the nonbasic one of `column` in basic = A nonbasic, A by columns of
/// `stride` entries, of which those beyond the rows are scratch. Allocates nothing.
using Exchange = void (*)(double* A, std::ptrdiff_t stride, std::ptrdiff_t columns, std::ptrdiff_t row,
                          std::ptrdiff_t column);

/// @param level must not exceed best_isa_level()
Exchange exchange_at(IsaLevel level);

namespace baseline {
extern const Exchange kExchange;
}  // namespace baseline
namespace avx2 {
extern const Exchange kExchange;
}  // namespace avx2
namespace avx512 {
extern const Exchange kExchange;
}  // namespace avx512

}  // namespace lcpbench::tableau
