// A session that holds everything that can happen between ticks is run twice: live, and again from what was recorded.
#include "haptic_core/loop/session.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>

#include "../../scenes/touch.h"
#include "haptic_core/base/error.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/spidar/spidar.h"

namespace haptic {
namespace session_test {

constexpr double kPeriod = 1e-3;  // [s]
// Before this tick the world's state is noted without having changed: restoring what is there must change nothing.
constexpr std::uint64_t kRememberEvery = 37;  // [ticks]; and where something happens

ArticulationDef box(const char* name, const Vector3& size, JointType type, const Vector3& p, double mass) {
  ArticulationDef def = scenes::springyBody(name, makeBox(size), type, p, 1e7);
  def.links[0].inertia = {mass, Vector3::Zero(), mass * size.squaredNorm() / 18 * Matrix3::Identity()};
  def.links[0].collisions[0].material.dissipation = ContactMaterial{}.dissipation;
  return def;
}

/// Two pointers beside and above a free block on a floor, a pendulum that swings by, and beside them a lift with a belt that carries a
/// crate.
WorldDef scene() {
  WorldDef world;
  world.name = "session";
  world.settings.step = kPeriod;
  world.articulations.push_back(box("floor", {0.4, 0.4, 0.02}, JointType::kFixed, {0, 0, -0.01}, 1));
  world.articulations.push_back(box("block", {0.03, 0.03, 0.03}, JointType::kFloating, {0, 0, 0.015}, 0.1));
  world.articulations.push_back(box("top", {0.01, 0.01, 0.01}, JointType::kFloating, {0, 0, 0.04}, 0.05));
  world.articulations.push_back(box("side", {0.01, 0.01, 0.01}, JointType::kFloating, {-0.03, 0, 0.015}, 0.05));
  ArticulationDef pendulum = box("pendulum", {0.02, 0.02, 0.02}, JointType::kRevolute, {0.05, 0.05, 0.2}, 0.1);
  pendulum.links[0].inertia.p_LC = Vector3(0, 0.05, 0);
  pendulum.links[0].joint.name = "hinge";
  pendulum.links[0].joint.drive_damping = 1e-3;
  world.articulations.push_back(pendulum);
  world.articulations.push_back(box("lift", {0.3, 0.1, 0.02}, JointType::kFloating, {0, 0.5, -0.01}, 1));
  world.articulations.push_back(box("crate", {0.04, 0.04, 0.02}, JointType::kFloating, {0, 0.5, 0.01}, 0.2));
  world.articulations[5].links[0].collisions[0].belt.V_L.linear.x() = 0.02;
  MotionDef lift;
  lift.name = "lift";
  lift.articulation = 5, lift.link = 0;
  world.motions.push_back(lift);
  scenes::addPointer(world, 2, "left");
  scenes::addPointer(world, 3, "right");
  return world;
}

/// The same with one more block that falls, and without the crate.
WorldDef changed(std::vector<int>& kept) {
  WorldDef world = scene();
  world.articulations.push_back(box("late", {0.02, 0.02, 0.02}, JointType::kFloating, {0.1, -0.1, 0.05}, 0.05));
  world.articulations.erase(world.articulations.begin() + 6);
  kept = {0, 1, 2, 3, 4, 5, -1};
  return world;
}

struct Recording {
  SessionStart start;
  std::vector<TickInput> ticks;   ///< without what stands in events
  std::vector<LoopEvent> events;
  std::vector<TickHash> hashes;
  struct Later {                  ///< the session begun in the middle
    SessionStart start;
    std::size_t event = 0;        ///< the first that was not done by then
  };
  std::vector<Later> later;
};

/// Two twins on the scene's two pointers, with a loop that is recorded as the bridge does it.
struct Live {
  DeviceDef def = loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/spidar_g6x3r.yaml");
  World world{scene()};
  HapticLoop loop{world};
  std::vector<std::unique_ptr<Spidar>> device;
  std::vector<std::unique_ptr<DeviceTwin>> twin;
  Recording recording;
  std::uint64_t tick = 0;
  std::array<int, kMaxHands> origin{0, 1};  ///< index at the start of each of the loop's hands

