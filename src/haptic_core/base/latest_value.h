/// A slot that hands the latest value from one writer thread to one reader thread, wait-free on both sides.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>

namespace haptic {

/// Hands the latest value from one thread to another.
/// Triple buffer: the writer fills a private buffer and swaps it in; the reader swaps the newest one out.
/// T must be copyable; neither side blocks, allocates or sees a torn value. One writer, one reader.
template <class T>
class LatestValue {
 public:
  /// `initial`: the value that is read before the first write.
  explicit LatestValue(const T& initial = T{}) { buffers_.fill(initial); }

  /// The writer's: replaces whatever has not been read.
  void write(const T& value) {
    buffers_[write_index_] = value;
    write_index_ = middle_.exchange(write_index_ | kFresh, std::memory_order_acq_rel) & kIndex;
  }

  /// Copies the newest value into `value`; true when it is newer than the one read before.
  bool read(T& value) {
    const bool fresh = middle_.load(std::memory_order_relaxed) & kFresh;
    if (fresh) read_index_ = middle_.exchange(read_index_, std::memory_order_acq_rel) & kIndex;
    value = buffers_[read_index_];
    return fresh;
  }

 private:
  static constexpr std::uint8_t kIndex = 3, kFresh = 4;
  std::array<T, 3> buffers_;
  std::uint8_t write_index_ = 0, read_index_ = 1;
  std::atomic<std::uint8_t> middle_{2};
};

}  // namespace haptic
