// The port table under threads: leases, recall, withdrawal, work between ticks.
#include "haptic_core/loop/ports.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "../../scenes/touch.h"
#include "haptic_core/base/error.h"

namespace haptic {

/// A port whose payload only its runner may touch; not atomic, so that a data race is one for the sanitizer.
struct CounterPort : Port {
  long ticks = 0;
  bool alive = true;
};
template <>
struct PortTraits<CounterPort> {
  static constexpr PortKind kKind = PortKind::kDevice;
};

namespace {

using std::chrono::milliseconds;

/// Ticks the port as a real-time thread does, until it is recalled.
void runUntilRecalled(PortLease<CounterPort>& lease, std::atomic<bool>& started) {
  while (!lease.recalled()) {
    lease->between_ticks.serve();
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

TEST(Ports, WorkRunsHereWithoutARunner) {
  PortTable table;
  CounterPort port;
  PortOffer offer(table, "spidar", port, "driver");
  std::thread::id ran_on;
  EXPECT_TRUE(offer.runBetweenTicks([&] { ran_on = std::this_thread::get_id(); }));
  EXPECT_EQ(ran_on, std::this_thread::get_id());
}

TEST(Ports, WorkNeverOverlapsATick) {
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
  long done = 0;
  for (int i = 0; i < 200; ++i) {
    EXPECT_TRUE(offer.runBetweenTicks([&] {
      port.ticks += 1000000;  // a plain write: a race, or a lost addition, if a tick ran now
      ++done;
    }));
  }
  EXPECT_THROW(offer.runBetweenTicks([] { throw std::runtime_error("refused"); }), std::runtime_error);
  ASSERT_TRUE(offer.withdraw());
  runner.join();
  EXPECT_EQ(done, 200);
  EXPECT_GE(port.ticks, 200 * 1000000L);
}

TEST(Ports, WorkIsDroppedWhenTheRunnerHangs) {
  PortTable table;
  CounterPort port;
  PortOffer offer(table, "spidar", port, "driver");
  auto lease = table.claim<CounterPort>("spidar", ClaimRank::kBridge, "bridge");
  bool ran = false;
  EXPECT_FALSE(offer.runBetweenTicks([&] { ran = true; }, milliseconds(20)));
  lease->between_ticks.serve();
  EXPECT_FALSE(ran);
}

TEST(Ports, AWorldTakesCommandsItselfUntilALoopRunsIt) {
  World world(scenes::pointerOverWall(makeBox({0.02, 0.02, 0.02}), 0.02, 1e6, 1e-3));
  WorldPort port(world, "wall", {}, 4);
  const std::vector<double> start = world.save();
  for (int i = 0; i < 10; ++i) world.step();
  ASSERT_NE(world.save(), start);
  const std::vector<double> end = world.save();
  EXPECT_THROW(port.take({StepWorld{}}), SetupError) << "a world that runs is not stepped by hand";
  EXPECT_EQ(world.save(), end);
  port.take({PauseWorld{true}});
  port.take({RestoreWorld{start}});
  for (int i = 0; i < 10; ++i) port.take({StepWorld{}});
  EXPECT_EQ(world.save(), end) << "step by step the same";
  port.take({PauseWorld{false}});
  port.take({RestoreWorld{start}});
  EXPECT_EQ(world.save(), start);
  EXPECT_THROW(port.take({GrabLink{3, 0}}), SetupError);

  std::vector<std::size_t> told;
  port.sendCommandsTo([&](const LoopCommand& command) { told.push_back(command.kind.index()); });
  for (int i = 0; i < 10; ++i) world.step();
  port.take({RestoreWorld{start}});
  EXPECT_NE(world.save(), start) << "the loop did nothing, and nobody else may";
  port.take({PauseWorld{true}});
  EXPECT_EQ(told, (std::vector<std::size_t>{LoopCommand{RestoreWorld{}}.kind.index(), LoopCommand{PauseWorld{}}.kind.index()}));
  EXPECT_TRUE(port.paused());
  port.sendCommandsTo([](const LoopCommand&) { throw SetupError("a loop", "refuses", "ask later"); });
  EXPECT_THROW(port.take({PauseWorld{false}}), SetupError);
  EXPECT_TRUE(port.paused()) << "what was refused has not happened";
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

}  // namespace
}  // namespace haptic
