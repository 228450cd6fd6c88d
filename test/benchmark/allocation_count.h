/// Counts heap allocations of the whole process. Include in one source file of a program (it replaces
/// malloc).
#pragma once
#include <atomic>
#include <cstdlib>

extern "C" void* __libc_malloc(std::size_t);  // glibc's own, under the name that it exports for this

namespace haptic::bench {
inline std::atomic<long> allocation_counter{0};
inline long allocationCount() {
  return allocation_counter.load();
}
}  // namespace haptic::bench

extern "C" void* malloc(std::size_t size) {
  haptic::bench::allocation_counter.fetch_add(1, std::memory_order_relaxed);
  return __libc_malloc(size);
}
