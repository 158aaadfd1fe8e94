#include "core/quad.h"

#include <cmath>

namespace lcpbench {

Quad sqrt(Quad x) {
  if (x <= 0) return 0;
  if (!is_finite(x)) return x;  // NaN, too
  Quad scale = 1;
  while (x > 0x1p1000) {
    x *= 0x1p-400;
    scale *= 0x1p200;
  }
  while (x < 0x1p-1000) {
    x *= 0x1p400;
    scale *= 0x1p-200;
  }
  Quad root = std::sqrt(static_cast<double>(x));
  for (int step = 0; step < 2; ++step) root = (root + x / root) / 2;
  return root * scale;
}

}  // namespace lcpbench
