/// Every shipped scene with a hand, as it is shipped but for `--rate 10000`: whether a tick holds the period.
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "figure.h"
#include "haptic_core/base/cpu_time.h"
#include "haptic_core/loop/realtime.h"
#include "islands_scenes.h"
#include "loop_rig.h"

namespace haptic::bench {
namespace {

constexpr double kRate = 10000;       // [Hz]
constexpr double kSeconds = 10;       // the twin's hands go their way in this time, once or more
constexpr double kMostMissed = 1e-3;  // share of ticks whose compute time is above the period, in a scene that holds the rate

/// Runs `tick` at the rate; prints its times, and returns the share of ticks that missed the period in CPU time.
template <class Tick>
double missedOf(const std::string& name, Tick&& tick) {
  const auto ticks = static_cast<std::size_t>(kSeconds * kRate);
  std::vector<double> cpu_us;
  cpu_us.reserve(ticks);
  PeriodicWake wake(kRate);
  wake.start();
  while (cpu_us.size() < ticks) {
    wake.wait();
    const double before = cpuSeconds();
    tick();
    cpu_us.push_back(1e6 * (cpuSeconds() - before));
  }
  std::sort(cpu_us.begin(), cpu_us.end());
  const auto at = [&](double share) { return cpu_us[static_cast<std::size_t>(share * static_cast<double>(ticks - 1))]; };
  const auto late = static_cast<double>(cpu_us.end() - std::upper_bound(cpu_us.begin(), cpu_us.end(), 1e6 / kRate));
  const double missed = late / static_cast<double>(ticks);
  std::printf("%-18s %8.1f %8.1f %8.1f %9.3f\n", name.c_str(), at(0.5), at(0.999), cpu_us.back(), 100 * missed);
  std::fflush(stdout);
  return missed;
}

}  // namespace

void measureScenesAt10k() {
  int scenes = 0, held = 0;
  std::printf("%-18s %8s %8s %8s %9s\n", "scene at 10 kHz", "p50_us", "p999_us", "worst_us", "missed_%");
  double sum = 0;
  const double missed_by_fixed_work = missedOf("fixed work", [&sum] { sum += fixedWork(); });
  if (!(sum > 0)) std::printf("the fixed work gives %g\n", sum);  // it has to be done
  for (const std::string& file : loadableScenes()) {
    SceneDef scene = loadScene(file);
    if (scene.world.pointers.empty()) continue;
    RigSettings settings;
    settings.rate = kRate;
    scene.world.settings.step = 1 / kRate;
    Rig rig(scene, settings);
    const double missed = missedOf(scene.world.name, [&rig] {
      rig.exchange();
      rig.tick();
    });
    const bool stopped = !rig.world.report().finite;
    if (stopped) std::printf("%-18s stopped\n", scene.world.name.c_str());
    ++scenes;
    held += missed <= kMostMissed && !stopped;
  }
  figure("scenes_at_10k", held, "scenes");
  figure("scenes_at_10k.of", scenes, "scenes");
  figure("scenes_at_10k.missed_pct_of_fixed_work", 100 * missed_by_fixed_work, "%");
}

}  // namespace haptic::bench
