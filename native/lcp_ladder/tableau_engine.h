#pragma once

#include <cstddef>

#include "core/isa.h"

// The border between dense tableaus and their kernel, which is compiled once per instruction-set level. Only plain
// pointers cross it, for the reason that lemke_engine.h gives.

namespace lcpbench::tableau {

/// Columns have a multiple of so many entries, and the first begins at a multiple of as many doubles: else half of the
/// time goes to vectors that lie across two lines of the cache.
inline constexpr std::ptrdiff_t kLine = 8;

/// Exchanges that may wait. A tableau of some hundred rows does not fit into the nearest cache, so that it is read and
/// written once for so many exchanges.
inline constexpr std::ptrdiff_t kMostWaiting = 8;

/// basic = A nonbasic with exchanges that not all columns of A know of yet.
struct Tableau {
  double* A = nullptr;        ///< by columns
  std::ptrdiff_t stride = 0;  ///< of A and pivots; entries beyond the rows are scratch
  std::ptrdiff_t columns = 0;
  double* pivots = nullptr;                ///< kMostWaiting columns: those of the exchanges, as they were
  double* factors = nullptr;               ///< kMostWaiting rows of `columns` entries: what each column gets of them
  std::ptrdiff_t* known = nullptr;         ///< per column: the exchanges that it knows of
  std::ptrdiff_t rows[kMostWaiting] = {};  ///< of the exchanges
  std::ptrdiff_t waiting = 0;
};

/// The functions of a level. None allocates.
struct Engine {
  /// The column with all exchanges.
  void (*bring_up_to_date)(Tableau& tableau, std::ptrdiff_t column);
  /// Exchanges the basic variable of `row` with the nonbasic one of `column`.
  void (*exchange)(Tableau& tableau, std::ptrdiff_t row, std::ptrdiff_t column);
};

/// @param level must not exceed best_isa_level()
const Engine& engine_at(IsaLevel level);

namespace baseline {
extern const Engine kEngine;
}  // namespace baseline
namespace avx2 {
extern const Engine kEngine;
}  // namespace avx2
namespace avx512 {
extern const Engine kEngine;
}  // namespace avx512

}  // namespace lcpbench::tableau
