#include "robots_actors.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <ctime>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "haptic_core/base/cpu_time.h"
#include "../scenes/actors.h"
#include "figure.h"
#include "haptic_core/loop/session.h"

namespace haptic::bench {
namespace {

using namespace scenes;

constexpr Attempts kAll[] = {Attempts::kImplicitEuler, Attempts::kSdirk2,
                               Attempts::kAll};

WorldSettings settingsOf(Attempts attempts) {
  WorldSettings s;
  s.attempts = attempts;
  return s;
}

/// A free body under force, gravity and a torque about a principal axis, for a second and a second more without: place, speed, angle and
/// rate, against the closed form of the step's law, each over its own size.
double responseError(Attempts attempts) {
  const LoneBody body;
  WorldSettings s = settingsOf(attempts);
  s.gravity = Vector3(0.3, 0, -2);
  World world(alone(body, s));
  const double h = s.step, torque = 1e-3, inertia = body.inertia()(2, 2);
  const Vector3 force(2, -1, 0.5);
  const int n = 1000;
  world.applyWrench(0, {{Vector3(0, 0, torque), force}, Vector3::Zero(), false}, n * h);
  for (int i = 0; i < 2 * n; ++i) world.step();
  const auto way = [&](const Vector3& a) { return Vector3(0.5 * h * h * n * n * a); };
  const Vector3 a = force / body.mass + s.gravity, v1 = n * h * a, v = v1 + n * h * s.gravity;
  const Vector3 p = way(a) + n * h * v1 + way(s.gravity), turned = way(Vector3(0, 0, torque / inertia));
  const double rate = n * h * torque / inertia, angle = turned.z() + n * h * rate;
  const Matrix3& R = world.linkPose(0).R;
  const double off = std::remainder(elementary::atan2(R(1, 0), R(0, 0)) - angle, 2 * M_PI);
  return std::max({(world.linkPose(0).p - p).norm() / p.norm(), (world.linkTwist(0).linear - v).norm() / v.norm(),
                   std::abs(off) / angle, std::abs(world.linkTwist(0).angular.z() - rate) / rate});
}

/// Slip [m] of a load on a platform that wanders and turns for 10 s and rests before and after, and on a turntable over nine of its ten
/// seconds: at rest, and at a constant rate, the elastic share is the same before and after.
double slipWhenCarried(Attempts attempts) {
  World wanders(onCarrier(Load{}, settingsOf(attempts), wandering(10, 0.05), 0.05));
  const Vector3 first = placeOnCarrier(wanders);
  while (wanders.time() < 11) wanders.step();
  std::vector<Pose> circle;
  for (int i = 0; i <= 4; ++i) circle.emplace_back(rotationAbout(Vector3::UnitZ(), 0.5 * M_PI * (i % 4)), Vector3::Zero());
  WorldDef def = onCarrier(Load{}, settingsOf(attempts), circle, 0.5, true);
  def.articulations[1].V_WA = {Vector3(0, 0, M_PI), M_PI * Vector3::UnitZ().cross(Load{}.place)};
  World turns(def);
  while (turns.time() < 1) turns.step();
  const Vector3 before = placeOnCarrier(turns);
  while (turns.time() < 10) turns.step();
  return std::max((placeOnCarrier(wanders) - first).norm(), (placeOnCarrier(turns) - before).norm());
}

/// Friction of a belt of 20 m/s under its load against μ m g, and the load's speed against the mean friction's impulse μ g t, from when it
/// has stopped rocking to 2.5 s; and then that with which it rides.
double beltError(Attempts attempts) {
  const Load load;
  const double speed = 20, force = load.mu * load.mass * kGravity;
  World world(onBelt(load, settingsOf(attempts), speed));
  while (world.time() < 1.5) world.step();
  const double v0 = world.linkTwist(1).linear.x(), t0 = world.time();
  double worst = 0;
  while (world.time() < 2.5) {
    world.step();
    worst = std::max({worst, std::abs(world.contact(0).F_BP_W.force.x() / force - 1), std::abs(world.contact(0).F_BP_W.force.y()) / force});
  }
  worst = std::max(worst, std::abs((world.linkTwist(1).linear.x() - v0) / (load.mu * kGravity * (world.time() - t0)) - 1));
  while (world.time() < 10) world.step();
  return std::max(worst, std::abs(world.linkTwist(1).linear.x() / speed - 1));
}

/// A platform on a path, one that is told its poses, a belt, a pendulum and loads on all.
WorldDef everything() {
  WorldDef def = onCarrier(Load{}, WorldSettings{}, wandering(2, 0.05), 0.05, true);
  const auto beside = [](ArticulationDef body, double y) {
    body.X_WA.p.y() += y;
    return body;
  };
  const WorldDef told = onCarrier(Load{}, WorldSettings{}, {}, 0), belt = onBelt(Load{}, WorldSettings{}, 0.4, 8);
  def.articulations.push_back(beside(told.articulations[0], 4));
  def.articulations.push_back(beside(told.articulations[1], 4));
  def.articulations.push_back(beside(belt.articulations[0], 8));
  def.articulations.push_back(beside(belt.articulations[1], 8));
  MotionDef motion;
  motion.name = "told";
  motion.articulation = 2, motion.link = 0;
  def.motions.push_back(motion);
  ArticulationDef pendulum = freeBox("pendulum", Vector3(0.05, 0.05, 0.4), 0.5, Pose(Vector3(0, -4, 2)));
  pendulum.links[0].joint.type = JointType::kRevolute;
  pendulum.links[0].joint.axis = Vector3::UnitY();
  pendulum.links[0].inertia.p_LC = Vector3(0.05, 0, -0.2);
  def.articulations.push_back(pendulum);
  return def;
}

/// Ticks of a session with every command of this kind whose hash its replay does not have.
int replayMismatches() {
  const WorldDef def = everything();
  SessionStart start;
  World world(def);
  HapticLoop loop(world);
  start.world_state = world.save();
  start.world_tuning = world.tuning().numbers();
  SessionReplay replay(def, start);
  int mismatches = 0;
  std::uint64_t tick = 0;
  const auto run = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) {
      TickInput input;
      input.tick = tick++;
      loop.tick(input, world.settings().step);
      TickHash live;
      hashTick(loop, live);
      mismatches += !(replay.tick(input) == live);
    }
  };
  const auto tell = [&](const LoopCommand::Kind& kind) {
    const LoopCommand command{kind};
    const LoopCommand recorded = commandFrom(command.kind.index(), 0, numbersOf(command));  // as a bag gives it back
    loop.take(command);
    replay.apply(recorded);
  };
  run(200);
  for (int round = 0; round < 5; ++round) {
    const double more = 0.1 * round;
    const Quaternion turn(rotationAbout(Vector3::UnitZ(), more));
    tell(LeadBody{1, {Vector3(0.05 * round, 4, more), turn, {Vector3(0, 0, 0.3), Vector3(0.1, 0, 0)}}, 0.3});
    run(100);
    tell(ApplyWrench{1, {{Vector3(0, 0, 0.2), Vector3(1, 2, 3)}, Vector3(0.02, 0, 0), round % 2 == 0}, 0.15});
    tell(ApplyWrench{6, {{Vector3(0, more, 0), Vector3(1, 0, 0)}, Vector3(0, 0, -0.4), false}, 0.05});
    run(100);
    WorldTuning tuning = world.tuning();
    tuning.gravity = Vector3(more, 0, -9.8 + more);
    tell(TuneWorld{tuning});
    run(100);
    tell(PauseWorld{true});
    tell(PutBody{5, Pose(rotationAbout(Vector3::UnitZ(), more), Vector3(more, 8, 0.0199)), {Vector3(0, 0, more), Vector3(0, 0, 0.1)}});
    tell(PutJoints{{{0, 0.2 * round}}});
    run(5);
    tell(StepWorld{});
    tell(PauseWorld{false});
    run(200);
    WorldDef next = def;
    std::vector<int> kept = {0, 1, 2, 3, 4, 5, 6};
    if (round % 2 == 0) {
      next.articulations.push_back(freeBox("late", Load{}.size, 1, Pose(Vector3(0.6, 0.4, 0.3 + more))));
      kept.push_back(-1);
    }
    ChangeBodies change;
    *change.packed = packBodies(next, kept);
    tell(change);
    run(200);
  }
  return mismatches;
}

