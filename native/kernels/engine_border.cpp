#include "native/kernels/engine_border.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <new>

namespace lcpbench::lemke {
namespace {

constexpr std::size_t kAlignment = 64;

#if defined(__SANITIZE_ADDRESS__)
constexpr std::size_t kLargestShared = 0;  // so that the sanitizer sees the end of each
#else
constexpr std::size_t kLargestShared = 4096;
#endif
constexpr std::size_t kShared = 32768;

/// Memory of one malloc(), for one large request or for many small ones. The last of its users frees it.
struct Block {
  std::atomic<std::size_t> users;

  static Block* create(std::size_t bytes) {
    void* const memory = std::malloc(kAlignment + bytes);
    if (memory == nullptr) throw std::bad_alloc();
    return new (memory) Block{.users = 1};
  }
  void leave() {
    if (users.load(std::memory_order_acquire) == 1 || users.fetch_sub(1, std::memory_order_acq_rel) == 1) {
      std::free(this);
    }
  }
};

/// Gives its user the next aligned bytes from `at`; the word before them holds the block.
void* give(Block* block, std::byte* at) {
  std::byte* const memory = at + (kAlignment - reinterpret_cast<std::uintptr_t>(at) % kAlignment);
  new (memory - sizeof(void*)) Block*(block);
  return memory;
}

/// What this thread gives small requests of: a solver of few contacts takes some hundred buffers, and malloc() for each
/// would take a quarter of its time.
struct Shared {
  Block* block = nullptr;
  std::byte* next = nullptr;
  std::size_t left = 0;

  Shared() = default;
  Shared(const Shared&) = delete;
  Shared& operator=(const Shared&) = delete;
  ~Shared() {
    if (block != nullptr) block->leave();
  }

  void* take(std::size_t bytes) {
    if (left < bytes) renew();
    void* const memory = give(block, next);
    block->users.fetch_add(1, std::memory_order_relaxed);
    next += bytes;
    left -= bytes;
    return memory;
  }

 private:
  void renew() {
    Block* const fresh = Block::create(kShared);
    if (block != nullptr) block->leave();
    block = fresh;
    next = reinterpret_cast<std::byte*>(fresh) + sizeof(Block);
    left = kShared + kAlignment - sizeof(Block);
  }
};

thread_local Shared shared;

}  // namespace

void* allocate_aligned(std::size_t bytes) {
  if (bytes > std::numeric_limits<std::size_t>::max() - 4 * kAlignment) throw std::bad_alloc();
  const std::size_t whole = (bytes / kAlignment + 2) * kAlignment;
  if (whole <= kLargestShared) return shared.take(whole);
  Block* const own = Block::create(whole);
  return give(own, reinterpret_cast<std::byte*>(own) + sizeof(Block));
}

void free_aligned(void* memory) {
  if (memory == nullptr) return;
  (*reinterpret_cast<Block**>(static_cast<std::byte*>(memory) - sizeof(void*)))->leave();
}

}  // namespace lcpbench::lemke
