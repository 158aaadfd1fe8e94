// Compiled once per instruction-set level into the namespace LCPBENCH_LEVEL; see tableau_engine.h for what may cross
// the border.
#include "native/tableau_engine.h"

#if !defined(LCPBENCH_LEVEL)
#error "LCPBENCH_LEVEL names the instruction-set level"
#endif

namespace lcpbench::tableau::LCPBENCH_LEVEL {
namespace {

using Count = std::ptrdiff_t;

void exchange(double* A, Count stride, Count columns, Count row, Count column) {
  const Count lines = stride / kLine;
  double* const pivot = static_cast<double*>(__builtin_assume_aligned(A + column * stride, kLine * sizeof(double)));
  const double inverse = 1 / pivot[row];
  for (Count k = 0; k < columns; ++k) {
    double* const __restrict other =
        static_cast<double*>(__builtin_assume_aligned(A + k * stride, kLine * sizeof(double)));
    if (k == column || other[row] == 0) continue;
    const double factor = -other[row] * inverse;
    for (Count i = 0; i < lines * kLine; ++i) other[i] += pivot[i] * factor;
    other[row] = factor;
  }
  for (Count i = 0; i < lines * kLine; ++i) pivot[i] *= inverse;
  pivot[row] = inverse;
}

}  // namespace

const Exchange kExchange = exchange;

}  // namespace lcpbench::tableau::LCPBENCH_LEVEL
