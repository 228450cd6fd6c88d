/// Counts heap allocations of the whole process, libraries included. Include in one source file of a program:
/// it replaces malloc and its kin.
#pragma once
#include <atomic>
#include <cstdlib>

// glibc's own, under the names that it exports for this.
extern "C" void* __libc_malloc(std::size_t);
extern "C" void* __libc_calloc(std::size_t, std::size_t);
extern "C" void* __libc_realloc(void*, std::size_t);
extern "C" void* __libc_memalign(std::size_t, std::size_t);

namespace haptic::bench {
inline std::atomic<long> allocation_counter{0};
inline long allocationCount() {
  return allocation_counter.load();
}
inline void countAllocation() {
  allocation_counter.fetch_add(1, std::memory_order_relaxed);
}
}  // namespace haptic::bench

extern "C" void* malloc(std::size_t size) noexcept {
  haptic::bench::countAllocation();
  return __libc_malloc(size);
}
extern "C" void* calloc(std::size_t count, std::size_t size) noexcept {
  haptic::bench::countAllocation();
  return __libc_calloc(count, size);
}
extern "C" void* realloc(void* block, std::size_t size) noexcept {
  haptic::bench::countAllocation();
  return __libc_realloc(block, size);
}
extern "C" void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  haptic::bench::countAllocation();
  return __libc_memalign(alignment, size);
}
extern "C" int posix_memalign(void** block, std::size_t alignment, std::size_t size) noexcept {
  haptic::bench::countAllocation();
  *block = __libc_memalign(alignment, size);
  return *block ? 0 : 12;  // ENOMEM
}
