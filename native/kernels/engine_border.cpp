#include "native/kernels/engine_border.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <new>

namespace lcpbench::lemke {

/// aligned_alloc of glibc splits a larger block in three each time, which took a quarter of a solve of many small
/// islands. Here the block begins before the aligned memory, at the address that stands in front of that.
void* allocate_aligned(std::size_t bytes) {
  constexpr std::size_t kAlignment = 64;
  static_assert(alignof(std::max_align_t) >= sizeof(void*));
  if (bytes > std::numeric_limits<std::size_t>::max() - 2 * kAlignment) throw std::bad_alloc();
  auto* const block = static_cast<std::byte*>(std::malloc((bytes / kAlignment + 2) * kAlignment));
  if (block == nullptr) throw std::bad_alloc();
  const std::size_t beyond = reinterpret_cast<std::uintptr_t>(block) % kAlignment;
  std::byte* const memory = block + (kAlignment - beyond);
  new (memory - sizeof(void*)) void*(block);
  return memory;
}

void free_aligned(void* memory) {
  if (memory == nullptr) return;
  std::free(*reinterpret_cast<void**>(static_cast<std::byte*>(memory) - sizeof(void*)));
}

}  // namespace lcpbench::lemke
