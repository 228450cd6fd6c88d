// The latency test's verdicts and advice on timings made by hand.
#include "spidar_driver/latency/tick_timing.h"

#include <gtest/gtest.h>

#include <cmath>

namespace haptic {
namespace tick_timing_test {

TickTiming evenRun(double rate_hz, double round_trip_us, long ticks = 1000) {
  TickTiming t;
  t.rate_hz = rate_hz;
  t.ticks = ticks;
  t.round_trip_us.assign(static_cast<std::size_t>(ticks), round_trip_us);
  t.lateness_us.assign(static_cast<std::size_t>(ticks), 20);
  return t;
}

TEST(TickTiming, PercentilesOfKnownValues) {
  std::vector<double> values;
  for (int i = 100; i >= 0; --i) values.push_back(i);
  EXPECT_EQ(percentile(values, 0), 0);
  EXPECT_EQ(percentile(values, 0.5), 50);
  EXPECT_EQ(percentile(values, 0.99), 99);
  EXPECT_EQ(percentile(values, 1), 100);
  EXPECT_TRUE(std::isnan(percentile({}, 0.5)));
}

TEST(TickTiming, VerdictsFollowTheirDefinition) {
  EXPECT_EQ(verdictOf(evenRun(1000, 799)), Verdict::kGood);
  EXPECT_EQ(verdictOf(evenRun(1000, 801)), Verdict::kMarginal);
  EXPECT_EQ(verdictOf(evenRun(2000, 399)), Verdict::kGood);
  EXPECT_EQ(verdictOf(evenRun(2000, 401)), Verdict::kMarginal);
  TickTiming t = evenRun(1000, 300, 2000);
  t.missed = 1;
  EXPECT_EQ(verdictOf(t), Verdict::kMarginal);
  t.stale = 2;
  EXPECT_EQ(verdictOf(t), Verdict::kNo);
  EXPECT_EQ(verdictOf(TickTiming{}), Verdict::kNo);
}

TEST(TickTiming, AdviceNamesWhatCanBeChanged) {
  TimingSetup setup;
  setup.realtime_priority = setup.memory_locked = true;
  EXPECT_TRUE(advice(setup, {evenRun(1000, 300)}).empty());
  setup.latency_timer_ms = 16;
  ASSERT_EQ(advice(setup, {evenRun(1000, 300)}).size(), 1u);
  EXPECT_NE(advice(setup, {evenRun(1000, 300)})[0].find("16 ms"), std::string::npos);
  setup = TimingSetup{};
  TickTiming late = evenRun(1000, 900);
  late.lateness_us.assign(1000, 5000);
  EXPECT_EQ(advice(setup, {late}).size(), 4u);  // priority, memory, isolation, kernel
  setup.realtime_priority = setup.memory_locked = setup.realtime_kernel = setup.isolated_cpus = true;
  EXPECT_EQ(advice(setup, {late}).size(), 1u);
}

}  // namespace tick_timing_test
}  // namespace haptic
