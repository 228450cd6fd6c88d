// A delay added to the loop: what the hand feels is late by whole ticks, the bound of walls falls with it, and a replay has it too.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "../../scenes/touch.h"
#include "haptic_core/analysis/hand_certificate.h"
#include "haptic_core/base/error.h"
#include "haptic_core/loop/command.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/loop/session.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/spidar/wall_bound.h"

namespace haptic {
namespace added_delay_test {

constexpr double kPeriod = 1e-3;   // [s]
constexpr double kSoft = 200;      // [N/m], of a wall that a hand bears with all delays here
constexpr double kFace = 0.02;     // [m]

WorldDef wall(double stiffness) {
  return scenes::pointerOverWall(makeBox({kFace, kFace, kFace}), kFace, stiffness / (kFace * kFace), kPeriod);
}

DeviceDef spidarDef() { return loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/spidar_g6x3r.yaml"); }

/// A jig leads the grip 10 mm down and 4 mm into the wall, as a half wave: its way depends on no force.
struct Bench {
  World world;
  DeviceDef def = spidarDef();
  DeviceTwin twin;
  Spidar device{def};
  HapticLoop loop{world};
  SessionStart start;
  std::vector<TickInput> ticks;
  std::vector<LoopEvent> events;
  std::vector<TickHash> hashes;
  std::vector<double> force, depth;  ///< of the hand along z [N], of the pointer in the wall [m]

  Bench(double stiffness, const AddedDelay& delay) : world(wall(stiffness)), twin(def, twinSettings()) {
    HandSettings settings;
    settings.workspace.X_WB.p = Vector3(0, 0, 0.02);
    settings.soft_start_s = 0;
    settings.delay = delay;
    loop.attach(device, 0, settings);
    start.step = kPeriod;
    start.world_state = world.save();
    start.world_tuning = world.tuning().numbers();
    start.hands.push_back({"spidar", def, 0, settings, device.save(), {}});
    device.calibrateAtHome();
    device.setForceEnabled(true);
  }
  static TwinSettings twinSettings() {
    TwinSettings settings;
    settings.period = kPeriod;
    return settings;
  }
  void run(int count) {
    for (int i = 0; i < count; ++i) {
      const double t = kPeriod * static_cast<double>(ticks.size());
      GripPose pose;
      pose.X_BG.p.z() = t < 1 ? -1e-5 * std::sin(60 * t) : -0.014 * std::pow(std::sin(M_PI * (t - 1)), 2);
      twin.place(pose);
      TickInput input;
      input.tick = ticks.size();
      input.hands = 1;
      input.sample[0] = twin.exchange(loop.drive(0));
      const DeviceRequests requests = device.takeRequests(input.sample[0]);
      if (requests.any()) {
        events.push_back({input.tick, {AskDevice{requests}}});
        loop.take(events.back().command);
      }
      loop.tick(input, kPeriod);
      ticks.push_back(input);
      hashes.emplace_back();
      hashTick(loop, hashes.back());
      const HandReport& hand = loop.report().hand[0];
      force.push_back(hand.F_asked_B.force.z());
      depth.push_back(std::max(0.0, 0.01 - hand.X_WP.p.z()));
    }
  }
};

/// Ticks by which `late` comes after `first`: the shift of least squares, over the second in which the wall is touched.
int lag(const std::vector<double>& first, const std::vector<double>& late) {
  int best = -1;
  double least = INFINITY;
  for (int n = 0; n < 120; ++n) {
    double sum = 0;
    for (std::size_t i = 1200; i < 1900; ++i) sum += std::pow(late[i + static_cast<std::size_t>(n)] - first[i], 2);
    if (sum < least) least = sum, best = n;
  }
  return best;
}

TEST(AddedDelay, TheForceIsLateByWholeTicksAndOtherwiseTheSame) {
  Bench none(kSoft, {});
  none.run(2100);
  ASSERT_GT(*std::max_element(none.force.begin(), none.force.end()), 0.7) << "4 mm of 200 N/m";
  for (const AddedDelay delay : {AddedDelay{0.02, 0}, AddedDelay{0, 0.02}, AddedDelay{0.007, 0.0134}}) {
    Bench late(kSoft, delay);
    late.run(2100);
    const int ticks = static_cast<int>(std::lround(delay.pose / kPeriod) + std::lround(delay.force / kPeriod));
    EXPECT_EQ(lag(none.force, late.force), ticks) << delay.pose << " " << delay.force;
    // The same numbers, later: the jig's way is the same, and the force is no function of when it comes.
    for (std::size_t i = 1200; i < 1900; ++i) {
      ASSERT_EQ(late.force[i + static_cast<std::size_t>(ticks)], none.force[i]) << i;
    }
    EXPECT_EQ(lag(none.depth, late.depth), static_cast<int>(std::lround(delay.pose / kPeriod))) << "the pointer is late by the pose's part";
  }
}

TEST(AddedDelay, AWallIsNoStifferThanTheBoundOfTheWholeDelay) {
  const double B = spidarDef().grip_damping + kRelaxedHandDamping;
  for (const AddedDelay delay : {AddedDelay{}, AddedDelay{0.01, 0}, AddedDelay{0.005, 0.005}, AddedDelay{0, 0.05}}) {
    Bench bench(2e4, delay);
    bench.run(1500);
    const double wire = std::max(bench.device.freshness().delay(), bench.def.delay_s);
    const double bound = largestWallStiffness(B, 0, kPeriod, loopDelay(kPeriod, wire) + delay.total());
    const HandReport& hand = bench.loop.report().hand[0];
    EXPECT_NEAR(bench.loop.hand(0).stableStiffness(), bound, 1e-9 * bound) << "one formula in two ways";
    EXPECT_NEAR(hand.stiffness * hand.stiffness_share, bound, 1e-6 * bound);
    // The certificate's is that of the wire as the device's file has it.
    const HandCertificate c = certifyHand(wall(2e4), 0, {1, 1, delay.total()}, bench.def);
    EXPECT_NEAR(c.held, largestWallStiffness(B, 0, kPeriod, loopDelay(kPeriod, bench.def.delay_s) + delay.total()), 1e-9 * c.held);
    EXPECT_EQ(c.text().find("added delay") != std::string::npos, delay.total() > 0);
  }
}

TEST(AddedDelay, AReplayHasTheSameBitsAlsoFromTheMiddle) {
  Bench bench(kSoft, {0.03, 0.011});
  bench.run(1400);  // the lines hold a touch
  LoopMemory memory = roomFor(bench.start, 0);
  const std::size_t room = memory.hand[0].loop.capacity();
  remember(bench.loop, bench.ticks.size(), memory);
  EXPECT_EQ(memory.hand[0].loop.capacity(), room) << "nothing is allocated while ticking";
  const SessionStart middle = startedAt(bench.start, memory, {0});
  bench.run(700);
  const auto replayed = [&](const SessionStart& start) {
    SessionReplay replay(wall(kSoft), start);
    std::size_t event = 0;
    while (event < bench.events.size() && bench.events[event].tick < start.first_tick) ++event;
    for (std::size_t i = start.first_tick; i < bench.ticks.size(); ++i) {
      for (; event < bench.events.size() && bench.events[event].tick == i; ++event) replay.apply(bench.events[event].command);
      ASSERT_TRUE(replay.tick(bench.ticks[i]) == bench.hashes[i]) << i;
    }
  };
  replayed(bench.start);
  replayed(middle);
}

TEST(AddedDelay, IsSetOnceWithinBounds) {
  Bench bench(kSoft, {0.01, 0});
  HandSettings settings = bench.loop.hand(0).settings();
  settings.delay.pose = 0.02;
  EXPECT_THROW(bench.loop.take({ChangeHand{settings}}), SetupError);
  World world(wall(kSoft));
  HapticLoop loop(world);
  for (const double wrong : {-1e-3, 0.21, std::nan("")}) {
    settings.delay = {wrong, 0};
    EXPECT_THROW(loop.attach(bench.device, 0, settings), SetupError) << wrong;
  }
  std::vector<double> numbers = numbersOf(HandSettings{});
  EXPECT_EQ(handSettingsFrom(numbers).delay.total(), 0);
  numbers.pop_back();
  EXPECT_THROW(handSettingsFrom(numbers), SetupError);
}

}  // namespace added_delay_test
}  // namespace haptic