  Live() {
    recording.start.step = kPeriod;
    for (int i = 0; i < 2; ++i) {
      device.push_back(std::make_unique<Spidar>(def));
      TwinSettings settings;
      settings.period = kPeriod;
      settings.path = {{{0.05, Vector3::Zero(), Vector3::Zero(), 0},
                        {0.3, i == 0 ? Vector3(0, 0, -0.012) : Vector3(0.012, 0, 0), Vector3(0, 0.1, 0), 0},
                        {0.6, i == 0 ? Vector3(0.01, 0, -0.012) : Vector3(0.02, 0.003, 0), Vector3::Zero(), 0},
                        {1.2, Vector3(-0.01, 0.01, 0.002), Vector3::Zero(), 0},
                        {1.6, i == 0 ? Vector3(0, 0, -0.014) : Vector3(0.014, 0, 0), Vector3::Zero(), 0}}};
      twin.push_back(std::make_unique<DeviceTwin>(def, settings));
      HandSettings hand;
      hand.workspace.X_WB = world.linkPose(world.pointerLink(i));
      hand.soft_start_s = 0.1;
      hand.passivity.mode = PassivityMode::kAct;
      hand.grab_button = 0;
      loop.attach(*device[i], i, hand);
      recording.start.hands.push_back({i == 0 ? "left" : "right", def, i, hand, device[i]->save()});
    }
    recording.start.world_state = world.save();
    recording.start.world_tuning = world.tuning().numbers();
  }

  void tell(const LoopCommand& command) {
    loop.take(command);
    recording.events.push_back({tick, command});
  }

