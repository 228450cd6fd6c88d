// 10⁵ ticks allocate nothing: malloc and its kin are counted for the whole process, libraries included.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <memory>

#include "haptic_core/loop/hand.h"
#include "haptic_core/loop/haptic_loop.h"
#include "haptic_core/loop/ports.h"
#include "haptic_core/loop/session.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/world/step_history.h"
#include "scene/scene_file.h"

namespace {

std::atomic<long> allocations{0};
std::atomic<bool> counting{false};

void count() {
  if (counting.load(std::memory_order_relaxed)) allocations.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace

// The executable's definitions stand before the C library's for every shared library that it loads.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* block);

void* malloc(std::size_t size) {
  count();
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) {
  count();
  return __libc_calloc(n, size);
}
void* realloc(void* block, std::size_t size) {
  count();
  return __libc_realloc(block, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  count();
  *block = __libc_memalign(alignment, size);
  return *block ? 0 : 12;
}
void free(void* block) {
  count();
  __libc_free(block);
}
}

namespace haptic {
namespace {

/// With every sensor that the links can have, and noise on each.
WorldDef measured(WorldDef def) {
  for (std::size_t a = 0; a < def.articulations.size(); ++a) {
    for (std::size_t l = 0; l < def.articulations[a].links.size(); ++l) {
      for (const auto kind : {SensorDef::Kind::kWrench, SensorDef::Kind::kContact, SensorDef::Kind::kImu}) {
        const bool floats = def.articulations[a].links[l].joint.type == JointType::kFloating;
        if (kind == SensorDef::Kind::kWrench && (floats || !def.loops.empty())) continue;
        SensorDef sensor;
        sensor.kind = kind;
        sensor.name = std::to_string(def.sensors.size());
        sensor.articulation = static_cast<int>(a), sensor.link = static_cast<int>(l);
        sensor.noise_force = sensor.noise_torque = sensor.noise_rate = sensor.noise_specific_force = sensor.noise_orientation = 0.01;
        def.sensors.push_back(sensor);
      }
    }
  }
  return def;
}

/// A twin whose hand follows the scene's script, on the scene's pointer.
struct Stack {
  explicit Stack(const std::string& scene_name)
      : scene(loadScene(std::string(HAPTIC_SOURCE_DIR) + "/urdf/scenes/" + scene_name + ".urdf")),
        world(measured(scene.world)),
        loop(world),
        device(loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/spidar_g6x3r.yaml")) {
    TwinSettings settings;
    settings.period = scene.world.settings.step;
    settings.path = scene.hands.at(0).path;
    twin = std::make_unique<DeviceTwin>(device.def(), settings);
    HandSettings hand;
    hand.workspace = scene.hands[0].workspace;
    loop.attach(device, scene.hands[0].pointer, hand);
    device.calibrateAtHome();
    device.setForceEnabled(true);
  }

  void tick() {
    const DeviceSample sample = twin->exchange(device.drive());
    loop.tick(&sample, scene.world.settings.step);
  }

  SceneDef scene;
  World world;
  HapticLoop loop;
  Spidar device;
  std::unique_ptr<DeviceTwin> twin;
};

TEST(Allocation, TheCounterSeesAllocations) {
  allocations = 0;
  counting = true;
  auto* number = new double(1);
  const Eigen::MatrixXd matrix = Eigen::MatrixXd::Constant(40, 40, *number);
  delete number;
  counting = false;
  EXPECT_EQ(matrix(3, 3), 1.0);
  EXPECT_GE(allocations, 3) << "new, Eigen's buffer, delete";
}

class SceneAllocation : public testing::TestWithParam<const char*> {};

TEST_P(SceneAllocation, TicksAllocateNothing) {
  constexpr int kTicks = 100000;
  Stack stack(GetParam());
  double greatest_force = 0;
  allocations = 0;
  counting = true;
  for (int i = 0; i < kTicks; ++i) {
    stack.tick();
    greatest_force = std::max(greatest_force, stack.world.pointerWrench(0).force.norm());
  }
  counting = false;
  EXPECT_EQ(allocations, 0);
  EXPECT_GT(greatest_force, 0) << "the hand never touched anything: the contact path was not exercised";
  EXPECT_TRUE(stack.world.report().finite);
}

TEST_P(SceneAllocation, WhoWatchesIsServedWithoutAllocation) {
  Stack stack(GetParam());
  WorldPort port(stack.world, GetParam(), {}, 16);
  WorldSnapshot snapshot = port.first_snapshot;
  WorldCopy copy = port.first_copy;
  // The sender's `idle` stands for the runner: both sides of the ring are counted.
  const auto ask = [&](const WorldPort::Command& command) {
    return port.commands.send(command, std::chrono::milliseconds(0), [&] { port.serve(); });
  };
  ASSERT_TRUE(ask(WorldPort::TimeStages{true}));
  ASSERT_TRUE(ask(WorldPort::StreamSensors{true}));
  SensorSample sample;
  for (int i = 1; i <= 20000; ++i) {
    allocations = 0;
    counting = true;
    stack.tick();
    port.noteTick(i);
    port.serve();
    const bool asked = i % 100 == 0;
    const bool served = !asked || (ask(WorldPort::Look{&snapshot}) && ask(WorldPort::Copy{&copy}));
    counting = false;
    ASSERT_EQ(allocations, 0) << "tick " << i;
    ASSERT_TRUE(served);
    for (int s = 0; s < stack.world.sensorCount(); ++s) {
      ASSERT_TRUE(port.samples.pop(sample));
      ASSERT_EQ(sample.stamp_ns, i);
      ASSERT_EQ(sample.sensor, s);
    }
    ASSERT_FALSE(port.samples.pop(sample));
    if (!asked) continue;
    ASSERT_EQ(snapshot.stamp_ns, i);
    ASSERT_EQ(copy.stamp_ns, i);
    ASSERT_EQ(copy.state, stack.world.save());
  }
  EXPECT_GT(copy.stages.total(), 0);
}

TEST_P(SceneAllocation, BodiesComeAndGoWithoutAllocation) {
  Stack stack(GetParam());
  WorldPort port(stack.world, GetParam(), {}, 16);
  for (int i = 0; i < 500; ++i) stack.tick();
  const WorldDef def = measured(stack.scene.world);
  WorldDef more = def;
  ArticulationDef late = def.articulations[static_cast<std::size_t>(def.pointers[0].articulation)];
  late.X_WA.p += Vector3(0.5, 0.5, 0.5);
  more.articulations.push_back(late);
  std::vector<int> kept;
  for (std::size_t a = 0; a < def.articulations.size(); ++a) kept.push_back(static_cast<int>(a));
  std::vector<int> and_one = kept;
  and_one.push_back(-1);
  for (int round = 0; round < 6; ++round) {
    const bool comes = round % 2 == 0;
    ChangeBodies change;
    *change.packed = packBodies(comes ? more : def, comes ? and_one : kept);
    change.next = std::make_shared<NextWorld>(stack.world, comes ? more : def, comes ? and_one : kept);
    WorldRoom room{nullptr, change.packed, std::vector<std::uint64_t>(def.sensors.size(), 0)};
    const LoopCommand command{change};
    allocations = 0;
    counting = true;
    for (const bool steps : {false, true}) {
      port.commands.send(WorldPort::Rehearse{change.next.get(), steps}, std::chrono::milliseconds(0), [&] { port.serve(); });
      stack.tick();
    }
    const bool done = port.commands.send(WorldPort::Exchange{&command, &room}, std::chrono::milliseconds(0), [&] {
      port.serve([&](const LoopCommand& told) { stack.loop.take(told); });
    });
    for (int i = 0; i < 200; ++i) stack.tick();
    counting = false;
    ASSERT_TRUE(done);
    ASSERT_EQ(allocations, 0) << "round " << round;
    ASSERT_EQ(stack.world.linkCount(), static_cast<int>(linkNames(comes ? more : def).size()));
  }
}

TEST_P(SceneAllocation, TheLoopsMemoryIsCopiedWithoutAllocation) {
  Stack stack(GetParam());
  SessionStart start;
  start.world_tuning = stack.world.tuning().numbers();
  start.hands.push_back({"spidar", stack.device.def(), 0, stack.loop.hand(0).settings(), stack.device.save(), {}});
  LoopMemory memory = roomFor(start, stack.world.history().latest().packedCapacity());
  for (int i = 0; i < 5000; ++i) {
    stack.tick();
    allocations = 0;
    counting = true;
    remember(stack.loop, i, memory);
    counting = false;
    ASSERT_EQ(allocations, 0) << "tick " << i;
  }
  EXPECT_EQ(memory.world_state, stack.world.save());
  EXPECT_EQ(memory.hand[0].device, stack.device.save());
}

INSTANTIATE_TEST_SUITE_P(Scenes, SceneAllocation, testing::Values("touch_cube", "blocks", "box_on_floor"));

}  // namespace
}  // namespace haptic
