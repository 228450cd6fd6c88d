// What a wake-up counts as lost, from readings of both clocks: a late thread, a machine that slept, and a thread that lost its core
// between the two readings.
#include <gtest/gtest.h>

#include "haptic_core/loop/realtime.h"
#include "haptic_core/loop/tick_input.h"

namespace haptic {
namespace periodic_wake_test {

constexpr std::int64_t kMs = 1000000, kSecond = 1000 * kMs;

/// A wake whose deadline is a period after `steady`; the readings differ by `slept`.
struct Clocks {
  explicit Clocks(double rate) : wake(rate) {
    wake.start();
    steady = steadyNow(), boot = bootNow();
    next(0, 0);  // from now on the deadlines follow these numbers
    next(10 * kSecond, 0);
  }
  PeriodicWake::Wake next(std::int64_t ran_ns, std::int64_t slept_ns) {
    steady += ran_ns;
    boot += ran_ns + slept_ns;
    return wake.wokenAt(boot, steady);
  }
  PeriodicWake wake;
  std::int64_t steady = 0, boot = 0;
};

TEST(PeriodicWake, CountsWhatPassedAsleepOrAwake) {
  Clocks clocks(1000);
  PeriodicWake::Wake w = clocks.next(kMs, 0);
  EXPECT_EQ(w.lost_periods, 0);
  EXPECT_FALSE(w.asleep);
  w = clocks.next(5001 * kMs, 0);  // stopped: the steady clock goes on
  EXPECT_EQ(w.lost_periods, 5000);
  EXPECT_FALSE(w.asleep);
  w = clocks.next(kMs, 60 * kSecond);  // asleep: it does not
  EXPECT_EQ(w.lost_periods, 60000);
  EXPECT_TRUE(w.asleep);
  EXPECT_EQ(w.lateness_ns, 0) << "awake, the thread was on time";
  w = clocks.next(kMs, 0);  // counted once
  EXPECT_EQ(w.lost_periods, 0);
  EXPECT_FALSE(w.asleep);
}

TEST(PeriodicWake, AThreadThatLosesItsCoreBetweenTheReadingsHasNotSlept) {
  Clocks clocks(1000);
  // The boot clock is read first: it is too early by what passed between the two.
  PeriodicWake::Wake w = clocks.wake.wokenAt(clocks.boot + kMs, clocks.steady + 301 * kMs);
  EXPECT_EQ(w.lost_periods, 300);
  EXPECT_FALSE(w.asleep);
  clocks.next(302 * kMs, 0);
  w = clocks.next(kMs, 0);
  EXPECT_EQ(w.lost_periods, 0);
  EXPECT_FALSE(w.asleep) << "nor does it look so when the next readings come at once";
}

TEST(PeriodicWake, AMonthAsleepDoesNotOverflow) {
  Clocks clocks(20000);
  const PeriodicWake::Wake w = clocks.next(kMs, 30LL * 24 * 3600 * kSecond);
  EXPECT_GT(w.lost_periods, 1 << 29);
  TickInput input, read;
  input.lost_periods = w.lost_periods, input.asleep = w.asleep;
  takeLostWord(lostWord(input), read);
  EXPECT_EQ(read.lost_periods, w.lost_periods);
  EXPECT_TRUE(read.asleep);
  takeLostWord(7, read);  // as recordings of before have it
  EXPECT_EQ(read.lost_periods, 7);
  EXPECT_FALSE(read.asleep);
}

}  // namespace periodic_wake_test
}  // namespace haptic
