// The loop between twin and world: how long a tick takes at 1 and 10 kHz, what recording and drawing add, how stiff a
// wall may be, how passive the port stays, the gear experiment, and every scene run again bit for bit.
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "figure.h"
#include "haptic_core/base/record_ring.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/loop/ports.h"
#include "haptic_core/loop/realtime.h"
#include "loop_rig.h"

namespace haptic::bench {
namespace {

double percentileOf(std::vector<double>& values, double p) {
  const auto rank = static_cast<std::size_t>(p * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank), values.end());
  return values[rank];
}

struct Times {
  std::vector<double> tick_us;  ///< exchange with the twin and HapticLoop::tick
  std::vector<double> late_us;  ///< start after the deadline; empty: not paced
};

/// Runs a rig flat out, or paced by the clock as the bridge does.
Times timeTicks(Rig& rig, int count, bool paced) {
  Times times;
  times.tick_us.reserve(static_cast<std::size_t>(count));
  PeriodicWake wake(1 / rig.step);
  if (paced) wake.start();
  for (int i = 0; i < count; ++i) {
    if (paced) times.late_us.push_back(1e-3 * static_cast<double>(wake.wait().lateness_ns));
    const std::int64_t before = steadyNow();
    rig.exchange();
    rig.tick();
    times.tick_us.push_back(1e-3 * static_cast<double>(steadyNow() - before));
  }
  return times;
}

double shareAbove(const std::vector<double>& values, double limit) {
  std::size_t above = 0;
  for (const double value : values) above += value > limit;
  return values.empty() ? std::nan("") : 100.0 * static_cast<double>(above) / static_cast<double>(values.size());
}

void measureSpeed() {
  Rig slow(sceneNamed("touch_cube", 1000), {});
  Times flat_1k = timeTicks(slow, 10000, false), at_1k = timeTicks(slow, 10000, true);
  figure("loop.tick_us_p50_1k", percentileOf(at_1k.tick_us, 0.5), "us");
  figure("loop.tick_us_p50_1k_flat", percentileOf(flat_1k.tick_us, 0.5), "us");
  RigSettings fast_settings;
  fast_settings.rate = 10000;
  Rig fast(sceneNamed("touch_cube", 10000), fast_settings);
  Times flat_10k = timeTicks(fast, 50000, false), at_10k = timeTicks(fast, 50000, true);
  const double missed = shareAbove(at_10k.tick_us, 100);
  figure("loop.tick_us_p50_10k", percentileOf(at_10k.tick_us, 0.5), "us");
  figure("loop.tick_us_p99_10k", percentileOf(at_10k.tick_us, 0.99), "us");
  figure("loop.tick_us_p99_10k_round", percentileOf(at_10k.tick_us, 0.99), "us");  // the scene's pointer is a true ball
  figure("loop.compute_missed_pct_10k", missed, "%");
  figure("loop.late_pct_10k", shareAbove(at_10k.late_us, 100), "%");
  figure("loop.tick_us_p50_10k_flat", percentileOf(flat_10k.tick_us, 0.5), "us");
  figure("loop.tick_us_p99_10k_flat", percentileOf(flat_10k.tick_us, 0.99), "us");
  figure("loop.compute_missed_pct_10k_flat", shareAbove(flat_10k.tick_us, 100), "%");
}

void measureTwoHands() {
  Rig rig(sceneNamed("d_two_hands", 1000), {});
  Times flat = timeTicks(rig, 10000, false), times = timeTicks(rig, 10000, true);
  figure("hands2.tick_us_p50", percentileOf(times.tick_us, 0.5), "us");
  figure("hands2.tick_us_p50_flat", percentileOf(flat.tick_us, 0.5), "us");
}

/// Every scene: does its median tick fit 10 kHz (three of four ticks' periods are not needed then), and does a
/// recording of it run again bit for bit.
void measureScenes() {
  int at_10k = 0, scenes = 0;
  std::uint64_t steps = 0, mismatches = 0;
  double simulated = 0, seconds = 0;
  for (const std::string& file : loadableScenes()) {
    ++scenes;
    SceneDef scene = loadScene(file);
    const std::string name = scene.world.name;
    {
      RigSettings settings;
      settings.rate = 10000;
      scene.world.settings.step = 1e-4;
      Rig rig(scene, settings);
      Times times = timeTicks(rig, 15000, false);
      const double missed = shareAbove(times.tick_us, 100);
      std::printf("scene %-16s at 10 kHz: median %6.1f us, p99 %6.1f us, %.2f %% over the period\n", name.c_str(),
                  percentileOf(times.tick_us, 0.5), percentileOf(times.tick_us, 0.99), missed);
      at_10k += missed <= 0.1 && rig.world.report().finite;
    }
    scene = loadScene(file);
    scene.world.settings.step = 1e-3;
    Rig rig(scene, {});
    const SessionStart start = rig.start();
    std::vector<TickInput> inputs;
    std::vector<LoopEvent> events;
    std::vector<TickHash> hashes;
    for (int i = 0; i < 3000; ++i) rig.recordedTick(inputs, events, hashes);
    SessionReplay replay(scene.world, start);
    const auto begin = std::chrono::steady_clock::now();
    std::size_t event = 0;
    std::uint64_t different = 0;
    for (std::size_t t = 0; t < inputs.size(); ++t) {
      while (event < events.size() && events[event].tick <= inputs[t].tick) replay.apply(events[event++].command);
      different += !(replay.tick(inputs[t]) == hashes[t]);
    }
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    simulated += 1e-3 * static_cast<double>(inputs.size());
    steps += inputs.size();
    mismatches += different;
    if (different > 0) std::printf("scene %s: %g ticks differ when run again\n", name.c_str(), static_cast<double>(different));
  }
  figure("loop.scenes", scenes, "1");
  figure("loop.scenes_at_10k", at_10k, "1");
  figure("replay.steps", static_cast<double>(steps), "1");
  figure("replay.mismatches", static_cast<double>(mismatches), "1");
  figure("replay.speedup", simulated / seconds, "1");
}

struct KeptTick {
  std::uint64_t tick;
  std::array<DeviceSample, kMaxHands> sample;
  TickHash hash;
};

/// What the loop's thread does per tick, with an extra: none, a recording, or somebody who looks at 30 Hz. Run under
/// callgrind by `instructions`.
void runForCounting(const std::string& extra, int ticks) {
  Rig rig(sceneNamed("touch_cube", 1000), {});
  RecordRing<KeptTick> ring(static_cast<std::size_t>(ticks));  // has room for all: another thread empties it in production
  WorldPort port(rig.world, "touch_cube", {}, 64);
  WorldSnapshot snapshot = port.first_snapshot;
  KeptTick kept;
  for (int i = 0; i < ticks; ++i) {
    rig.exchange();
    rig.tick();
    // The loop hands every tick on, whether or not it is kept (haptic_bridge/loop_session.cpp, realtime_thread.cpp).
    kept.tick = static_cast<std::uint64_t>(i);
    kept.sample = rig.samples;
    if (extra == "record") hashTick(*rig.loop, kept.hash);
    ring.push(kept);
    if (extra == "rviz" && i % 33 == 0) {
      port.commands.send(WorldPort::Look{&snapshot}, std::chrono::milliseconds(0), [&port] { port.serve(); });
    }
  }
}

/// Instructions of this program running `runForCounting`; NaN when valgrind is not there or cannot run this build.
double instructions(const std::string& extra, int ticks) {
  const std::string out = "/tmp/haptic_loop_" + std::to_string(getpid()) + "_" + extra;
  const std::string command = "valgrind --tool=callgrind --callgrind-out-file=" + out + " /proc/" +
                              std::to_string(getpid()) + "/exe --count " + extra + " " + std::to_string(ticks) + " >" +
                              out + ".log 2>&1";
  double total = std::nan("");
  if (std::system(command.c_str()) == 0) {
    std::ifstream file(out);
    for (std::string line; std::getline(file, line);) {
      if (line.rfind("summary:", 0) == 0 || line.rfind("totals:", 0) == 0) total = std::atof(line.c_str() + line.find(':') + 1);
    }
  }
  std::remove(out.c_str());
  std::remove((out + ".log").c_str());
  return total;
}

/// Differences of two lengths of run, so that loading the scene does not count.
void measureCosts() {
  const int few = 1000, many = 4000;
  const auto perTick = [&](const std::string& extra) { return (instructions(extra, many) - instructions(extra, few)) / (many - few); };
  const double plain = perTick("none");
  if (std::isnan(plain)) {
    std::printf("costs of recording and drawing: valgrind does not run this build; see the build for any x86-64\n");
    return;
  }
  std::printf("a tick of touch_cube: %.0f instructions\n", plain);
  figure("record.loop_cost_pct", 100 * (perTick("record") / plain - 1), "%");
  figure("rviz.subscribed_cost_pct", 100 * (perTick("rviz") / plain - 1), "%");
}

}  // namespace
}  // namespace haptic::bench

int main(int argc, char** argv) {
  using namespace haptic::bench;
  if (argc == 4 && std::strcmp(argv[1], "--count") == 0) {
    runForCounting(argv[2], std::atoi(argv[3]));
    return 0;
  }
  const std::string only = argc > 1 ? argv[1] : "";
  const auto wanted = [&](const char* part) { return only.empty() || only == part; };
  if (wanted("speed")) measureSpeed();
  if (wanted("two_hands")) measureTwoHands();
  if (wanted("stability")) measureStability();
  if (wanted("gear")) measureGear();
  if (wanted("scenes")) measureScenes();
  if (wanted("costs")) measureCosts();
  return 0;
}
