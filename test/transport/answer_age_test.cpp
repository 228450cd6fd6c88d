// Counts that come some cycles late, at full rate: the full answers contradict them. And grips that move hard, which nothing contradicts.
#include "spidar_driver/transport/answer_age.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "emulated_device.h"

namespace haptic {
namespace answer_age_test {

constexpr int kSeenWithin = 100;  // ticks of 1 ms, of figures.md

/// Shafts of strings of which each sees its share of a grip's motion.
class MovingPlant : public MotorPlant {
 public:
  void advance(std::int64_t now_ns) override { now_ns_ = now_ns; }
  void drive(int, std::int16_t) override {}
  std::int32_t position(int channel) const override {
    static const double share[] = {0.55, -0.61, 0.57, 0.59, -0.54, -0.60, -0.56, 0.58};
    const double t = 1e-9 * static_cast<double>(now_ns_);
    const double way = speed * t + swing * std::sin(2 * M_PI * hertz * t) + shake * std::sin(2 * M_PI * 23 * t);
    return static_cast<std::int32_t>(std::floor(share[channel % 8] * way / count + 0.37 * channel));
  }
  double speed = 0, swing = 0, hertz = 1, shake = 0;  ///< of the grip: [m/s], [m], [1/s], [m]
  double count = 2.25e-5;                             ///< [m]

 private:
  std::int64_t now_ns_ = 0;
};

struct Device {
  explicit Device(const std::vector<std::string>& models) : def(plainDevice(models, 8)), bus(plant), line(bus) {
    plant.count = models[0] == "B5M" ? 2.25e-5 : 3.485e-5;  // of the devices with these boards
    for (StringDef& s : def.strings) s.length_per_count = plant.count;
    int id = 1;
    for (const std::string& model : models) bus.addBoard(model, id++);
    driver = std::make_unique<UartBoards>(def, UartSettings{}, "memory", [this] { return std::make_unique<MemoryLink>(line); });
    start_ns = line.now_ns;
  }
  DeviceSample tick() {
    line.now_ns = std::max(line.now_ns, start_ns + ++ticks * 1000000);
    return driver->exchange({});
  }
  MovingPlant plant;
  DeviceDef def;
  BoardBusEmulator bus;
  MemoryLine line;
  std::int64_t start_ns = 0, ticks = 0;
  std::unique_ptr<UartBoards> driver;
};

const std::vector<std::string> kModels[] = {{"B5M"}, {"B3M", "B3M"}};

TEST(AnswerAge, RepliesOfCyclesAgoAreSeenWhileTheGripMoves) {
  for (const auto& models : kModels)
    for (const double speed : {0.02, 0.05, 0.3})
      for (const int cycles : {1, 2, 5, 20, 77, 200})
        for (int start = 600; start < 640; start += 9) {
          Device d(models);
          d.plant.speed = speed;
          for (int k = 0; k < start; ++k) ASSERT_EQ(d.tick().finding, WireFinding::kNone) << k << d.driver->trouble();
          d.bus.replayReplies(cycles);
          int seen = 0;
          for (int k = 1; k <= 1000 && !seen; ++k)
            if (d.tick().finding != WireFinding::kNone) seen = k;
          EXPECT_GT(seen, 0) << speed << ' ' << cycles;
          EXPECT_LE(seen, kSeenWithin) << models.size() << " boards, " << speed << " m/s, " << cycles << " cycles";
        }
}

/// Answers of many cycles ago jump back along the way that they came: they are known at once, before somebody takes them for a slip.
TEST(AnswerAge, RepliesThatGoBackAlongTheWayAreSeenAtOnce) {
  for (const auto& models : kModels)
    for (const int cycles : {8, 20, 77, 200}) {
      Device d(models);
      d.plant.speed = 0.3;
      for (int k = 0; k < 600; ++k) ASSERT_EQ(d.tick().finding, WireFinding::kNone) << k << d.driver->trouble();
      d.bus.replayReplies(cycles);
      int seen = 0;
      for (int k = 1; k <= 10 && !seen; ++k)
        if (d.tick().finding == WireFinding::kOldCounts) seen = k;
      EXPECT_GT(seen, 0) << models.size() << " boards, " << cycles << " cycles";
    }
}

TEST(AnswerAge, RepliesOfASwingingGripAreSeen) {
  for (const auto& models : kModels)
    for (const int cycles : {1, 3, 20, 200}) {
      Device d(models);
      d.plant.swing = 0.03, d.plant.hertz = 1.7;
      for (int k = 0; k < 1000; ++k) ASSERT_EQ(d.tick().finding, WireFinding::kNone) << k << d.driver->trouble();
      d.bus.replayReplies(cycles);
      int seen = 0;
      for (int k = 1; k <= 1000 && !seen; ++k)
        if (d.tick().finding != WireFinding::kNone) seen = k;
      EXPECT_GT(seen, 0) << cycles;
      EXPECT_LE(seen, kSeenWithin) << cycles;
      // Counts that jump back by more are those of a board that started anew, as far as can be told.
      if (cycles < 20) { EXPECT_NE(d.driver->trouble().find("cycles ago"), std::string::npos) << d.driver->trouble(); }
    }
}

/// A minute of each motion, with answers and ticks that come late: no board is accused.
TEST(AnswerAge, ASoundBoardIsNotAccused) {
  struct Motion {
    double speed, swing, hertz, shake;
  };
  for (const auto& models : kModels)
    for (const Motion& m : {Motion{0.02, 0, 1, 0}, Motion{0, 0.05, 3, 0}, Motion{0, 0.02, 0.5, 0.003}, Motion{0, 0, 1, 0}}) {
      Device d(models);
      d.plant.speed = m.speed, d.plant.swing = m.swing, d.plant.hertz = m.hertz, d.plant.shake = m.shake;
      std::mt19937 random(7);
      for (int k = 0; k < 60000; ++k) {
        if (random() % 50 == 0) d.bus.delayReplies(1, 1000 * static_cast<std::int64_t>(random() % 3000));
        if (random() % 100 == 0) d.line.now_ns += 1000 * static_cast<std::int64_t>(random() % 5000);
        if (random() % 300 == 0) d.bus.to_host.corrupt(1);
        const DeviceSample s = d.tick();
        ASSERT_NE(s.finding, WireFinding::kOldCounts) << k << ": " << d.driver->trouble();
      }
    }
}

/// Boards whose two answers are always latched a cycle apart are as they are.
TEST(AnswerAge, AUsualAgeIsNotHeldAgainstABoard) {
  AnswerAge age;
  age.begin(1e-3);
  std::int64_t now = 0;
  const auto tick = [&](int k, double late) {
    const auto at = [](double seconds) { return static_cast<std::int16_t>(std::floor(900 * std::sin(3 * seconds))); };
    const double t = 1e-9 * static_cast<double>(now);
    age.take(1, {at(t - late)}, now);
    if (k % 4 == 0) age.compare(1, {at(t + 0.3e-3)}, now + 300000);
    now += 1000000;
    return age.evidence().decided();
  };
  for (int k = 0; k < 20000; ++k) ASSERT_FALSE(tick(k, 1e-3)) << k;
  int seen = 0;
  for (int k = 1; k < 1000 && !seen; ++k)
    if (tick(k, 3e-3)) seen = k;
  EXPECT_GT(seen, 0);
}

}  // namespace answer_age_test
}  // namespace haptic
