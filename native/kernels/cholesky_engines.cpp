#include "native/kernels/cholesky_engine.h"

#include <algorithm>

namespace lcpbench::cholesky {

void take_lower(const double* given, std::ptrdiff_t rows, double* a, std::ptrdiff_t stride) {
  for (std::ptrdiff_t c = 0; c < rows; ++c, given += rows, a += stride) {
    std::copy(given + c, given + rows, a + c);
    std::fill_n(a + rows, kMargin, 0.0);
  }
}

void keep_columns(const double* a, std::ptrdiff_t stride, std::ptrdiff_t rows, std::ptrdiff_t columns, double* l) {
  for (std::ptrdiff_t c = 0; c < columns; ++c, a += stride, l += rows) {
    std::copy(a + c, a + rows, l + c);
    l[c] = 1 / l[c];
  }
}

const Engine& engine([[maybe_unused]] IsaLevel level) {
#if defined(__x86_64__)
  if (level == IsaLevel::kAvx512) return avx512::kEngine;
  if (level == IsaLevel::kAvx2) return avx2::kEngine;
#endif
  return baseline::kEngine;
}

}  // namespace lcpbench::cholesky
