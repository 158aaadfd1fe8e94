#pragma once

#include <cstddef>

namespace lcpbench::testing {

/// False in builds whose allocator cannot be replaced (sanitizers, other C libraries than glibc): counts are 0 there.
bool allocations_are_counted();

void start_counting_allocations();
/// Calls of malloc, calloc, realloc and the aligned forms by this thread since the start.
int stop_counting_allocations();
/// Of the counted allocations.
std::size_t counted_bytes();

/// Allocations that `work` makes, in whatever library.
template <class Work>
int count_allocations(Work&& work) {
  start_counting_allocations();
  work();
  return stop_counting_allocations();
}

}  // namespace lcpbench::testing
