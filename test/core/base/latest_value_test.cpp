// A slot between two threads: the newest value, never a torn one. Run under ThreadSanitizer by ./run test --sanitize thread.
#include "haptic_core/base/latest_value.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <thread>

namespace haptic {
namespace latest_value_test {

/// Larger than a cache line, all numbers equal: a torn copy would show two of them.
using Wide = std::array<std::uint64_t, 24>;

Wide wide(std::uint64_t x) {
  Wide value;
  value.fill(x);
  return value;
}

TEST(LatestValue, GivesTheInitialValueUntilOneIsWritten) {
  LatestValue<int> slot(7);
  int value = 0;
  EXPECT_FALSE(slot.read(value));
  EXPECT_EQ(value, 7);
}

TEST(LatestValue, GivesTheNewestOnceAsFreshAndKeepsIt) {
  LatestValue<int> slot;
  int value = 0;
  for (int i = 1; i <= 5; ++i) slot.write(i);
  EXPECT_TRUE(slot.read(value));
  EXPECT_EQ(value, 5);
  EXPECT_FALSE(slot.read(value));
  EXPECT_EQ(value, 5);
  slot.write(6);
  EXPECT_TRUE(slot.read(value));
  EXPECT_EQ(value, 6);
}

TEST(LatestValue, BetweenThreadsIsNeverTornAndNeverOlder) {
  constexpr std::uint64_t kLast = 50000;
  LatestValue<Wide> slot(wide(0));
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kLast; ++i) slot.write(wide(i));
  });
  // Ends by itself: the writer's last value stays in the slot until it is read.
  std::uint64_t last = 0;
  while (last < kLast) {
    Wide value;
    const bool fresh = slot.read(value);
    for (const std::uint64_t x : value) ASSERT_EQ(x, value[0]);
    ASSERT_GE(value[0], last);
    if (fresh) {
      ASSERT_GT(value[0], last);
    } else {
      ASSERT_EQ(value[0], last);
      std::this_thread::yield();
    }
    last = value[0];
  }
  writer.join();
}

}  // namespace latest_value_test
}  // namespace haptic
