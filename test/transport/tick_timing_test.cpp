// The latency test's verdicts and advice on timings made by hand.
#include "spidar_driver/latency/tick_timing.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <cmath>
#include <string>

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

TEST(TickTiming, AdviceNamesAProcessorThatThereIs) {
  cpu_set_t mine, one;
  ASSERT_EQ(sched_getaffinity(0, sizeof mine, &mine), 0);
  int last = -1;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu)
    if (CPU_ISSET(cpu, &mine)) last = cpu;
  EXPECT_EQ(examineMachine("").last_cpu, last);
  int first = 0;
  while (!CPU_ISSET(first, &mine)) ++first;
  CPU_ZERO(&one);
  CPU_SET(first, &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  EXPECT_EQ(examineMachine("").last_cpu, first);
  ASSERT_EQ(sched_setaffinity(0, sizeof mine, &mine), 0);

  TickTiming late = evenRun(1000, 900);
  late.lateness_us.assign(1000, 5000);
  TimingSetup setup;
  setup.realtime_priority = setup.memory_locked = setup.realtime_kernel = true;
  for (const int cpu : {1, 5, 127}) {
    setup.last_cpu = cpu;
    EXPECT_NE(advice(setup, {late}).at(0).find("isolcpus=" + std::to_string(cpu) + " "), std::string::npos);
  }
  setup.last_cpu = 0;  // the kernel cannot run on none
  EXPECT_EQ(advice(setup, {late}).at(0).find("isolcpus"), std::string::npos);
}

}  // namespace tick_timing_test
}  // namespace haptic
