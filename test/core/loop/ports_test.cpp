// The port table under threads: leases, recall, withdrawal, commands between ticks.
#include "haptic_core/loop/ports.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include "../../scenes/touch.h"
#include "haptic_core/base/error.h"
#include "haptic_core/spidar/device_twin.h"

namespace haptic {

/// A port whose payload only its runner may touch; not atomic, so that a data race is one for the sanitizer.
struct CounterPort : Port {
  /// Adds to the ticks, in a plain write: a race, or a lost addition, if a tick ran meanwhile.
  struct Add {
    long ticks = 0;
    std::thread::id* ran_on = nullptr;
  };
  using Command = Add;
  void serve() noexcept override {
    commands.drain([this](const Add& add) {
      if (add.ticks < 0) throw SetupError("a counter", "counts no " + std::to_string(add.ticks), "give more");
      ticks += add.ticks;
      if (add.ran_on) *add.ran_on = std::this_thread::get_id();
    });
  }
  CommandRing<Command> commands;
  long ticks = 0;
  bool alive = true;
};
template <>
struct PortTraits<CounterPort> {
  static constexpr PortKind kKind = PortKind::kDevice;
};

namespace ports_test {

using std::chrono::milliseconds;

/// Ticks the port as a real-time thread does, until it is recalled.
void runUntilRecalled(PortLease<CounterPort>& lease, std::atomic<bool>& started) {
  while (!lease.recalled()) {
    lease->serve();
    ASSERT_TRUE(lease->alive);
    ++lease->ticks;
    started = true;
    std::this_thread::yield();
  }
}

TEST(Ports, ClaimOfUnknownNameSaysSo) {
  PortTable table;
  std::string reason;
  EXPECT_FALSE(table.claim<CounterPort>("spidar", ClaimRank::kBridge, "bridge", &reason));
  EXPECT_EQ(reason, "the device port spidar is not offered in this process");
}

TEST(Ports, SecondOwnerOfANameIsRefused) {
  PortTable table;
  CounterPort a, b;
  PortOffer first(table, "spidar", a, "/left/driver");
  EXPECT_THROW(PortOffer(table, "spidar", b, "/other/driver"), SetupError);
  ASSERT_TRUE(first.withdraw());
  EXPECT_NO_THROW(PortOffer(table, "spidar", b, "/other/driver"));
  EXPECT_TRUE(table.names(PortKind::kDevice).empty());  // the temporary above has withdrawn
}

TEST(Ports, OnlyOneRunnerOfARank) {
  PortTable table;
  CounterPort port;
  PortOffer offer(table, "spidar", port, "driver");
  auto first = table.claim<CounterPort>("spidar", ClaimRank::kBridge, "bridge a");
  ASSERT_TRUE(first);
  EXPECT_EQ(offer.holder(), "bridge a");
  EXPECT_TRUE(offer.heldBy(ClaimRank::kBridge));
  std::string reason;
  EXPECT_FALSE(table.claim<CounterPort>("spidar", ClaimRank::kBridge, "bridge b", &reason));
  EXPECT_EQ(reason, "the device port spidar is held by bridge a");
  first.release();
  EXPECT_TRUE(table.claim<CounterPort>("spidar", ClaimRank::kBridge, "bridge b"));
}

TEST(Ports, BridgeTakesTheDeviceFromItsOwnersThread) {
  PortTable table;
  CounterPort port;
  PortOffer offer(table, "spidar", port, "driver");
  std::atomic<bool> started{false}, ended{false};
  std::thread own_thread([&] {
    auto lease = table.claim<CounterPort>("spidar", ClaimRank::kOwner, "driver");
    ASSERT_TRUE(lease);
    runUntilRecalled(lease, started);
    ended = true;
  });
  while (!started) std::this_thread::yield();
  auto lease = table.claim<CounterPort>("spidar", ClaimRank::kBridge, "bridge");
  ASSERT_TRUE(lease);
  EXPECT_TRUE(ended);
  EXPECT_FALSE(lease.recalled());
  ++lease->ticks;
  EXPECT_FALSE(table.claim<CounterPort>("spidar", ClaimRank::kOwner, "driver"));
  own_thread.join();
}

TEST(Ports, WithdrawalWaitsForTheRunner) {
  PortTable table;
  auto port = std::make_unique<CounterPort>();
  auto offer = std::make_unique<PortOffer>(table, "spidar", *port, "driver");
  std::atomic<bool> started{false};
  std::thread runner([&] {
    auto lease = table.claim<CounterPort>("spidar", ClaimRank::kBridge, "bridge");
    ASSERT_TRUE(lease);
    runUntilRecalled(lease, started);
  });
  while (!started) std::this_thread::yield();
  ASSERT_TRUE(offer->withdraw());
  port->alive = false;  // without the wait the runner would see this, and the sanitizer a race
  port.reset();
  runner.join();
  EXPECT_FALSE(table.claim<CounterPort>("spidar", ClaimRank::kBridge, "bridge"));
}

TEST(Ports, WithdrawalIsBoundedWhenTheRunnerHangs) {
  PortTable table;
  CounterPort port;
  PortOffer offer(table, "spidar", port, "driver");
  auto lease = table.claim<CounterPort>("spidar", ClaimRank::kBridge, "bridge");
  EXPECT_FALSE(offer.withdraw(milliseconds(20)));
  EXPECT_TRUE(lease.recalled());
  EXPECT_FALSE(table.claim<CounterPort>("spidar", ClaimRank::kBridge, "another"));
}

TEST(Ports, ClaimGivesUpOnARunnerThatHangs) {
  PortTable table;
  CounterPort port;
  PortOffer offer(table, "spidar", port, "driver");
  auto own = table.claim<CounterPort>("spidar", ClaimRank::kOwner, "driver");
  std::string reason;
  EXPECT_FALSE(table.claim<CounterPort>("spidar", ClaimRank::kBridge, "bridge", &reason, milliseconds(20)));
  EXPECT_EQ(reason, "the device port spidar was not released by driver in time");
  EXPECT_FALSE(own.recalled());  // nobody waits any more
}

TEST(Ports, CommandsAreCarriedOutHereWithoutARunner) {
  PortTable table;
  CounterPort port;
  PortOffer offer(table, "spidar", port, "driver");
  std::thread::id ran_on;
  EXPECT_TRUE(offer.send(port, {1, &ran_on}));
  EXPECT_EQ(ran_on, std::this_thread::get_id());
}

TEST(Ports, CommandsNeverOverlapATick) {
  PortTable table;
  CounterPort port;
  PortOffer offer(table, "spidar", port, "driver");
  std::atomic<bool> started{false};
  std::thread runner([&] {
    auto lease = table.claim<CounterPort>("spidar", ClaimRank::kBridge, "bridge");
    ASSERT_TRUE(lease);
    runUntilRecalled(lease, started);
  });
  while (!started) std::this_thread::yield();
  std::thread::id ran_on;
  for (int i = 0; i < 200; ++i) EXPECT_TRUE(offer.send(port, {1000000, &ran_on}));
  EXPECT_EQ(ran_on, runner.get_id());
  EXPECT_THROW(offer.send(port, {-1}), SetupError);
  ASSERT_TRUE(offer.withdraw());
  EXPECT_FALSE(offer.send(port, {1000000}));
  runner.join();
  EXPECT_GE(port.ticks, 200 * 1000000L);
}

TEST(Ports, CommandsAreWithdrawnWhenTheRunnerHangs) {
  PortTable table;
  CounterPort port;
  PortOffer offer(table, "spidar", port, "driver");
  auto lease = table.claim<CounterPort>("spidar", ClaimRank::kBridge, "bridge");
  EXPECT_FALSE(offer.send(port, {1}, milliseconds(20)));
  lease->serve();
  EXPECT_EQ(port.ticks, 0) << "what was answered with no must not happen later";
}

/// The world's port with an offer, and a runner's lease on demand.
struct OfferedWorld {
  World world{scenes::pointerOverWall(makeBox({0.02, 0.02, 0.02}), 0.02, 1e6, 1e-3)};
  WorldPort port{world, "wall", {}, 4};
  PortTable table;
  PortOffer offer{table, "world", port, "simulation"};

