#include "tests/support/allocation_counter.h"

#include <cerrno>
#include <cstdlib>

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define LCPBENCH_OWN_ALLOCATOR 0
#endif
#endif
#if !defined(LCPBENCH_OWN_ALLOCATOR)
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define LCPBENCH_OWN_ALLOCATOR 1
#else
#define LCPBENCH_OWN_ALLOCATOR 0
#endif
#endif

namespace {

thread_local bool counting = false;
thread_local int allocations = 0;
thread_local std::size_t bytes = 0;

[[maybe_unused]] void count(std::size_t size) {
  if (!counting) return;
  ++allocations;
  bytes += size;
}

}  // namespace

namespace lcpbench::testing {

bool allocations_are_counted() { return LCPBENCH_OWN_ALLOCATOR != 0; }

void start_counting_allocations() {
  allocations = 0;
  bytes = 0;
  counting = true;
}

int stop_counting_allocations() {
  counting = false;
  return allocations;
}

std::size_t counted_bytes() { return bytes; }

}  // namespace lcpbench::testing

#if LCPBENCH_OWN_ALLOCATOR

// The executable's definitions come before those of the C library, for every shared library too. operator new ends
// here.
extern "C" {

void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t number, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  count(size);
  return __libc_malloc(size);
}

void* calloc(std::size_t number, std::size_t size) {
  count(number * size);
  return __libc_calloc(number, size);
}

void* realloc(void* old, std::size_t size) {
  count(size);
  return __libc_realloc(old, size);
}

void* memalign(std::size_t alignment, std::size_t size) {
  count(size);
  return __libc_memalign(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }

int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
  void* memory = memalign(alignment, size);
  if (memory == nullptr) return ENOMEM;
  *result = memory;
  return 0;
}

}  // extern "C"

#endif
