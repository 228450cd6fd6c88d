/// A box of 3 cm in a hand goes down into a heap and through it: the peak of the force on the hand, beside implicit Euler's at h/16.
///
/// The heap (test/scenes/heap.h) falls for a second and a half first. The hand prescribes the box's motion, as stiff as it is: no
/// bound of a device. Force: mean over a tick. Ticks in which contacts begin at more than a fall's speed, and those after them, are
/// impacts and do not count, in either run.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "../scenes/heap.h"
#include "figure.h"
#include "haptic_core/base/cpu_time.h"
#include "step_figures.h"

namespace haptic::bench {
namespace {

constexpr double kStep = 1e-3, kSettle = 1.5;  ///< [s]
constexpr int kFine = 16;
/// Edge; heights of the box's centre before it goes down and while it goes across; room that it leaves before the far wall [m]. A cube
/// fits under it and before the wall: what is squeezed between prescribed motions gets any force.
constexpr double kBox = 0.03, kAbove = 0.35, kDeep = 0.075, kRoom = 0.07;
constexpr std::pair<const char*, double> kStiffness[] = {{"k1e7", 1e7}, {"k1e8", 1e8}, {"k1e10", 1e10}};

struct Plough {
  int count;
  double stiffness, speed;
  double from() const { return -0.5 * ((count <= 10 ? 2 : 4) * 0.075 + 0.02) + kBox; }  ///< x at which it goes down [m]
  double seconds() const { return (kAbove - kDeep - 2 * from() - kRoom) / speed; }

  WorldDef scene(Attempts attempts, double step) const {
    scenes::HeapParameters heap;
    heap.count = count;
    heap.stiffness = stiffness;
    WorldSettings settings;
    settings.attempts = attempts;
    settings.step = step;
    WorldDef def = scenes::heap(heap, settings);
    def.articulations.push_back(scenes::freeBox("hand", Vector3::Constant(kBox), 0.1, Pose(Vector3(from(), 0, kAbove))));
    PointerDef hand;
    hand.articulation = static_cast<int>(def.articulations.size()) - 1;
    hand.link = 0;
    def.pointers.push_back(hand);
    return def;
  }

  /// Down, then across.
  void aim(World& world) const {
    const double way = speed * std::max(0.0, world.time() + world.settings().step - kSettle);
    const double down = std::min(way, kAbove - kDeep);
    const bool sinks = way < kAbove - kDeep;
    Twist V;
    if (world.time() >= kSettle) V.linear = speed * (sinks ? Vector3(0, 0, -1) : Vector3(1, 0, 0));
    world.setPointerTarget(0, Pose(Vector3(from() + way - down, 0, kAbove - down)), V);
  }
};

struct Run {
  double peak = 0;           ///< outside impacts [N]
  double largest = 0;        ///< of all ticks [N]
  std::vector<double> us;    ///< of the ticks with the hand on its way
  int unconverged = 0;
};

Run run(const Plough& plough, Attempts attempts, int fine) {
  World world(plough.scene(attempts, kStep / fine));
  Run out;
  int since_impact = 0;
  const int settle = static_cast<int>(std::lround(kSettle / kStep)), ticks = static_cast<int>(plough.seconds() / kStep);
  for (int i = 0; i < settle + ticks; ++i) {
    Vector3 F = Vector3::Zero();
    double us = 0;
    bool impact = false, open = false;
    for (int j = 0; j < fine; ++j) {
      plough.aim(world);
      const double before = 1e6 * cpuSeconds();
      world.step();
      us += 1e6 * cpuSeconds() - before;
      F += world.pointerWrench(0).force / fine;
      impact |= world.report().impact > 0;
      open |= (world.report().flags & kNotConverged) != 0;
    }
    if (i < settle) continue;
    since_impact = impact ? 0 : since_impact + 1;
    out.us.push_back(us);
    out.unconverged += open;
    out.largest = std::max(out.largest, F.norm());
    if (since_impact > 1) out.peak = std::max(out.peak, F.norm());
  }
  std::sort(out.us.begin(), out.us.end());
  return out;
}

}  // namespace

void runPloughs(const char* filter) {
  double ratio = 0, slowest = 0;
  for (const int count : {10, 100}) {
    for (const auto& [label, k] : kStiffness) {
      for (const double speed : {0.1, 0.5}) {
        const Plough plough{count, k, speed};
        const std::string name = "plough.heap" + std::to_string(count) + "." + label + (speed < 0.3 ? ".slow" : ".fast");
        if (filter && name.find(filter) == std::string::npos) continue;
        const Run ours = run(plough, Attempts::kAll, 1), fine = run(plough, Attempts::kImplicitEuler, kFine);
        const double p999 = ours.us[static_cast<std::size_t>(0.999 * static_cast<double>(ours.us.size() - 1))];
        figure(name + ".force_peak_n", ours.peak, "N");
        figure(name + ".fine_force_peak_n", fine.peak, "N");
        figure(name + ".largest_n", ours.largest, "N");
        figure(name + ".fine_largest_n", fine.largest, "N");
        figure(name + ".force_peak_ratio", ours.peak / fine.peak, "1");
        figure(name + ".tick_us_median", ours.us[ours.us.size() / 2], "us");
        figure(name + ".tick_us_p999", p999, "us");
        figure(name + ".unconverged", ours.unconverged, "1");
        ratio = std::max(ratio, ours.peak / fine.peak);
        slowest = std::max(slowest, p999);
      }
    }
  }
  figure("plough.force_peak_ratio", ratio, "1");
  figure("plough.tick_us_p999", slowest, "us");
}

}  // namespace haptic::bench
