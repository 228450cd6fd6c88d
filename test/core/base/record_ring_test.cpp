// A queue between two threads: every record in order, or a counted loss. Run under ThreadSanitizer by
// ./run test --sanitize thread.
#include "haptic_core/base/record_ring.h"

#include <gtest/gtest.h>

#include <array>
#include <thread>

namespace haptic {
namespace record_ring_test {

TEST(RecordRing, HoldsItsCapacityAndCountsWhatItDrops) {
  RecordRing<int> ring(3);
  EXPECT_EQ(ring.capacity(), 3u);
  for (int i = 1; i <= 5; ++i) EXPECT_EQ(ring.push(i), i <= 3);
  EXPECT_EQ(ring.dropped(), 2u);
  int value = 0;
  for (int i = 1; i <= 3; ++i) {
    ASSERT_TRUE(ring.pop(value));
    EXPECT_EQ(value, i);
  }
  EXPECT_FALSE(ring.pop(value));
}

TEST(RecordRing, KeepsTheOrderAroundItsEnd) {
  RecordRing<int> ring(4);
  int next = 0, expected = 0, value = 0;
  for (int round = 0; round < 20; ++round) {  // 3 in, 3 out: the seam between the last slot and the first moves along
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(ring.push(next++));
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(ring.pop(value));
      EXPECT_EQ(value, expected++);
    }
  }
  EXPECT_EQ(ring.dropped(), 0u);
}

TEST(RecordRing, BetweenThreadsLosesNothingUncounted) {
  struct Record {
    std::array<std::uint64_t, 12> numbers;
  };
  constexpr std::uint64_t kRecords = 50000;
  RecordRing<Record> ring(64);
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kRecords; ++i) {
      Record record;
      record.numbers.fill(i);
      ring.push(record);
    }
    done.store(true, std::memory_order_release);
  });
  std::uint64_t taken = 0, last = 0;
  Record record;
  for (;;) {
    const bool was_done = done.load(std::memory_order_acquire);  // before the pop: what it finds empty stays empty
    if (!ring.pop(record)) {
      if (was_done) break;
      std::this_thread::yield();
      continue;
    }
    for (const std::uint64_t x : record.numbers) ASSERT_EQ(x, record.numbers[0]);
    ASSERT_GT(record.numbers[0], last);
    last = record.numbers[0];
    ++taken;
  }
  writer.join();
  EXPECT_EQ(taken + ring.dropped(), kRecords);
}

}  // namespace record_ring_test
}  // namespace haptic
