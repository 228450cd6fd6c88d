#include "haptic_core/base/sender_clock.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace haptic::sender_clock_test {
namespace {

constexpr std::int64_t kMs = 1'000'000, kHour = 3'600'000 * kMs;

TEST(SenderClock, KeepsTheTimeBetweenStamps) {
  SenderClock clock;
  std::mt19937 random(1);
  std::uniform_int_distribution<std::int64_t> way(0, 4 * kMs);
  std::int64_t before = 0;
  for (std::int64_t i = 1; i < 1000; ++i) {
    const std::int64_t own = clock.own(kHour + 10 * i * kMs, 10 * i * kMs + way(random));
    // The offset moves by a sixteenth of how far this way is from the mean of those before.
    if (before) EXPECT_NEAR(static_cast<double>(own - before), 10.0 * kMs, 4.0 * kMs / 16) << i;
    before = own;
  }
}

/// The sender's clock is set while it sends: no time is lost, and none is made.
TEST(SenderClock, FollowsAClockThatIsSet) {
  for (const std::int64_t set : {-kHour, -3000 * kMs, -200 * kMs, 3000 * kMs, kHour}) {
    SenderClock clock;
    std::int64_t before = 0;
    for (std::int64_t i = 1; i < 200; ++i) {
      const std::int64_t own = clock.own(2 * kHour + 10 * i * kMs + (i < 100 ? 0 : set), 10 * i * kMs);
      if (before) EXPECT_EQ(own - before, 10 * kMs) << set << " at " << i;
      before = own;
    }
  }
}

TEST(SenderClock, ASmallStepBackIsMadeGoodWithinATenth) {
  SenderClock clock;
  for (std::int64_t i = 1; i < 200; ++i) {
    const std::int64_t own = clock.own(kHour + 10 * i * kMs - (i < 100 ? 0 : 40 * kMs), 10 * i * kMs);
    EXPECT_LE(own, 10 * i * kMs + 5 * kMs);
    EXPECT_GE(own, 10 * i * kMs - 50 * kMs);
  }
}

TEST(SenderClock, FollowsSecondsOfAnotherLength) {
  for (const double rate : {0.5, 0.9, 1.1, 2.0}) {
    SenderClock clock;
    std::int64_t own = 0;
    for (std::int64_t i = 1; i < 1000; ++i) {
      const auto stamp = static_cast<std::int64_t>(rate * static_cast<double>(10 * i * kMs));
      const std::int64_t now = clock.own(kHour + stamp, 10 * i * kMs);
      EXPECT_GE(now, own);
      own = now;
      EXPECT_LE(std::abs(own - 10 * i * kMs), 61 * kMs) << rate;
    }
  }
}

TEST(SenderClock, TheSameStampIsTheSameMeasurement) {
  SenderClock clock;
  const std::int64_t own = clock.own(kHour, 1000 * kMs);
  EXPECT_EQ(clock.own(kHour, 1003 * kMs), own);
  EXPECT_EQ(clock.own(kHour, 2000 * kMs), 2000 * kMs) << "a sender whose clock stands is heard all the same";
  EXPECT_EQ(clock.own(0, 2010 * kMs), 2010 * kMs) << "no stamp";
}

/// Messages that waited in a queue come at once: the newest counts, and time does not go back.
TEST(SenderClock, ABurstDoesNotGoBack) {
  SenderClock clock;
  std::int64_t own = 0;
  for (std::int64_t i = 1; i < 300; ++i) {
    const bool waited = i >= 100 && i < 200;
    const std::int64_t now = clock.own(kHour + 10 * i * kMs, waited ? 2000 * kMs : 10 * i * kMs);
    EXPECT_GE(now, own);
    own = now;
    if (i > 206) EXPECT_NEAR(static_cast<double>(now), 10.0 * static_cast<double>(i) * kMs, 50.0 * kMs);
  }
}

}  // namespace
}  // namespace haptic::sender_clock_test
