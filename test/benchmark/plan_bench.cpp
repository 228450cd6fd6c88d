/// `./run bench plan`: each scene of the catalogue by its plan and by the general pipeline, which leaves nothing out:
/// the same bits, and what leaving out saves. Then what features cost that a scene does not use, and topics that nobody
/// reads. `--csv` prints one line per scene for the report instead of a table.
#include <dirent.h>
#include <cstdio>
#include <cstring>
#include <memory>
#include <sstream>

#include "../comparators/velocity_verlet.h"
#include "../scenes/circling_hands.h"
#include "../scenes/motions.h"
#include "figure.h"
#include "haptic_core/base/cpu_time.h"
#include "haptic_core/base/error.h"
#include "haptic_core/loop/ports.h"
#include "single_stepping.h"
#include "scene/scene_file.h"

namespace haptic::bench {
namespace {

struct Scene {
  std::string name;
  WorldDef def;
};

/// All files of urdf/scenes that load on this system, by name, or `only` one; the others are named with the reason.
std::vector<Scene> catalogue(const char* only) {
  const std::string folder = HAPTIC_SOURCE_DIR "/urdf/scenes";
  std::vector<std::string> files;
  if (DIR* dir = opendir(folder.c_str())) {
    while (const dirent* entry = readdir(dir)) {
      const std::string file = entry->d_name;
      const std::size_t dot = file.rfind('.');
      if (dot == std::string::npos || (file.substr(dot) != ".urdf" && file.substr(dot) != ".yaml")) continue;
      if (!only || file == only) files.push_back(file);
    }
    closedir(dir);
  }
  std::sort(files.begin(), files.end());
  std::vector<Scene> scenes;
  for (const std::string& file : files) {
    try {
      Scene scene{file, loadScene(folder + "/" + file).world};
      const World world(scene.def);  // a scene whose world is refused has no plan
      scenes.push_back(std::move(scene));
    } catch (const SetupError& error) {
      std::printf("skipped %s: %s\n", file.c_str(), error.what());
    }
  }
  return scenes;
}

struct Comparison {
  bool identical = true;
  long planned_instructions = -1, general_instructions = -1;  ///< of one step; -1: not counted
  double planned_s = 0, speedup = 0;                        ///< median step [s]; median of paired ratios
};

/// `counts`: instructions too, which takes seconds a scene.
Comparison compare(const Scene& scene, bool counts) {
  constexpr int kSteps = 300, kPairs = 41;
  constexpr double kCountable = 1e-4;  ///< [s] of a step: counting one by one then lasts 3 s; longer ones are not counted
  WorldDef planned_def = scene.def, general_def = scene.def;
  planned_def.settings.leave_out = true;
  general_def.settings.leave_out = false;
  World planned(planned_def), general(general_def);
  const scenes::CirclingHands hands(planned);
  Comparison result;
  const auto advance = [&](World& world, int steps) {
    for (int i = 0; i < steps; ++i) {
      hands.move(world);
      world.step();
    }
  };
  for (int i = 0; i < kSteps && result.identical; ++i) {
    advance(planned, 1);
    advance(general, 1);
    result.identical = planned.hash() == general.hash();
  }
  const auto timed = [&](World& world, int steps) {
    const double start = cpuSeconds();
    advance(world, steps);
    return (cpuSeconds() - start) / steps;
  };
  // Blocks of about half a millisecond, long against the clock, alternating.
  const int steps = std::clamp(static_cast<int>(5e-4 / std::max(1e-7, timed(planned, 4))), 2, 500);
  advance(general, 4);
  std::vector<double> ratios, times;
  for (int i = 0; i < kPairs; ++i) {
    const bool first = i % 2 == 0;
    const double a = timed(first ? planned : general, steps), b = timed(first ? general : planned, steps);
    times.push_back(first ? a : b);
    ratios.push_back(first ? b / a : a / b);
  }
  result.planned_s = median(times);
  if (counts && result.planned_s < kCountable) {
    result.planned_instructions = singleStepped([&] { advance(planned, 1); });
    result.general_instructions = singleStepped([&] { advance(general, 1); });
  }
  result.speedup = median(ratios);
  return result;
}

/// The lines of the plan that say what was left out, as one.
std::string leftOut(const WorldDef& def) {
  std::istringstream text(World(def).planText());
  std::string line, all;
  while (std::getline(text, line)) {
    const std::size_t at = line.find("left out ");
    if (at == std::string::npos) continue;
    all += (all.empty() ? "" : "; ") + line.substr(at + 9);
  }
  return all;
}

void plans(bool csv, const char* only) {
  int scenes = 0, identical = 0;
  double slowest = 1e9, sum = 0;
  if (csv) std::printf("scene,bit_identical,planned_instructions,general_instructions,step_us,speedup,left_out\n");
  for (const Scene& scene : catalogue(only)) {
    const Comparison c = compare(scene, csv);
    const std::string left_out = leftOut(scene.def);
    if (csv) {
      std::printf("%s,%d,%ld,%ld,%.4g,%.4g,\"%s\"\n", scene.name.c_str(), c.identical, c.planned_instructions,
                  c.general_instructions, 1e6 * c.planned_s, c.speedup, left_out.c_str());
    } else {
      std::printf("%-22s same bits %d  step %8.3f us  speed-up %.3f  left out: %s\n", scene.name.c_str(), c.identical,
                  1e6 * c.planned_s, c.speedup, left_out.c_str());
    }
    std::fflush(stdout);
    ++scenes;
    identical += c.identical;
    slowest = std::min(slowest, c.speedup);
    sum += c.speedup;
  }
  if (csv) return;
  figure("plan.scenes", scenes, "scenes");
  figure("plan.bit_identical", identical, "scenes");
  figure("plan.bits_differ", scenes - identical, "scenes");
  figure("plan.speedup_min", slowest, "1");
  figure("plan.speedup_mean", sum / scenes, "1");
}

/// What a scene may have and not use. Each is added alone; the step must do the same, for the same price.
struct IdleFeature {
  const char* name;
  void (*add)(WorldDef& def);
};

void addHandWithoutTarget(WorldDef& def) {
  PointerDef hand;
  hand.device = "idle";
  hand.articulation = static_cast<int>(def.articulations.size()) - 1;
  hand.link = static_cast<int>(def.articulations.back().links.size()) - 1;
  hand.coupling.mode = PointerCoupling::Mode::kVirtual;
  def.pointers.push_back(hand);
}

void addFarFloor(WorldDef& def) {
  def.articulations.push_back(
      scenes::staticBox("far floor", Vector3(1, 1, 0.1), Pose(Vector3(0, 0, -100))));
}

void addFarFilter(WorldDef& def) {
  addFarFloor(def);
  const int far = static_cast<int>(def.articulations.size()) - 1;
  def.filters.push_back({far, 0, far - 1, 0});
}

void addMergedLink(WorldDef& def) {
  MergedLink frame;
  frame.name = "a frame";
  def.articulations.back().links.back().merged.push_back(frame);
}

/// Instructions of one step once the contacts have settled and no first call is left.
long settledStep(const WorldDef& def, std::vector<double>& end) {
  constexpr int kWarmUp = 200;
  World world(def);
  for (int i = 0; i < kWarmUp; ++i) world.step();
  for (int l = 0; l < world.linkCount(); ++l) {
    const Pose X = world.linkPose(l);
    end.insert(end.end(), X.p.data(), X.p.data() + 3);
  }
  return singleStepped([&] { world.step(); });
}

void idleFeatures() {
  constexpr IdleFeature kFeatures[] = {{"a hand without target", addHandWithoutTarget},
                                       {"a body that is far away", addFarFloor},
                                       {"a collision filter", addFarFilter},
                                       {"a merged link", addMergedLink}};
  const std::string scenes_folder = HAPTIC_SOURCE_DIR "/urdf/scenes/";
  WorldSettings settings;
  settings.step = 0.25e-3;
  WorldSettings verlet = settings;
  verlet.comparator = comparators::velocityVerlet;
  WorldDef robot = loadScene(scenes_folder + "panda_touch.yaml").world;
  robot.pointers.clear();
  const Scene bases[] = {{"cube", scenes::cubeOnFloor(scenes::CubeParameters{}, settings)},
                         {"cube, verlet", scenes::cubeOnFloor(scenes::CubeParameters{}, verlet)},
                         {"stack", scenes::stack(15, scenes::CubeParameters{}, settings)},
                         {"chain", loadScene(scenes_folder + "chain.urdf").world},
                         {"robot", robot}};
  double worst = 0;
  for (const Scene& base : bases) {
    std::vector<double> plain_end;
    const long plain = settledStep(base.def, plain_end);
    for (const IdleFeature& feature : kFeatures) {
      WorldDef with = base.def;
      feature.add(with);
      std::vector<double> end;
      const long cost = settledStep(with, end);
      const bool same = std::equal(plain_end.begin(), plain_end.end(), end.begin());
      const double pct = 100 * (double(cost) / double(plain) - 1);
      std::printf("%-13s a step takes %8ld instructions, with %-24s %+.2f %%, same poses %d\n", base.name.c_str(), plain,
                  feature.name, pct, same);
      std::fflush(stdout);
      worst = same && plain > 0 && cost > 0 ? std::max(worst, pct) : std::nan("");
      if (std::isnan(worst)) break;
    }
    if (std::isnan(worst)) break;
  }
  figure("plan.idle_feature_cost_pct", worst, "%");
}

/// What the thread that steps the world does for topics in each tick: `step_report`, `contacts`, `markers` and tf are made
/// from snapshots in a thread of their own, which sends a command only when it wants one.
void unsubscribedTopics() {
  WorldDef def = scenes::stack(5, scenes::CubeParameters{}, WorldSettings{});
  World world(def);
  WorldPort port(world, "stack", {}, 64);
  const auto step = [&](bool topics) {
    world.step();
    port.serve([](const LoopCommand&) {});  // whoever may send: services above all
    if (topics) port.noteTick(0);
  };
  for (int i = 0; i < 200; ++i) step(true);  // here, not in the process that is counted: first calls bind
  const auto tick = [&](bool topics) { return singleStepped([&] { step(topics); }); };
  const long with = tick(true), without = tick(false);
  std::printf("topics in a tick: %ld instructions of %ld while nobody asks\n", with - without, with);
  // The tick's stamp, the test whether stages are timed, the call, and the lambda's flag: a check. More would be work.
  constexpr long kCheck = 8;
  figure("plan.unsubscribed_topic_check", double(with - without), "instructions");
  figure("plan.unsubscribed_topic_instructions", with < 0 ? std::nan("") : double(std::max(0L, with - without - kCheck)),
         "instructions");
}

}  // namespace
}  // namespace haptic::bench

int main(int argc, char** argv) {
  using namespace haptic::bench;
  const bool csv = argc > 1 && std::strcmp(argv[1], "--csv") == 0;
  plans(csv, csv && argc > 2 ? argv[2] : nullptr);
  if (csv) return 0;
  idleFeatures();
  unsubscribedTopics();
}