  void run(int ticks, int lost = 0, unsigned buttons = 0) {
    for (int n = 0; n < ticks; ++n) {
      if (tick % kRememberEvery == 0 || n == 0) {
        LoopMemory memory = roomFor(recording.start, 0);
        remember(loop, tick, memory);
        recording.later.push_back({startedAt(recording.start, memory, origin), recording.events.size()});
      }
      TickInput input;
      input.tick = tick;
      input.hands = loop.handCount();
      input.lost_periods = n == 0 ? lost : 0;
      for (int i = 0; i < input.hands; ++i) {
        input.sample[i] = twin[i]->exchange(device[i]->drive());
        input.sample[i].buttons = buttons;
        const DeviceRequests requests = device[i]->takeRequests(input.sample[i]);
        if (requests.any()) tell({AskDevice{requests}, i});
      }
      loop.tick(input, kPeriod);
      recording.hashes.emplace_back();
      hashTick(loop, recording.hashes.back());
      recording.ticks.push_back(input);
      ++tick;
    }
  }
};

/// Everything once: calibration, enable, overruns, a silence, pause, clutch, tuning, grab by button and by hand, reset, loss, switch, STOP.
Recording record() {
  Live live;
  live.device[0]->calibrateAtHome();
  live.device[0]->setForceEnabled(true);
  live.run(20);
  live.device[1]->calibrateAtHome();
  live.device[1]->setForceEnabled(true);
  live.run(100);
  live.tell({RestoreWorld{live.world.save()}});
  live.tell({HoldClutch{true}, 0});  // not in contact yet: it would wait
  live.run(10);
  live.tell({HoldClutch{false}, 0});
  live.run(270);
  const std::vector<double> saved = live.world.save();
  live.run(50, 3);
  live.run(30, 700);  // more than half a second: the force waits until it is enabled
  for (auto& device : live.device) device->setForceEnabled(true);
  live.run(300);
  live.tell({PauseWorld{true}});
  live.run(30);
  live.tell({StepWorld{}});
  live.run(10);
  live.tell({PutBody{live.world.linkIndex("crate"), Pose(rotationAbout(Vector3::UnitZ(), 0.2), Vector3(-0.08, 0.51, 0.0101)),
                     {Vector3(0, 0, 0.5), Vector3(0, 0, 0.05)}}});
  live.tell({PutJoints{{{live.world.jointIndex("hinge"), 0.3}}}});
  live.run(5);
  live.tell({PauseWorld{false}});
  live.run(200);
  WorldTuning tuning = live.world.tuning();
  tuning.stiffness_scale = 0.5;
  tuning.friction_scale = 0.7;
  tuning.gravity = Vector3(0.3, 0, -8);
  tuning.coupling[1].mode = PointerCoupling::Mode::kVirtual;
  live.tell({TuneWorld{tuning}});
  Spidar::Tuning limits = live.device[0]->tuning();
  limits.max_force *= 0.5;
  limits.lambda *= 200;  // large enough to be felt inside of what the strings can present
  live.tell({TuneDevice{limits.lambda, limits.max_force, limits.max_torque}, 0});
  Calibration moved;
  for (const StringDef& string : live.def.strings) moved.p_BE.push_back(string.p_BE + Vector3(1e-3, 0, 0));
  moved.zero_length = live.device[1]->zeroLengths();
  live.tell({adoptionOf(moved), 1});
  live.run(50);
  std::vector<double> memory = live.device[0]->save();
  memory[1] *= 0.1;  // λ
  live.tell({RestoreDevice{memory}, 0});
  HandSettings settings = live.loop.hand(1).settings();
  settings.workspace.scale = 0.5;
  live.tell({ChangeHand{settings}, 1});
  live.run(200);
  live.tell({DriveJoint{live.world.jointIndex("hinge"), {JointDef::Drive::kVelocity, 0, 2, 0}}});
  live.run(20);
  const Quaternion turned(rotationAbout(Vector3::UnitZ(), 0.1));
  live.tell({LeadBody{0, {Vector3(0.01, 0.5, 0.02), turned, {Vector3(0, 0, 0.2), Vector3(0, 0, 0.1)}}, 0.15}});
  live.run(20);
  live.tell({ApplyWrench{live.world.linkIndex("crate"), {{Vector3(0, 0, 0.01), Vector3(0.5, 0, 0.3)}, Vector3(0.01, 0, 0), true}, 0.06}});
  live.run(20);
  live.tell({GrabLink{0, live.world.linkIndex("block")}});
  live.run(100);
  live.tell({RestoreWorld{saved}});
  live.run(440);  // to where the pointer touches the block again
  live.run(20, 0, 1);  // the grab button: whatever the pointer touches, if it does
  live.run(100);
  settings.workspace.X_WB.p += Vector3(1e-3, 0, 2e-3);  // the base was moved: the pointer glides after it
  live.tell({ChangeHand{settings}, 1});
  live.run(50);
  std::vector<int> kept;
  const WorldDef next = changed(kept);
  ChangeBodies change;
  *change.packed = packBodies(next, kept);
  change.next = std::make_shared<NextWorld>(live.world, next, kept);
  live.run(3);  // while it was made
  live.world.rehearse(*change.next, true);  // no recording knows of it
  live.run(1);
  live.tell({change});
  live.run(60);
  live.tell({DropHand{}, 0});
  live.device.erase(live.device.begin());
  live.twin.erase(live.twin.begin());
  live.origin[0] = 1;
  live.run(200);
  live.tell({HoldSwitch{false}, 0});
  live.run(20);
  live.tell({HoldSwitch{true}, 0});
  live.run(50);
  live.tell({StopDevice{}, 0});
  live.run(20);
  live.device[0]->setForceEnabled(true);
  live.run(50);
  live.tell({SetGravity{Vector3(0, 0.2, -9.6)}});
  live.run(20);
  return live.recording;
}

struct Difference {
  int ticks = 0;
  std::uint64_t first = 0;
  std::string part;
};

Difference replay(const Recording& recording, const SessionStart& start, std::size_t event) {
  SessionReplay replay(scene(), start);
  Difference difference;
  for (std::size_t t = start.first_tick; t < recording.ticks.size(); ++t) {
    while (event < recording.events.size() && recording.events[event].tick == t) replay.apply(recording.events[event++].command);
    const TickHash& hash = replay.tick(recording.ticks[t]);
    if (hash == recording.hashes[t]) continue;
    if (difference.ticks++ > 0) continue;
    difference.first = t;
    for (int i = 0; i < hash.parts && difference.part.empty(); ++i) {
      if (hash.part[i] != recording.hashes[t].part[i]) difference.part = replay.partName(i);
    }
  }
  return difference;
}

Difference replay(const Recording& recording) { return replay(recording, recording.start, 0); }

TEST(Session, RunsAgainBitForBit) {
  const Recording recording = record();
  const Difference difference = replay(recording);
  EXPECT_EQ(difference.ticks, 0) << "first at tick " << difference.first << ", " << difference.part;
}

// Whatever the loop remembers from tick to tick is in its memory: soft start, glide, clutch, grab, passivity, active sets.
TEST(Session, BeginsInTheMiddle) {
  const Recording recording = record();
  ASSERT_GT(recording.later.size(), 40u);
  for (const Recording::Later& later : recording.later) {
    const Difference difference = replay(recording, later.start, later.event);
    EXPECT_EQ(difference.ticks, 0) << "from tick " << later.start.first_tick << " on: first at " << difference.first << ", "
                                   << difference.part;
    for (const SessionStart::HandStart& hand : later.start.hands) {
      EXPECT_LE(hand.loop_memory.size(), Hand::mostMemory(hand.settings, kPeriod));
    }
  }
}

TEST(Session, RefusesAHandsMemoryThatDoesNotFit) {
  const Recording recording = record();
  for (const int change : {-1, 1}) {
    SessionStart start = recording.later.back().start;
    std::vector<double>& memory = start.hands[0].loop_memory;
    memory.resize(memory.size() + change);
    EXPECT_THROW(SessionReplay(scene(), start), SetupError);
  }
}

TEST(Session, ContainsContactsGrabsAndForces) {
  const Recording recording = record();  // otherwise equal hashes would say little
  SessionReplay again(scene(), recording.start);
  std::size_t event = 0;
  int contacts = 0, sticking = 0, forces = 0;
  for (std::size_t t = 0; t < recording.ticks.size(); ++t) {
    while (event < recording.events.size() && recording.events[event].tick == t) again.apply(recording.events[event++].command);
    again.tick(recording.ticks[t]);
    contacts += again.world().contactCount() > 1;
    for (int i = 0; i < again.world().contactCount(); ++i) sticking += again.world().contact(i).sticking;
    forces += again.loop().report().hand[0].F_achieved_B.force.norm() > 0.1;
  }
  EXPECT_GT(contacts, 100);
  EXPECT_GT(sticking, 100);
  EXPECT_GT(forces, 100);
}

TEST(Session, ADifferenceIsToldByTickAndBody) {
  Recording recording = record();
  recording.ticks[60].sample[1].counts[3] += 1;  // one count: the right hand's pointer moves by micrometres
  const Difference difference = replay(recording);
  EXPECT_EQ(difference.first, 60u);
  EXPECT_EQ(difference.part, "link side");
  EXPECT_GT(difference.ticks, 0);
}

TEST(Session, EachKindOfEventMatters) {
  const Recording complete = record();
  for (std::size_t i = 0; i < complete.events.size(); ++i) {
    Recording without = complete;
    const LoopEvent event = complete.events[i];
    if (event.command.is<DropHand>()) continue;  // the hands would no longer fit the samples
    without.events.erase(without.events.begin() + static_cast<std::ptrdiff_t>(i));
    const Difference difference = replay(without);
    EXPECT_GT(difference.ticks, 0) << "event " << i << " of kind " << event.command.kind.index();
    EXPECT_GE(difference.first, event.tick);
  }
}

// A bag keeps kind, hand and numbers: they must say all of each command.
TEST(Session, CommandsComeBackFromTheirNumbers) {
  const Recording recording = record();
  std::vector<bool> seen(std::variant_size_v<LoopCommand::Kind>);
  for (const LoopEvent& event : recording.events) {
    const LoopCommand& command = event.command;
    const LoopCommand again = commandFrom(command.kind.index(), command.hand, numbersOf(command));
    EXPECT_EQ(again.kind.index(), command.kind.index());
    EXPECT_EQ(again.hand, command.hand);
    const std::vector<double> first = numbersOf(command), second = numbersOf(again);  // packed bytes may be numbers that are none
    ASSERT_EQ(first.size(), second.size());
    EXPECT_EQ(std::memcmp(first.data(), second.data(), first.size() * sizeof(double)), 0);
    seen[command.kind.index()] = true;
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), true), static_cast<long>(seen.size()));
}

