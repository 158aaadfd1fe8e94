#include "native/kernels/engine_border.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <new>

namespace lcpbench::lemke {

/// Over-allocates by malloc() and stores the address of the block in the word before the aligned memory, where
/// free_aligned() reads it. aligned_alloc() of glibc, which splits a larger block each time, would take a quarter of a
/// solve of many small islands.
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
