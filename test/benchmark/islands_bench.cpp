/// `./run bench islands`: worlds in which nearly everything stands. What sleep saves and costs in accuracy and energy, how a tick's
/// time grows with what sleeps, the scene `city` (its robots are found by ROS_PACKAGE_PATH). CPU time of the stepping thread. An argument
/// runs only the groups whose name contains it: sleep, search, city, peers, scenes_at_10k, rates, replay, look, units, deadline.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <memory>
#include <array>
#include <vector>

#include "../scenes/heap.h"
#include "../scenes/shipped_scenes.h"
#include "../scenes/tumbling.h"
#include "allocation_count.h"
#include "figure.h"
#include "haptic_core/base/cpu_time.h"
#include "haptic_core/base/error.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/step_history.h"
#include "haptic_core/world/work.h"
#include "islands_scenes.h"
#include "scene/hand_on_path.h"
#include "scene/scene_file.h"

namespace haptic::bench {
namespace {

using namespace scenes;

constexpr double kRocks = 1e-9;  ///< [m/s]

double secondsOf(const std::function<void()>& act) {
  const double start = cpuSeconds();
  act();
  return cpuSeconds() - start;
}

/// As if nothing had been slow for any time; the motion is not changed.
void keepAwake(World& world) {
  State state = world.state();
  std::fill(state.calm.begin(), state.calm.end(), 0);
  world.restore(state.pack());
}

/// A world with a hand that holds a cube over the first stack.
struct Hand {
  Hand(const StackParameters& p, const CubeParameters& c, const WorldSettings& settings)
      : world(stacks(p, c, settings)), start(handStart(p, c)) {}
  void step(const Vector3& way) {
    world.setPointerTarget(0, Pose(Vector3(start + way)), Twist{});
    world.step();
  }
  World world;
  Vector3 start;
};

/// 200 stacks of five that rock at 1e-9 m/s: at rest against awake, without a hand and beside one.
void measureRatio() {
  for (const bool hand : {false, true}) {
    StackParameters p;
    p.hand = hand;
    std::vector<double> awake, asleep;
    for (int repetition = 0; repetition < 5; ++repetition) {
      Hand rig(p, stiffCube(), WorldSettings{});
      const auto run = [&](int steps) {
        for (int i = 0; i < steps; ++i) hand ? rig.step(Vector3::Zero()) : rig.world.step();
      };
      run(60);
      State state = rig.world.state();
      std::fill(state.calm.begin(), state.calm.end(), 0);
      for (std::size_t i = 0; i < state.v.size(); ++i) state.v[i] = i % 6 < 3 ? kRocks / p.pitch : kRocks;  // turns first
      rig.world.restore(state.pack());
      run(2);
      awake.push_back(secondsOf([&] { run(8); }) / 8);  // before any island has come to rest by itself
      run(1500);
      asleep.push_back(secondsOf([&] { run(2000); }) / 2000);
      if (rig.world.report().standing != p.count * p.height) std::printf("only %d stand\n", rig.world.report().standing);
    }
    const std::string suffix = hand ? "_hand" : "";
    figure("sleep.awake_us" + suffix, 1e6 * median(awake), "us");
    figure("sleep.asleep_us" + suffix, 1e6 * median(asleep), "us");
    figure("sleep.step_ratio" + suffix, median(asleep) / median(awake), "1");
  }
}

/// A cube that falls past a corner of each stack wakes it without touching it: largest change of any wrench of the stack's contacts in
/// the step that wakes it.
void measureJump() {
  StackParameters p;
  p.count = 25;
  const CubeParameters c = stiffCube();
  WorldDef def = stacks(p, c, WorldSettings{});
  const int cubes = p.count * p.height;
  const Matrix3 turned = rotationFromRpy(Vector3(0, 0, 0.25 * M_PI));
  for (int i = 0; i < p.count; ++i) {
    const Vector3 start = stackAt(p, i) + Vector3(0.115, 0.115, 1.5 + 0.01 * i);
    def.articulations.push_back(cube("past" + std::to_string(i), c, Pose(turned, start)));
  }
  World world(def);
  double worst = 0;
  int woke = 0;
  std::vector<std::array<double, 6>> last(static_cast<std::size_t>(cubes) + 1), now(last.size());
  for (int step = 0; step < 550; ++step) {
    std::vector<char> stood;
    for (int l = 1; l <= cubes; ++l) stood.push_back(world.stands(l));
    world.step();
    for (int i = 0; i < world.contactCount(); ++i) {
      const ContactReport& contact = world.contact(i);
      if (contact.link_b > cubes) continue;
      const Wrench& F = contact.F_BP_W;  // each cube stands on one thing
      now[static_cast<std::size_t>(contact.link_b)] = {F.torque.x(), F.torque.y(), F.torque.z(), F.force.x(), F.force.y(), F.force.z()};
    }
    for (int l = 1; l <= cubes; ++l) {
      const auto cube = static_cast<std::size_t>(l);
      if (stood[cube - 1] && !world.stands(l)) {
        ++woke;
        for (std::size_t k = 0; k < 6; ++k) worst = std::max(worst, std::abs(now[cube][k] - last[cube][k]));
      }
    }
    last = now;
  }
  figure("sleep.woken", woke, "1");
  figure("sleep.wake_jump_n", worst, "N");
}

/// A heap and jittered stacks against themselves, never asleep.
void measureError() {
  HeapParameters heap_of;
  heap_of.count = 100;
  double position = 0, booked = 0;
  int standing = 0;
  for (const bool heaps : {false, true}) {
    const WorldDef def = heaps ? heap(heap_of, WorldSettings{}) : stack(5, stiffCube(), WorldSettings{}, 4e-3);
    World sleeps(def), never(def);
    for (int i = 0; i < 8000; ++i) {
      sleeps.step();
      if (i % 50 == 0) keepAwake(never);
      never.step();
    }
    for (int l = 0; l < sleeps.linkCount(); ++l) position = std::max(position, (sleeps.linkPose(l).p - never.linkPose(l).p).norm());
    booked += sleeps.report().energy.stilled;
    standing += sleeps.report().standing;
  }
  figure("sleep.standing", standing, "1");
  figure("sleep.position_err_um", 1e6 * position, "um");
  figure("sleep.booked_j", booked, "J");
}

/// A tick in which the hand rubs the first stack, beside more and more that sleeps.
void measureSearch() {
  std::vector<double> x, y;
  for (const int bodies : {100, 1000, 10000}) {
    StackParameters p;
    p.count = bodies / 5, p.hand = true;
    WorldSettings settings;
    settings.history_steps = 10;
    const auto start = std::make_unique<Hand>(p, stiffCube(), settings);
    Hand& hand = *start;
    const auto rub = [&](int steps) {
      for (int i = 0; i < steps; ++i) hand.step(Vector3(1e-6 * (i % 100), 0, -0.02002));
    };
    for (int i = 0; i < 200; ++i) hand.step(Vector3(0, 0, -1e-4 * i));
    rub(200);
    std::vector<double> ticks;
    for (int k = 0; k < 11; ++k) ticks.push_back(secondsOf([&] { rub(100); }) / 100);
    figure("search.tick_us_" + std::to_string(bodies), 1e6 * median(ticks), "us");
    x.push_back(std::log(bodies)), y.push_back(std::log(median(ticks)));
  }
  double mx = 0, my = 0, xy = 0, xx = 0;
  for (std::size_t i = 0; i < x.size(); ++i) mx += x[i] / x.size(), my += y[i] / y.size();
  for (std::size_t i = 0; i < x.size(); ++i) xy += (x[i] - mx) * (y[i] - my), xx += (x[i] - mx) * (x[i] - mx);
  figure("search.time_exponent", xy / xx, "1");
}

/// Resident memory of the process [MB].
double residentMegabytes() {
  long pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

void figureTicks(const std::string& prefix, std::vector<double> ticks) {
  std::sort(ticks.begin(), ticks.end());
  const auto share = [&](double s) { return 1e6 * ticks[static_cast<std::size_t>(s * static_cast<double>(ticks.size() - 1))]; };
  const auto late = ticks.end() - std::upper_bound(ticks.begin(), ticks.end(), 1e-4);
  figure(prefix + "tick_us_median_10k", share(0.5), "us");
  figure(prefix + "tick_us_p99_10k", share(0.99), "us");
  figure(prefix + "tick_us_p9999_10k", share(0.9999), "us");
  figure(prefix + "missed_pct_10k", 100.0 * static_cast<double>(late) / static_cast<double>(ticks.size()), "%");
}

/// 60 s at 10 kHz: all of it, and once the heap lies. While it falls, one tick in ten solves it whole.
void measureAt10k(SceneDef scene) {
  constexpr int kTicks = 600000, kLies = 40000;
  scene.world.settings.step = 1e-4;
  World world(scene.world);
  std::vector<double> ticks;
  ticks.reserve(kTicks);
  for (int i = 0; i < kTicks; ++i) {
    followPaths(scene, world);
    ticks.push_back(secondsOf([&] { world.step(); }));
  }
  figure("city.lying_standing_10k", world.report().standing, "1");
  figureTicks("city.", ticks);
  figureTicks("city.lying_", {ticks.begin() + kLies, ticks.end()});
}

void measureCity() {
  const std::string folder = HAPTIC_SOURCE_DIR "/urdf/scenes/large/";
  for (const std::string name : {"pile300", "city"}) {
    try {
      loadScene(folder + name + ".yaml");  // meshes are cached now
      const double before = residentMegabytes();
      SceneDef scene;
      std::unique_ptr<World> world;
      const double load = secondsOf([&] {
        scene = loadScene(folder + name + ".yaml");
        world = std::make_unique<World>(scene.world);
      });
      int bodies = 0;
      for (int l = 0; l < world->linkCount(); ++l) bodies += world->canGrab(0, l) ? 1 : 0;
      figure(name + ".links", world->linkCount(), "1");
      figure(name + ".free_bodies", bodies, "1");
      figure(name + ".load_s", load, "s");
      std::vector<double> ticks;
      for (int i = 0; i < 8000; ++i) {
        followPaths(scene, *world);
        ticks.push_back(secondsOf([&] { world->step(); }));
      }
      figure(name + ".memory_mb", residentMegabytes() - before, "MB");
      figure(name + ".standing", world->report().standing, "1");
      std::vector<double> last(ticks.end() - 2000, ticks.end());
      std::sort(last.begin(), last.end());
      figure(name + ".tick_us_median_1k", 1e6 * last[last.size() / 2], "us");
      figure(name + ".tick_us_p99_1k", 1e6 * last[last.size() * 99 / 100], "us");
      if (name == "city") measureAt10k(scene);
    } catch (const SetupError& error) {
      std::printf("%s left out: %s\n", name.c_str(), error.what());
    }
  }
}

/// A hand at 10 kHz that presses and rubs the first of 25 stacks of two, beside others whose upper cubes fall on them and tumble. With
/// `visited` the first of these slides on the floor into the hand's stack in place of falling.
WorldDef besideTumbling(double far_step, bool visited) {
  WorldDef def = tumbling(far_step, 1e8, 25);
  if (!visited) return def;
  ArticulationDef& visitor = def.articulations[4];
  visitor.X_WA = Pose(Vector3(stackAt(stacksOfTwo(25), 0) + Vector3(-0.5, 0.01, 0.5 * stiffCube().size)));
  visitor.V_WA = Twist{};
  visitor.V_WA.linear = Vector3(2, 0, 0);
  return def;
}

/// Own rates against everything at the hand's: force at the hand, CPU time, and a world that goes on from a saved state.
void measureRates() {
  constexpr int kTicks = 10000;
  for (const bool visited : {false, true}) {
    World all(besideTumbling(0, visited)), own(besideTumbling(1e-3, visited)), again(besideTumbling(1e-3, visited));
    std::vector<double> all_s, own_s;
    for (std::vector<double>* ticks : {&all_s, &own_s}) ticks->reserve(kTicks);
    double error = 0, force = 0, waiting = 0;
    long mismatches = 0, allocations = 0;
    for (int i = 0; i < kTicks; ++i) {
      for (World* world : {&all, &own, &again}) rubNext(*world);
      all_s.push_back(secondsOf([&] { all.step(); }));
      const long before = allocationCount();
      own_s.push_back(secondsOf([&] { own.step(); }));
      allocations += allocationCount() - before;
      again.step();
      if (i % 997 == 0) again.restore(again.save());
      mismatches += own.hash() != again.hash();
      const Vector3 F = all.pointerWrench(0).force;
      error += (own.pointerWrench(0).force - F).squaredNorm(), force += F.squaredNorm();
      waiting += own.report().waiting;
    }
    const std::string prefix = visited ? "rates.visited." : "rates.";
    figure(prefix + "hand_force_err_pct", 100 * std::sqrt(error / force), "%");
    figure(prefix + "waiting_mean", waiting / kTicks, "1");
    figure(prefix + "replay_mismatches", static_cast<double>(mismatches), "1");
    figure(prefix + "allocations", static_cast<double>(allocations), "1");
    for (std::vector<double>* ticks : {&all_s, &own_s}) {
      const std::string name = prefix + (ticks == &all_s ? "all_at_10k." : "own.");
      double sum = 0;
      for (const double s : *ticks) sum += s;
      std::sort(ticks->begin(), ticks->end());
      figure(name + "tick_us_mean", 1e6 * sum / kTicks, "us");
      figure(name + "tick_us_p99", 1e6 * (*ticks)[kTicks * 99 / 100], "us");
      figure(name + "tick_us_max", 1e6 * ticks->back(), "us");
    }
  }
}

/// A hand that races across 25 stacks at 1 m/s, knocks and lets stand: against the general pipeline, against a world that goes on from a
/// saved state, and how much it allocates. Beside it, with own rates.
void measureReplay() {
  StackParameters p;
  p.count = 25, p.height = 3, p.hand = true;
  WorldDef def = stacks(p, stiffCube(), WorldSettings{});
  const Vector3 start = handStart(p, stiffCube());
  const auto move = [&](World& world) {
    const double t = world.time(), along = std::min(t, 1.5) * 0.8;
    world.setPointerTarget(0, Pose(Vector3(start + Vector3(along, 0.3 * along, -0.022))), Twist{});
    world.step();
  };
  World first(def), again(def);
  def.settings.leave_out = false;
  World general(def);
  long mismatches = 0, allocations = 0;
  for (int i = 0; i < 3000; ++i) {
    const long before = allocationCount();
    move(first);
    allocations += allocationCount() - before;
    move(general);
    if (i == 1000) again.restore(first.save());
    if (i > 1000) move(again);
    mismatches += first.hash() != general.hash();
    mismatches += i > 1000 && first.hash() != again.hash();
  }
  World own(besideTumbling(1e-3, true)), from_saved(besideTumbling(1e-3, true));
  for (int i = 0; i < 3000; ++i) {
    const long before = allocationCount();
    rub(own), rub(from_saved);
    allocations += allocationCount() - before;
    mismatches += own.hash() != from_saved.hash();
    if (i % 997 == 0) from_saved.restore(own.save());
  }
  for (int l = 0; l < first.linkCount(); ++l) mismatches += !(first.linkPose(l).p == general.linkPose(l).p);
  figure("replay.mismatches", static_cast<double>(mismatches), "1");
  figure("replay.standing", first.report().standing, "1");
  figure("allocations.islands", static_cast<double>(allocations), "1");
}

/// Every const function of a world.
void lookAt(const World& world) {
  volatile double sink = world.time() + world.settings().step + world.report().work + static_cast<double>(world.history().size());
  for (int l = 0; l < world.linkCount(); ++l) {
    sink = world.linkPose(l).p.x() + world.linkTwist(l).linear.x() + world.linkIndex(world.linkName(l)) + world.stands(l);
  }
  for (int j = 0; j < world.jointCount(); ++j) {
    sink = world.joint(j).effort + world.jointIndex(world.jointName(j)) + world.jointLink(j) + world.obeysCommands(j);
  }
  for (int i = 0; i < world.wrenchCount(); ++i) sink = world.wrench(i).link;
  for (int i = 0; i < world.forceCount(); ++i) sink = world.force(i).p_WA.x() + static_cast<double>(world.forceName(i).size());
  for (int i = 0; i < world.motionCount(); ++i) sink = world.motion(i).link + world.motionIndex(world.motion(i).name);
  for (int i = 0; i < world.pointerCount(); ++i) {
    sink = world.pointerPose(i).p.x() + world.pointerStiffness(i) + world.pointerWrench(i).force.x() + world.pointerForceError(i);
    sink = world.pointerHome(i) + world.pointerLink(i) + world.canGrab(i, 0) + world.pointerBound(i).force;
  }
  for (int i = 0; i < world.contactCount(); ++i) sink = world.contact(i).depth;
  for (int i = 0; i < world.sensorCount(); ++i) {
    sink = world.sensorReading(i).specific_force_S.x() + world.sensorIndex(world.sensor(i).name);
  }
  sink = world.q().size() + world.v().size() + static_cast<double>(world.hash() % 2) + world.state().time + world.tuning().stiffness_scale;
  sink = static_cast<double>(world.save().size() + world.planText().size() + world.model().links.size()) + world.work().counted.done;
  (void)sink;
}

/// Every shipped scene twice, one of them looked at between its steps.
void measureLooks() {
  int differ = 0, wakes = 0, rests = 0;
  for (const ShippedScene& scene : shippedScenes(HAPTIC_SOURCE_DIR "/urdf/scenes")) {
    World seen(scene.def.world), unseen(scene.def.world);
    bool same = true, awake = false;
    for (int i = 0; i < 1500; ++i) {
      for (World* world : {&seen, &unseen}) {
        followPaths(scene.def, *world);
        world->step();
      }
      if (i % 10 == 0) lookAt(seen);
      same &= seen.hash() == unseen.hash();
      awake |= seen.work().activity.trees() != unseen.work().activity.trees();
      rests += seen.work().activity.trees() > 0;
    }
    differ += !same, wakes += awake;
  }
  figure("look.bits_differ", differ, "scenes");
  figure("look.wakes", wakes, "scenes");
  figure("look.steps_with_rest", rests, "1");
}

}  // namespace
}  // namespace haptic::bench

int main(int argc, char** argv) {
  using namespace haptic::bench;
  const auto wants = [&](const char* group) { return argc < 2 || std::strstr(group, argv[1]) != nullptr; };
  if (wants("sleep")) measureRatio(), measureJump(), measureError();
  if (wants("search")) measureSearch();
  if (wants("city")) measureCity();
  if (wants("peers")) measureCityBesidePeers();
  if (wants("scenes_at_10k")) measureScenesAt10k();
  if (wants("rates")) measureRates();
  if (wants("replay")) measureReplay();
  if (wants("look")) measureLooks();
  if (wants("units")) measureUnits();
  if (wants("deadline")) measureDeadline();
  return 0;
}
