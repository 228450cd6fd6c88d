/// The budget of a step against the certificate: a hand at 5 kHz that strikes a stiff cube, 10⁷ ticks.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "../scenes/stacks.h"
#include "figure.h"
#include "haptic_core/analysis/deadline.h"
#include "haptic_core/base/cpu_time.h"
#include "haptic_core/world/world.h"
#include "islands_scenes.h"
#include "loop_rig.h"
#include "scene/hand_on_path.h"
#include "scene/scene_file.h"

namespace haptic::bench {
namespace {

using namespace scenes;

constexpr double kStep = 2e-4;  ///< [s]
constexpr double kPath = 5;  ///< in which a hand of a shipped scene has touched what it is there for [s]
constexpr long kTicks = 10'000'000, kReturns = 50'000;  // the world starts again after so many: what was hit flies away
constexpr long kCold = 10;                               // ticks after that, in which memory comes back into the caches

StackParameters one() {
  StackParameters p;
  p.count = 1, p.height = 1, p.hand = true;
  return p;
}

CubeParameters stiffCube() {
  CubeParameters c;
  c.stiffness = 1e10;
  return c;
}

/// Presses, pushes and strikes at up to 0.5 m/s, never twice the same way.
void strike(World& world) {
  const double t = world.time();
  const Vector3 way(0.05 * std::sin(5 * t), 0.05 * std::sin(3.1 * t), -0.02 + 0.03 * std::sin(11 * t));
  world.setPointerTarget(0, Pose(Vector3(handStart(one(), stiffCube()) + way)), Twist{});
}

}  // namespace

double fixedWork() {
  double x = 1;
  for (int i = 0; i < 1000; ++i) x = std::sqrt(x + i);
  return x;
}

void measureDeadline() {
  WorldSettings settings;
  settings.step = kStep, settings.history_steps = 0;
  const WorldDef def = stacks(one(), stiffCube(), settings);
  const DeadlineReport report = certifyDeadline(def, kShareOfTick * kStep, 2, strike);
  std::printf("%s\n", report.text().c_str());
  World world(def);
  const std::vector<double> start = world.save();
  WorldTuning tuning = world.tuning();
  tuning.budget = report.kept() ? report.budget : 1;
  world.tune(tuning);
  const double bound = tuning.budget + leastWork(world);
  long violations = 0, late = 0, gave_way = 0, unconverged = 0, late_fixed = 0;
  double seen = 0, worst = 0, sum = 0;
  for (long i = 0; i < kTicks; ++i) {
    if (i % kReturns == 0) world.restore(start);
    strike(world);
    const double before = cpuSeconds();
    world.step();
    const double cpu = cpuSeconds() - before, work = world.report().work;
    violations += work > bound;
    late += cpu > kStep && i % kReturns >= kCold;
    const double begun = cpuSeconds();
    sum += fixedWork();
    late_fixed += cpuSeconds() - begun > kStep;
    gave_way += (world.report().flags & kGaveWay) != 0;
    unconverged += (world.report().flags & kNotConverged) != 0;
    seen = std::max(seen, work), worst = std::max(worst, cpu);
  }
  figure("deadline.budget", tuning.budget, "units");
  figure("deadline.least", bound - tuning.budget, "units");
  figure("deadline.seen", seen, "units");
  figure("deadline.ns_per_unit", 1e9 * report.seconds_per_unit, "ns");
  figure("deadline.violations", static_cast<double>(violations), "ticks");
  figure("deadline.late_share", static_cast<double>(late) / static_cast<double>(kTicks), "1");
  if (!std::isfinite(sum)) std::printf("the fixed work is not finite\n");  // it has to be done
  figure("deadline.late_share_of_fixed_work", static_cast<double>(late_fixed) / static_cast<double>(kTicks), "1");
  figure("deadline.bound_over_seen", bound / seen, "1");
  figure("deadline.gave_way_share", static_cast<double>(gave_way) / static_cast<double>(kTicks), "1");
  figure("deadline.unconverged_share", static_cast<double>(unconverged) / static_cast<double>(kTicks), "1");
  figure("deadline.tick_us_worst", 1e6 * worst, "us");
}

void measureUnits() {
  double least = 1e9, most = 0;
  for (const std::string& file : loadableScenes()) {
    const SceneDef scene = loadScene(file);
    const auto drive = [&](World& world) { followPaths(scene, world); };
    const DeadlineReport report = certifyDeadline(scene.world, kShareOfTick * scene.world.settings.step, kPath, drive);
    if (report.steps == 0) continue;
    const double ns = 1e9 * report.seconds_per_unit;
    std::printf("%-18s %7.2f ns a unit  seen %9.0f  least %9.0f units  %s\n", scene.world.name.c_str(), ns, report.seen, report.least,
                report.kept() ? "kept" : "not certain");
    std::fflush(stdout);
    least = std::min(least, ns), most = std::max(most, ns);
  }
  figure("deadline.ns_per_unit_least", least, "ns");
  figure("deadline.ns_per_unit_most", most, "ns");
}

}  // namespace haptic::bench