TEST(Session, RefusesWhatDoesNotFit) {
  const Recording recording = record();
  SessionStart other = recording.start;
  other.step = 5e-4;
  EXPECT_THROW(SessionReplay(scene(), other), SetupError);
  other = recording.start;
  other.world_state.pop_back();
  EXPECT_THROW(SessionReplay(scene(), other), SetupError);
  other = recording.start;
  other.hands[0].memory.pop_back();
  EXPECT_THROW(SessionReplay(scene(), other), SetupError);
  SessionReplay good(scene(), recording.start);
  EXPECT_THROW(good.apply({ChangeHand{}, 5}), SetupError);
  EXPECT_THROW(good.apply({GrabLink{7, 0}}), SetupError);
  EXPECT_THROW(good.apply({AdoptCalibration{{1, 2, 3}}, 0}), SetupError);
  EXPECT_THROW(good.apply({TuneDevice{}, 0}), SetupError);
  EXPECT_THROW(commandFrom(LoopCommand{ChangeHand{}}.kind.index(), 0, {1, 2}), SetupError);
  EXPECT_THROW(commandFrom(200, 0, {}), SetupError);
  ChangeBodies cut;
  EXPECT_THROW(good.apply({cut}), SetupError);
  std::vector<int> kept;
  *cut.packed = packBodies(changed(kept), kept);
  (*cut.packed)[7] += 1;
  EXPECT_THROW(good.apply({cut}), SetupError);
}

