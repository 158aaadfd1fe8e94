#include "native/kernels/engine_border.h"

#include <cstdlib>
#include <limits>
#include <new>

namespace lcpbench::lemke {

void* allocate_aligned(std::size_t bytes) {
  constexpr std::size_t kAlignment = 64;
  if (bytes > std::numeric_limits<std::size_t>::max() - 2 * kAlignment) throw std::bad_alloc();
  void* const memory = std::aligned_alloc(kAlignment, (bytes / kAlignment + 1) * kAlignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void free_aligned(void* memory) { std::free(memory); }

}  // namespace lcpbench::lemke
