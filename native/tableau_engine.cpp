// Compiled once per instruction-set level into the namespace LCPBENCH_LEVEL; see tableau_engine.h for what may cross
// the border.
#include "native/tableau_engine.h"

#if !defined(LCPBENCH_LEVEL)
#error "LCPBENCH_LEVEL names the instruction-set level"
#endif

namespace lcpbench::tableau::LCPBENCH_LEVEL {
namespace {

using Count = std::ptrdiff_t;

void exchange(double* A, Count rows, Count columns, Count row, Count column) {
  double* const pivot = A + column * rows;
  const double inverse = 1 / pivot[row];
  for (Count k = 0; k < columns; ++k) {
    double* const other = A + k * rows;
    if (k == column || other[row] == 0) continue;
    const double factor = -other[row] * inverse;
    const double* const __restrict from = pivot;
    double* const __restrict to = other;
    for (Count i = 0; i < rows; ++i) to[i] += from[i] * factor;
    other[row] = factor;
  }
  for (Count i = 0; i < rows; ++i) pivot[i] *= inverse;
  pivot[row] = inverse;
}

}  // namespace

const Exchange kExchange = exchange;

}  // namespace lcpbench::tableau::LCPBENCH_LEVEL