TEST(Session, FingerprintTellsScenesApart) {
  const std::uint64_t same = fingerprint(scene());
  EXPECT_EQ(fingerprint(scene()), same);
  const std::function<void(WorldDef&)> changes[] = {
      [](WorldDef& w) { w.settings.attempts = Attempts::kImplicitEuler; },
      [](WorldDef& w) { w.articulations[1].links[0].inertia.mass *= 1 + 1e-15; },
      [](WorldDef& w) { w.articulations[1].links[0].collisions[0].material.stiffness *= 2; },
      [](WorldDef& w) { w.articulations[1].links[0].collisions[0].material.rest_stiffness = 1e6; },
      [](WorldDef& w) { w.articulations[1].X_WA.p.z() += 1e-12; },
      [](WorldDef& w) { w.pointers.pop_back(); },
      [](WorldDef& w) { w.motions.pop_back(); },
      [](WorldDef& w) { w.motions[0].time = {0}, w.motions[0].pose = {w.articulations[5].X_WA}; },
      [](WorldDef& w) { w.articulations[5].links[0].collisions[0].belt.V_L.linear.x() = 0; },
      [](WorldDef& w) { w.articulations[5].links[0].collisions[0].belt.V_L.angular.z() = 1e-12; },
      [](WorldDef& w) { w.joint_paths.push_back({"path", {}, {0.0, 1.0}, {}}); },
      [](WorldDef& w) { w.articulations.back().links.push_back(LinkDef{}); }};
  for (const auto& change : changes) {
    WorldDef other = scene();
    change(other);
    EXPECT_NE(fingerprint(other), same);
  }
}

/// Recordings of before there were chosen stiffnesses have the fingerprints of scenes that give k.
TEST(Session, FingerprintLeavesOutStiffnessesThatNobodyChose) {
  WorldDef other = scene();
  ContactMaterial& material = other.articulations[1].links[0].collisions[0].material;
  ASSERT_FALSE(material.rest_stiffness > 0);
  material.rest_stiffness = 0, material.touch_stiffness = -1;  // other bits that say the same: not chosen
  EXPECT_EQ(fingerprint(other), fingerprint(scene()));
  material.touch_stiffness = 1e6;
  EXPECT_NE(fingerprint(other), fingerprint(scene()));
}

}  // namespace session_test
}  // namespace haptic