/// Processor time [s] that each of the three ticks takes longer in which the way is rehearsed and a cube comes or goes than the same tick
/// without, 40 times, in two loops side by side over 30 cubes; the next world is compiled in a thread of its own while the loop goes on.
std::vector<double> addedBySpawning() {
  CubeParameters c;
  WorldDef def = stack(10, c, WorldSettings{});
  for (int i = 0; i < 20; ++i) {
    const Vector3 place(0.2 * (i % 5) - 0.4, 0.3 + 0.2 * (i / 5), c.size / 2 - c.restDepth());
    def.articulations.push_back(cube("beside" + std::to_string(i), c, Pose(place)));
  }
  WorldDef more = def;
  more.articulations.push_back(cube("late", c, Pose(Vector3(-0.5, -0.5, 0.1))));
  std::vector<int> kept;
  for (int i = 0; i < static_cast<int>(def.articulations.size()); ++i) kept.push_back(i);
  World world(def), same(def);
  HapticLoop loop(world), beside(same);
  const double h = world.settings().step;
  TickInput input;
  const auto tick = [&](HapticLoop& one) { one.tick(input, h); };
  for (int i = 0; i < 300; ++i) tick(loop), tick(beside);
  std::vector<double> added;
  for (int round = 0; round < 40; ++round) {
    const bool comes = round % 2 == 0;
    ChangeBodies change;
    *change.packed = packBodies(comes ? more : def, kept);
    std::atomic<bool> made{false};
    std::thread maker([&] {
      change.next = std::make_shared<NextWorld>(world, comes ? more : def, kept);
      made = true;
    });
    while (!made) tick(loop), tick(beside);
    maker.join();
    const LoopCommand command{change};
    const auto longer = [&](const auto& work) {
      const double start = cpuSeconds();
      work();
      tick(loop);
      const double middle = cpuSeconds();
      tick(beside);
      added.push_back((middle - start) - (cpuSeconds() - middle));
    };
    longer([&] { world.rehearse(*change.next, false); });
    longer([&] { world.rehearse(*change.next, true); });
    longer([&] { loop.take(command); });
    for (int i = 0; i < 50; ++i) tick(loop), tick(beside);
  }
  return added;
}

