// Every answer belongs to its question: slow, bursting and faulty wires against shafts whose position tells the time.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "emulated_device.h"
#include "spidar_driver/transport/answer_ledger.h"
#include "spidar_driver/transport/reply_stream.h"

namespace haptic {
namespace belonging_test {

/// Shafts that turn at a constant speed: a count is an instant of the line's clock.
class TurningPlant : public MotorPlant {
 public:
  static constexpr double kSpeed = 20000;  ///< [counts/s], 0.45 m/s
  void advance(std::int64_t now_ns) override { now_ns_ = now_ns; }
  void drive(int channel, std::int16_t digit) override { digits[channel] = digit; }
  std::int32_t position(int) const override {
    return static_cast<std::int32_t>(std::llround(kSpeed * 1e-9 * static_cast<double>(now_ns_)));
  }
  static double instant(std::int64_t count) { return static_cast<double>(count) / kSpeed; }  ///< [s]
  std::array<std::int16_t, 64> digits{};

 private:
  std::int64_t now_ns_ = 0;
};

struct Device {
  explicit Device(const std::vector<std::string>& models, AdapterDelay adapter = {}, double rate = 1000)
      : def(plainDevice(models, models[0] == "B5M" ? 8 : 8)), bus(plant), line(bus) {
    int id = 1;
    for (const std::string& model : models) bus.addBoard(model, id++);
    bus.setAdapter(adapter);
    UartSettings settings;
    settings.rate_hz = rate;
    period_ns = static_cast<std::int64_t>(1e9 / rate);
    driver = std::make_unique<UartBoards>(def, settings, "memory", [this] { return std::make_unique<MemoryLink>(line); });
    start_ns = line.now_ns;
  }
  DeviceSample tick() {
    line.now_ns = std::max(line.now_ns, start_ns + ++ticks * period_ns);
    return driver->exchange({});
  }
  /// Stamp minus the instant that the oldest count tells [s]; the counter's own origin is that of the first sample.
  double stampError(const DeviceSample& s) {
    double worst = 0;
    for (int i = 0; i < 8; ++i) {
      const double told = TurningPlant::instant(s.counts[i]) + turns(s, i);
      const double error = 1e-9 * static_cast<double>(s.stamp_ns) - told;
      if (std::fabs(error) > std::fabs(worst)) worst = error;
    }
    return worst;
  }
  /// Whole turns of the 16-bit counter before the first sample, as a time [s].
  double turns(const DeviceSample& s, int i) {
    constexpr double kTurn = 65536 / TurningPlant::kSpeed;
    return kTurn * std::round((1e-9 * static_cast<double>(s.stamp_ns) - TurningPlant::instant(s.counts[i])) / kTurn);
  }
  TurningPlant plant;
  DeviceDef def;
  BoardBusEmulator bus;
  MemoryLine line;
  std::int64_t period_ns = 0, start_ns = 0, ticks = 0;
  std::unique_ptr<UartBoards> driver;
};

constexpr double kCount = 1.5 / TurningPlant::kSpeed;  // a count and a half: rounding of both [s]
// Boards of one cycle are latched up to a cycle apart, and the stamp is the oldest one's.
constexpr double kCycle = 0.4e-3;

TEST(Belonging, AConstantDelayIsMeasuredAndTheStampsStayTrue) {
  for (const auto& models : {std::vector<std::string>{"B5M"}, std::vector<std::string>{"B3M", "B3M"}})
    for (const double delay : {0.0, 0.2e-3, 0.7e-3, 1e-3, 1.5e-3, 2e-3, 3.3e-3, 5e-3, 9e-3}) {
      Device d(models, {static_cast<std::int64_t>(1e9 * delay), 0, 0});
      EXPECT_NEAR(1e-6 * d.driver->linkReport().delay_us, delay, 60e-6);
      int fresh = 0;
      for (int k = 0; k < 500; ++k) {
        const DeviceSample s = d.tick();
        if (k < 30 || s.status != LinkStatus::kOk) continue;
        ++fresh;
        ASSERT_LE(std::fabs(d.stampError(s)), kCount + kCycle) << delay << " tick " << k;
        ASSERT_NEAR(1e-6 * s.age_us, delay + 0.3e-3, 1.2e-3);  // a read waits for the next exchange at most
      }
      EXPECT_GE(fresh, 450) << delay;
      EXPECT_EQ(d.driver->linkReport().retaught, 0u);
      EXPECT_EQ(d.driver->linkReport().lost, 0u);
      EXPECT_NEAR(1e-6 * d.driver->linkReport().delay_us, delay, 60e-6);
    }
}

TEST(Belonging, ADriftingDelayIsFollowed) {
  Device d({"B5M"}, {1000000, 0, 0});
  d.bus.setAdapter({1000000, 1e-3, 0});  // a millisecond more per second, up to 5
  for (int k = 0; k < 4000; ++k) {
    const DeviceSample s = d.tick();
    if (s.status == LinkStatus::kOk) { ASSERT_LE(std::fabs(d.stampError(s)), kCount + kCycle) << k; }
  }
  EXPECT_NEAR(d.driver->linkReport().delay_us, 5000, 250);
  EXPECT_EQ(d.driver->linkReport().retaught, 0u);
}

TEST(Belonging, BurstsOfAnAdapterAreOldNotWrong) {
  for (const int burst_ms : {2, 4, 8, 16}) {
    Device d({"B3M", "B3M"}, {0, 0, burst_ms * 1000000ll});
    int fresh = 0;
    for (int k = 0; k < 600; ++k) {
      const DeviceSample s = d.tick();
      if (s.status != LinkStatus::kOk) continue;
      ++fresh;
      ASSERT_LE(d.stampError(s), kCount + kCycle) << burst_ms;  // never fresher than they are
      ASSERT_GE(d.stampError(s), -kCount - kCycle - 2e-3) << burst_ms;
    }
    EXPECT_GE(fresh, 500 / burst_ms);
  }
}

/// Lost and doubled answers, slow wire and quick: a stamp may be too old for as long as a mark takes, never too new by more
/// than a period.
TEST(Belonging, LostDoubledAndSwappedAnswersAreSettled) {
  std::mt19937 random(5);
  for (const double delay : {0.0, 1.7e-3, 4.2e-3}) {
    Device d({"B3M", "B3M"}, {static_cast<std::int64_t>(1e9 * delay), 0, 0});
    int settled = 0, late = 0;
    for (int k = 0; k < 3000; ++k) {
      const unsigned n = 1 + random() % 3;
      if (k % 50 == 20 && k % 150 == 20) d.bus.loseReplies(static_cast<int>(n));
      if (k % 50 == 20 && k % 150 == 70) d.bus.doubleReplies(static_cast<int>(n));
      if (k % 50 == 20 && k % 150 == 120) d.bus.swapReplies(static_cast<int>(n));
      const DeviceSample s = d.tick();
      if (k < 30 || s.status != LinkStatus::kOk) continue;
      const double error = d.stampError(s);
      ASSERT_LE(error, 2.2e-3) << delay << " tick " << k;
      ASSERT_GE(error, -5e-3) << delay << " tick " << k;
      if (k % 50 < 20) late += std::fabs(error) > kCount + kCycle;
      if (k % 50 < 20) ++settled;
    }
    EXPECT_LE(late, settled / 3) << delay;  // mostly in step again 30 ms later: marks are lost and doubled as well
    EXPECT_GT(d.driver->linkReport().lost, 0u);
    EXPECT_GT(d.driver->linkReport().doubled, 0u);
  }
}

TEST(Belonging, ADeafBoardIsNoticedZeroedAndTaughtAnew) {
  for (const int length : {255, 120, 62}) {
    const DeviceDef device = plainDevice({"B5M"}, 8);
    EmulatedDevice e({{"B5M", 1}}, device);
    DriveCommand pull;
    for (std::size_t i = 0; i < 8; ++i) pull.voltage[i] = 3 * device.strings[i].volt_per_newton;
    for (int k = 0; k < 20; ++k) e.tick(pull);
    e.bus.board(1)->spoilTable(1, BoardCommand::kCurrent, length);
    int good = 0, back = 0;
    for (int k = 1; k <= 600; ++k) {
      const DeviceSample s = e.tick(pull);
      good = s.status == LinkStatus::kOk && s.age_us < 1000 ? good + 1 : 0;
      if (good == 20 && !back) back = k;
    }
    EXPECT_GT(back, 0) << length;
    EXPECT_LE(back, 500) << length;  // half a second
    EXPECT_EQ(e.plant.digits[0], static_cast<int>(3 * 0.091 * 4096 / 3.3)) << length;
  }
}

/// It answers each question and obeys none: SET_CMDLEN every quarter of a second brings it back.
TEST(Belonging, ABoardThatCutsItsCurrentsShortIsTaughtAnew) {
  for (const int length : {1, 6, 12, 16}) {
    const DeviceDef device = plainDevice({"B3M", "B3M"}, 8);
    EmulatedDevice e({{"B3M", 1}, {"B3M", 2}}, device);
    DriveCommand weak, strong;
    for (std::size_t i = 0; i < 8; ++i) {
      weak.voltage[i] = device.strings[i].volt_per_newton;
      strong.voltage[i] = 3 * device.strings[i].volt_per_newton;
    }
    for (int k = 0; k < 400; ++k) e.tick(strong);
    e.bus.board(1)->spoilTable(1, BoardCommand::kCurrent, length);
    for (int k = 0; k < 500; ++k) e.tick(weak);
    for (int i = 0; i < 8; ++i) EXPECT_LT(std::abs(e.plant.digits[i]), 120) << length << " motor " << i;
  }
}

/// A restart takes long: what was fresh before it is not fresh after it.
TEST(Belonging, CountsFromBeforeARestartAreNotNew) {
  const DeviceDef device = plainDevice({"B5M"}, 8);
  EmulatedDevice e({{"B5M", 1}}, device);
  for (int k = 0; k < 200; ++k) e.tick();
  bool restarted = false;
  for (int k = 0; k < 600; ++k) {
    if (!restarted && k % 2) e.bus.loseReplies(1);
    const DeviceSample s = e.tick();
    restarted = restarted || s.status == LinkStatus::kSilent;
    if (s.status == LinkStatus::kOk) { ASSERT_LT(s.age_us, 20000u) << k; }
  }
  EXPECT_EQ(e.report().retaught, 1u);
}

/// A driver that was kept from its core has asked nothing meanwhile: no board was silent, none is taught anew.
TEST(Belonging, ALoopThatStoodStillBlamesNoBoard) {
  const DeviceDef device = plainDevice({"B3M", "B3M"}, 8);
  EmulatedDevice e({{"B3M", 1}, {"B3M", 2}}, device);
  DriveCommand pull;
  for (std::size_t i = 0; i < 8; ++i) pull.voltage[i] = 3 * device.strings[i].volt_per_newton;
  for (int k = 0; k < 200; ++k) ASSERT_EQ(e.tick(pull).status, LinkStatus::kOk);
  for (const int gap_ms : {13, 40}) {
    e.ticks += gap_ms;
    e.bus.delayReplies(2, 1200000);  // and the first answers come late
    for (int k = 0; k < 5; ++k) EXPECT_NE(e.tick(pull).status, LinkStatus::kSilent) << gap_ms << ' ' << k;
    for (int k = 0; k < 100; ++k) ASSERT_EQ(e.tick(pull).status, LinkStatus::kOk);
    EXPECT_EQ(e.report().retaught, 0u);
    EXPECT_NE(e.driver->trouble().find("stood still for " + std::to_string(gap_ms + 1)), std::string::npos) << e.driver->trouble();
    EXPECT_EQ(e.driver->trouble().find("board 1"), std::string::npos) << e.driver->trouble();
  }
  EXPECT_EQ(e.report().stalls, 2u);
}

TEST(Belonging, SpikesThatNoMotorCanMakeAreNoCounts) {
  const double count = 2.25e-5;
  const CountUnwrapper::Limits limits{20 / count, 1000 / count};
  for (const double jump_mm : {2.0, 3.0, 5.0, 20.0, -4.0}) {
    CountUnwrapper spike(limits), shift(limits);
    const auto jump = static_cast<int>(jump_mm * 1e-3 / count);
    for (int k = 0; k < 100; ++k) {
      const auto at = static_cast<std::int16_t>(10 * k);  // 0.2 m/s
      const std::int64_t now = k * 1000000ll;
      const auto hit = spike.accept(static_cast<std::int16_t>(k == 50 ? at + jump : at), now);
      EXPECT_EQ(hit, k == 50 ? CountUnwrapper::Result::kRefused : CountUnwrapper::Result::kAccepted) << jump_mm;
      const auto moved = shift.accept(static_cast<std::int16_t>(k >= 50 ? at + jump : at), now);
      if (k == 52 && std::fabs(jump_mm) > 2.8) { EXPECT_EQ(moved, CountUnwrapper::Result::kJumped) << jump_mm; }
    }
    EXPECT_EQ(spike.count(), 990);
  }
}

/// What a hand and a motor do: up to 3 m/s and 900 m/s², at every phase of the sampling.
TEST(Belonging, HardMotionIsBelieved) {
  const double count = 2.25e-5;
  std::mt19937 random(3);
  CountUnwrapper counter({20 / count, 1000 / count});
  double x = 0, v = 0, a = 0;
  for (int k = 0; k < 20000; ++k) {
    if (k % 7 == 0) a = 900 * (1e-6 * static_cast<double>(random() % 2000001) - 1);
    if (std::fabs(v + 1e-3 * a) > 3) a = -a;
    x += 1e-3 * v + 0.5e-6 * a;
    v += 1e-3 * a;
    const auto reading = static_cast<std::int64_t>(std::llround(x / count));
    ASSERT_EQ(counter.accept(static_cast<std::int16_t>(reading), k * 1000000ll), CountUnwrapper::Result::kAccepted) << k;
    ASSERT_EQ(counter.count(), reading);
  }
}


/// Boards are read one after the other, 0.2 ms apart; their counts belong to one instant all the same.
TEST(Belonging, CountsOfAllBoardsBelongToOneInstant) {
  Device d({"B3M", "B3M"});
  constexpr double kFifo = 6 * 5e-6;  // a board sees a header when its FIFO is three quarters full
  for (int k = 0; k < 500; ++k) {
    const DeviceSample s = d.tick();
    if (k > 3 && s.status == LinkStatus::kOk) { ASSERT_LE(std::fabs(d.stampError(s)), kCount + kFifo) << k; }
  }
}
}  // namespace belonging_test
}  // namespace haptic
