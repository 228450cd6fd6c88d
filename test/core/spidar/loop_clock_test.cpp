// Who made a silence, and for how long force may come back by itself: random silences against the two sums that define it.
#include "haptic_core/spidar/loop_clock.h"

#include <gtest/gtest.h>

#include <random>

namespace haptic {
namespace loop_clock_test {

constexpr double kStep = 1e-3;

/// Ticks that come late and boards that answer or do not, with and without stamps, against the sum of the true time.
TEST(LoopClock, ForceWaitsBeyondHalfASecondOfTrueTime) {
  std::mt19937 random(3);
  int waited = 0, returned = 0;
  for (int run = 0; run < 400; ++run) {
    LoopClock clock;
    const bool stamps = run % 2;
    double now = 1;
    DeviceSample sample;
    const auto tick = [&](double gap, bool lost) {
      now += gap;
      sample.stamp_ns = stamps ? static_cast<std::int64_t>(1e9 * now) : 0;
      const double beyond = kStep * std::floor((gap - kStep) / kStep + 1e-9);  // whole periods, as a wake counts them
      clock.take(sample, lost, kStep, {beyond, false});
    };
    for (int k = 0; k < 400; ++k) tick(kStep, false);
    ASSERT_FALSE(clock.forceWaits());
    const int losses = 1 + static_cast<int>(random() % 20);
    double absent = 0, longest = 0;
    bool waits = false;
    for (int k = 0; k < losses; ++k) {
      const double gap = kStep * (1 + static_cast<double>(random() % 60));
      tick(gap, true);
      absent += gap, longest = std::max(longest, gap);
      waits = waits || clock.forceWaits();
    }
    if (std::fabs(absent - LoopClock::kLasting) < 2 * kStep * losses) continue;  // a wake counts whole periods
    EXPECT_EQ(waits, absent > LoopClock::kLasting) << run << ' ' << absent;
    ++(waits ? waited : returned);
    for (int k = 0; k < 400; ++k) tick(kStep, false);
    EXPECT_FALSE(clock.linkLost());
    EXPECT_FALSE(clock.forceWaits());
    tick(kStep, true);
    EXPECT_FALSE(clock.forceWaits()) << "another silence, another sum";
  }
  EXPECT_GT(waited, 50);
  EXPECT_GT(returned, 50);
}

/// The boards' silence is counted in ticks that were on time, whatever this program and the machine did.
TEST(LoopClock, ASilenceOfThisProgramOrTheMachineIsNotTheBoards) {
  for (const bool asleep : {false, true}) {
    LoopClock clock;
    clock.take({}, false, kStep);
    clock.take({}, true, kStep, {60, asleep});
    EXPECT_TRUE(clock.forceWaits());
    EXPECT_TRUE(clock.late());
    EXPECT_EQ(clock.asleep(), asleep);
    EXPECT_FALSE(clock.silenceIsTheirs());
    EXPECT_NEAR(clock.lateBy(), 60, 1e-9);
    for (int k = 0; k < 600; ++k) clock.take({}, true, kStep);
    EXPECT_TRUE(clock.silenceLasts()) << "now it is";
  }
}

TEST(LoopClock, AnotherRunnerBeginsWithoutASilence) {
  LoopClock clock;
  DeviceSample sample;
  sample.stamp_ns = 1000000000;
  clock.take(sample, false, kStep);
  clock.handOver();
  sample.stamp_ns = 9000000000;
  clock.take(sample, false, kStep);
  EXPECT_FALSE(clock.forceWaits());
  EXPECT_FALSE(clock.late());
}

}  // namespace loop_clock_test
}  // namespace haptic