  bool tell(const LoopCommand& command) { return offer.send(port, WorldPort::Change{{&command}}); }
};

TEST(Ports, AWorldThatNobodyRunsTakesCommandsItself) {
  OfferedWorld w;
  World& world = w.world;
  const std::vector<double> start = world.save();
  for (int i = 0; i < 10; ++i) world.step();
  ASSERT_NE(world.save(), start);
  const std::vector<double> end = world.save();
  EXPECT_THROW(w.tell({StepWorld{}}), SetupError) << "a world that runs is not stepped by hand";
  EXPECT_EQ(world.save(), end);
  std::uint64_t hash = 0;
  const std::vector<LoopCommand> steps(10, LoopCommand{StepWorld{}});
  EXPECT_TRUE(w.tell({PauseWorld{true}}));
  EXPECT_TRUE(w.tell({RestoreWorld{start}}));
  EXPECT_TRUE(w.offer.send(w.port, WorldPort::Change{{steps.data(), steps.size()}, &hash}));
  EXPECT_EQ(world.save(), end) << "step by step the same";
  EXPECT_EQ(hash, world.hash());
  EXPECT_TRUE(w.tell({PauseWorld{false}}));
  EXPECT_TRUE(w.tell({RestoreWorld{start}}));
  EXPECT_EQ(world.save(), start);
  EXPECT_THROW(w.tell({GrabLink{3, 0}}), SetupError);
}

TEST(Ports, AWorldThatIsRunLeavesCommandsToItsRunner) {
  OfferedWorld w;
  auto lease = w.table.claim<WorldPort>("world", ClaimRank::kBridge, "bridge");
  ASSERT_TRUE(lease);
  const std::vector<double> start = w.world.save();
  for (int i = 0; i < 10; ++i) w.world.step();
  const auto told = [&](const LoopCommand& command, auto&& take) {
    std::atomic<bool> ended{false};
    std::thread runner([&] {
      while (!ended) lease->serve(take);
    });
    bool refused = false;
    try {
      EXPECT_TRUE(w.tell(command));
    } catch (const SetupError&) {
      refused = true;
    }
    ended = true;
    runner.join();
    return !refused;
  };
  std::vector<std::size_t> seen;
  const auto keep = [&](const LoopCommand& command) { seen.push_back(command.kind.index()); };
  EXPECT_TRUE(told({RestoreWorld{start}}, keep));
  EXPECT_NE(w.world.save(), start) << "the runner did nothing, and nobody else may";
  EXPECT_TRUE(told({PauseWorld{true}}, keep));
  EXPECT_EQ(seen, (std::vector<std::size_t>{LoopCommand{RestoreWorld{}}.kind.index(), LoopCommand{PauseWorld{}}.kind.index()}));
  EXPECT_TRUE(lease->paused());
  EXPECT_FALSE(told({PauseWorld{false}}, [](const LoopCommand&) { throw SetupError("a loop", "refuses", "ask later"); }));
  EXPECT_TRUE(lease->paused()) << "what was refused has not happened";
}

TEST(Ports, AWorldIsCopiedWithTheStampOfItsLastTick) {
  OfferedWorld w;
  WorldSnapshot snapshot = w.port.first_snapshot;
  WorldCopy copy = w.port.first_copy;
  EXPECT_TRUE(w.offer.send(w.port, WorldPort::Copy{&copy}));
  EXPECT_EQ(copy.stamp_ns, 0) << "no tick yet";
  EXPECT_TRUE(std::isnan(copy.stages.total())) << "nobody asked for times";
  EXPECT_TRUE(w.offer.send(w.port, WorldPort::TimeStages{true}));
  for (int i = 1; i <= 10; ++i) {
    w.world.step();
    w.port.noteTick(i);
  }
  EXPECT_TRUE(w.offer.send(w.port, WorldPort::Copy{&copy}));
  EXPECT_TRUE(w.offer.send(w.port, WorldPort::Look{&snapshot}));
  EXPECT_EQ(copy.stamp_ns, 10);
  EXPECT_EQ(snapshot.stamp_ns, 10);
  EXPECT_EQ(copy.state, w.world.save());
  EXPECT_EQ(copy.hash, w.world.hash());
  EXPECT_GT(copy.stages.total(), 0);
  EXPECT_EQ(snapshot.pose[1].p, w.world.linkPose(1).p);
}

/// Bodies come and go through the port: copies of before are left alone, what judges and what records follows, a hand keeps what it holds.
TEST(Ports, BodiesComeAndGoWithTheRoomOfThePort) {
  OfferedWorld w;
  const WorldDef def = scenes::pointerOverWall(makeBox({0.02, 0.02, 0.02}), 0.02, 1e6, 1e-3);
  WorldDef more = def;
  more.articulations.push_back(scenes::springyBody("late", makeBox({0.1, 0.1, 0.1}), JointType::kFloating, {0.3, 0, 0.2}, 1e6));
  SensorDef sensor;
  sensor.kind = SensorDef::Kind::kImu, sensor.name = "felt", sensor.articulation = 2, sensor.link = 0;
  more.sensors.push_back(sensor);
  WorldSnapshot before = w.port.first_snapshot;
  WorldCopy copy_before = w.port.first_copy;
  const auto exchange = [&](const WorldDef& next, const std::vector<int>& kept) {
    ChangeBodies change;
    *change.packed = packBodies(next, kept);
    change.next = std::make_shared<NextWorld>(w.world, next, kept);
    const std::size_t numbers = change.next->stateCapacity();
    const LoopCommand command{change};
    EXPECT_THROW(w.tell(command), SetupError) << "without the room";
    WorldRoom room{std::make_shared<const WorldDef>(next), change.packed, std::vector<std::uint64_t>(next.sensors.size(), 0)};
    const auto packed = room.bodies;
    EXPECT_TRUE(w.offer.send(w.port, WorldPort::Exchange{&command, &room}));
    EXPECT_EQ(w.port.bodies(), packed);
    w.port.resize(8, numbers);
  };
  w.port.noteTick(1);
  EXPECT_TRUE(w.offer.send(w.port, WorldPort::StreamSensors{true}));
  exchange(more, {0, 1, -1});
  ASSERT_EQ(w.world.linkCount(), 3);
  EXPECT_EQ(w.port.bodiesChanged(), 1);
  EXPECT_EQ(w.port.definition()->articulations.size(), 3u);
  EXPECT_TRUE(w.offer.send(w.port, WorldPort::Look{&before}));
  EXPECT_TRUE(w.offer.send(w.port, WorldPort::Copy{&copy_before}));
  EXPECT_EQ(before.stamp_ns, 0) << "it has no room for the new bodies";
  EXPECT_EQ(copy_before.stamp_ns, 0);
  WorldSnapshot now = w.port.first_snapshot;
  WorldCopy copy = w.port.first_copy;
  SensorSample sample;
  w.world.step();
  w.port.noteTick(1);
  EXPECT_FALSE(w.port.samples.pop(sample)) << "whoever listens asks anew, by the new indices";
  EXPECT_TRUE(w.offer.send(w.port, WorldPort::StreamSensors{true}));
  w.world.step();
  w.port.noteTick(2);
  EXPECT_TRUE(w.offer.send(w.port, WorldPort::Look{&now}));
  EXPECT_TRUE(w.offer.send(w.port, WorldPort::Copy{&copy}));
  EXPECT_EQ(now.stamp_ns, 2);
  ASSERT_EQ(now.pose.size(), 3u);
  EXPECT_EQ(now.pose[2].p, w.world.linkPose(2).p);
  EXPECT_EQ(copy.state, w.world.save());
  EXPECT_TRUE(w.port.samples.pop(sample)) << "the sensor that came";
  EXPECT_TRUE(w.tell({GrabLink{0, 2}}));
  w.world.step();
  const std::uint64_t hash = w.world.hash();
  EXPECT_THROW(exchange(def, {0, 1}), SetupError) << "the hand holds what is to go";
  EXPECT_EQ(w.world.hash(), hash);
  EXPECT_EQ(w.port.bodiesChanged(), 1);
  WorldDef led = more;
  MotionDef motion;
  motion.name = "late", motion.articulation = 2, motion.link = 0;
  led.motions.push_back(motion);
  EXPECT_THROW(exchange(led, {0, 1, 2}), SetupError) << "the hand holds what a motion is to lead";
  EXPECT_TRUE(w.tell({GrabLink{0, 1}}));
  exchange(def, {0, 1});
  EXPECT_EQ(w.world.linkCount(), 2);
  EXPECT_TRUE(w.offer.send(w.port, WorldPort::Look{&now}));
  EXPECT_EQ(now.stamp_ns, 2) << "what went is not looked at";
}

TEST(Ports, GravityAloneIsSet) {
  OfferedWorld w;
  WorldTuning tuning = w.world.tuning();
  tuning.gravity = Vector3(0, 1, -3);
  EXPECT_TRUE(w.tell({SetGravity{tuning.gravity}}));
  EXPECT_EQ(w.world.tuning().numbers(), tuning.numbers());
  EXPECT_THROW(w.tell({SetGravity{Vector3(0, 0, 1e9)}}), SetupError);
  const LoopCommand command{SetGravity{tuning.gravity}};
  EXPECT_EQ(std::get<SetGravity>(commandFrom(command.kind.index(), 0, numbersOf(command)).kind).gravity, tuning.gravity);
}

/// A device on a twin, on offer.
struct OfferedDevice {
  Spidar spidar{loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/spidar_g6x3r.yaml")};
  DeviceTwin twin{spidar.def(), TwinSettings{}};
  DevicePort port{spidar, twin, 16};
  PortTable table;
  PortOffer offer{table, "spidar", port, "driver"};
  DeviceCopy copy;
  std::vector<LoopCommand> taken;   ///< by the runner

  /// Has a command answered by a runner whose exchanges end like this: by the first tick that drains it.
  bool told(const DeviceRequests& requests, LinkStatus status) {
    const LoopCommand command{AskDevice{requests}};
    auto lease = table.claim<DevicePort>("spidar", ClaimRank::kBridge, "bridge");
    std::atomic<bool> ended{false};
    std::thread runner([&] {
      while (!ended) tick(*lease, status);
    });
    bool refused = false;
    try {
      EXPECT_TRUE(offer.send(port, Tell{&command}));
      EXPECT_TRUE(offer.send(port, DevicePort::Copy{&copy}));
    } catch (const SetupError&) {
      refused = true;
    }
    ended = true;
    runner.join();
    return !refused;
  }
  void tick(DevicePort& held, LinkStatus status) {
    DeviceSample sample = held.transport.exchange(held.device.drive());
    sample.status = status;
    held.serve(sample, [&](const LoopCommand& command) {
      taken.push_back(command);
      apply(command, held.device);
    });
    held.device.sense(sample, 1e-3);
    held.device.actuate(Wrench{}, 0, 1e-3);
  }
};

TEST(Ports, WhatIsAskedOfADeviceIsDoneInTheTickThatTakesIt) {
  OfferedDevice d;
  DeviceRequests calibrate;
  calibrate.calibrate = true;
  EXPECT_FALSE(d.told(calibrate, LinkStatus::kStale)) << "without fresh counts there is nothing to calibrate with";
  EXPECT_FALSE(d.spidar.calibrated());
  d.tick(d.port, LinkStatus::kOk);
  EXPECT_FALSE(d.spidar.calibrated()) << "what was refused must not happen later";
  EXPECT_TRUE(d.told(calibrate, LinkStatus::kOk));
  EXPECT_TRUE(d.copy.record.calibrated) << "the copy is of after the tick that took the command";
  EXPECT_EQ(d.copy.calibration.zero_length, d.spidar.zeroLengths());
  EXPECT_EQ(d.taken.size(), 1u);
}

TEST(Ports, WhatWasAskedAtSetUpIsToldToTheFirstTickThatCan) {
  OfferedDevice d;
  d.spidar.calibrateAtHome();
  d.spidar.setForceEnabled(true);
  DeviceRequests off;
  off.enable = 0;
  const LoopCommand command{AskDevice{off}};
  EXPECT_THROW(d.offer.send(d.port, Tell{&command}), SetupError) << "nobody runs the device";
  d.tick(d.port, LinkStatus::kStale);
  ASSERT_EQ(d.taken.size(), 1u);
  EXPECT_EQ(std::get<AskDevice>(d.taken[0].kind).requests.enable, 1);
  EXPECT_FALSE(std::get<AskDevice>(d.taken[0].kind).requests.calibrate);
  d.tick(d.port, LinkStatus::kOk);
  ASSERT_EQ(d.taken.size(), 2u);
  EXPECT_TRUE(std::get<AskDevice>(d.taken[1].kind).requests.calibrate);
  EXPECT_TRUE(d.spidar.calibrated());
}

TEST(Ports, ADeadManSwitchIsToldOfWhenItChanges) {
  OfferedDevice d;
  d.port.dead_man.used = true;
  const auto told = [&] {
    d.taken.clear();
    d.tick(d.port, LinkStatus::kOk);
    return d.taken.empty() ? -1 : static_cast<int>(std::get<HoldSwitch>(d.taken.at(0).kind).held);
  };
  EXPECT_EQ(told(), 0) << "never held is not held";
  EXPECT_EQ(told(), -1);
  d.port.dead_man.held_until_ns = steadyNow() + 3600000000000;
  EXPECT_EQ(told(), 1);
  EXPECT_EQ(told(), -1);
  d.port.dead_man.held_until_ns = steadyNow() - 1;
  EXPECT_EQ(told(), 0) << "an old word is none";
  d.port.dead_man.button = 3;
  DeviceSample sample;
  sample.buttons = 1u << 3;
  EXPECT_TRUE(d.port.dead_man.held(sample));
  sample.buttons = ~(1u << 3);
  EXPECT_FALSE(d.port.dead_man.held(sample));
}

TEST(Ports, StopReachesADeviceThatNobodyRuns) {
  OfferedDevice d;
  const LoopCommand stop{StopDevice{}};
  EXPECT_TRUE(d.offer.send(d.port, Tell{&stop}));
  d.tick(d.port, LinkStatus::kOk);
  EXPECT_TRUE(d.spidar.stopped());
  EXPECT_EQ(d.spidar.drive().voltage[0], 0);
  DeviceRequests calibrate;
  calibrate.calibrate = true;
  EXPECT_FALSE(d.told(calibrate, LinkStatus::kOk)) << "slack strings are no lengths";
  DeviceRequests recover;
  recover.recover = true;
  EXPECT_TRUE(d.told(recover, LinkStatus::kOk));
  EXPECT_TRUE(d.told(calibrate, LinkStatus::kOk));
}

TEST(Ports, ManyRoundsOfOfferClaimWithdraw) {
  PortTable table;
  std::atomic<bool> stop{false};
  std::atomic<long> leases{0};
  std::thread bridge([&] {
    while (!stop) {
      auto lease = table.claim<CounterPort>("spidar", ClaimRank::kBridge, "bridge");
      if (!lease) continue;
      ++leases;
      while (!lease.recalled() && !stop) ++lease->ticks;
    }
  });
  for (int i = 0; i < 300; ++i) {
    CounterPort port;
    const long before = leases;
    PortOffer offer(table, "spidar", port, "driver");
    while (leases == before) std::this_thread::yield();
    ASSERT_TRUE(offer.withdraw());
    ++port.ticks;  // ours again
  }
  stop = true;
  bridge.join();
  EXPECT_GE(leases, 300);
}

}  // namespace ports_test
}  // namespace haptic