/// The same ticks several times, each with its median: an interrupt of the machine falls into one of them.
std::vector<double> addedInEachTick() {
  constexpr int kRuns = 5;
  std::vector<std::vector<double>> runs;
  for (int i = 0; i < kRuns; ++i) runs.push_back(addedBySpawning());
  std::vector<double> added;
  for (std::size_t tick = 0; tick < runs[0].size(); ++tick) {
    std::vector<double> times;
    for (const std::vector<double>& run : runs) times.push_back(run[tick]);
    added.push_back(median(times));
  }
  return added;
}

}  // namespace

void measureActors() {
  double response = 0, slip = 0, belt = 0;
  for (const Attempts attempts : kAll) {
    response = std::max(response, responseError(attempts));
    slip = std::max(slip, slipWhenCarried(attempts));
    belt = std::max(belt, beltError(attempts));
  }
  figure("wrench.response_err_rel", response, "1");
  figure("kinematic.carry_um", 1e6 * slip, "um");
  figure("kinematic.conveyor_err_rel", belt, "1");
  const std::vector<double> added = addedInEachTick();
  figure("spawn.tick_us_added_median", 1e6 * median(added), "us");
  figure("spawn.tick_us_added_max", 1e6 * *std::max_element(added.begin(), added.end()), "us");
  figure("replay.mismatches", replayMismatches(), "1");
}

}  // namespace haptic::bench
