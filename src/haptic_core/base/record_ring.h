/// A bounded queue from one writer thread to one reader thread: every record, in order, or a counted loss.
#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace haptic {

/// A bounded queue from one thread to another.
/// Storage is sized once, at construction. A push on a full ring drops the new record and counts it, so that
/// the real-time side never waits. One writer, one reader.
template <class T>
class RecordRing {
 public:
  explicit RecordRing(std::size_t capacity) : slots_(capacity + 1) {}  ///< room for `capacity` records

  bool push(const T& record) {  ///< (in realtime)
    const std::size_t head = head_.load(std::memory_order_relaxed);
    const std::size_t next = advance(head);
    if (next == tail_.load(std::memory_order_acquire)) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    slots_[head] = record;
    head_.store(next, std::memory_order_release);
    return true;
  }

  /// The reader's: takes the oldest record; false when there is none.
  bool pop(T& record) {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail == head_.load(std::memory_order_acquire)) return false;
    record = std::move(slots_[tail]);  // the old record's memory is freed here, not by the writer
    tail_.store(advance(tail), std::memory_order_release);
    return true;
  }

  std::size_t capacity() const { return slots_.size() - 1; }  ///< records that fit
  /// Records lost to a full ring since construction.
  std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

 private:
  std::size_t advance(std::size_t i) const { return i + 1 == slots_.size() ? 0 : i + 1; }
  std::vector<T> slots_;
  std::atomic<std::size_t> head_{0}, tail_{0};
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace haptic
