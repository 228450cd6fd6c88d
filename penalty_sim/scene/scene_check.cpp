/// `scene_check FILE|NAME`: loads a scene, compiles its world, prints what became of it and whether hands can bear it.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <string>
#include <vector>

#include "haptic_core/analysis/deadline.h"
#include "haptic_core/base/error.h"
#include "haptic_core/analysis/hand_certificate.h"
#include "haptic_core/analysis/certificate.h"
#include "haptic_core/loop/hand_trial.h"
#include "haptic_core/world/world.h"
#include "haptic_core/base/program_version.h"
#include "scene/check_report.h"
#include "scene/hand_on_path.h"
#include "scene/progress_watch.h"
#include "scene/scene_file.h"
#include "scene/step_cost.h"

namespace {

constexpr char kUsage[] =
    "usage: scene_check [--default-density KG_PER_M3] [--srdf FILE] [--scenes FOLDER] [--device FILE] [--rate HZ]\n"
    "                   [--missing-meshes box|skip|stop] [--xacro NAME:=VALUE]... [--rigid] [--all] [--json] SCENE|FILE\n"
    "exit code: 0 loaded, 1 loaded with warnings and --strict or a hand that rings, 2 refused or wrong usage\n";

/// Reads a value > 0; false, after a line that says so: it is none.
bool readPositive(const char* option, const char* text, const char* unit, double& value) {
  char* end = nullptr;
  value = std::strtod(text, &end);
  if (*end == '\0' && value > 0 && std::isfinite(value)) return true;
  std::fprintf(stderr, "scene_check: %s '%s' is not a number > 0 in %s\n", option, text, unit);
  return false;
}

/// Presses a hand's pointer to the workspace's end through the whole loop and tells how that went; false: it rings.
bool passes(const haptic::SceneDef& scene, const haptic::HandDef& hand, const haptic::DeviceDef& device,
            std::vector<std::string>& told) {
  haptic::HandSettings settings;
  settings.workspace = hand.workspace;
  settings.force_scale = hand.force_scale;
  settings.delay = hand.delay;
  const haptic::TrialResult worst = haptic::pressHand(scene.world, hand.pointer, settings, device);
  char line[240];
  std::snprintf(line, sizeof line,
                "hand of %s pressed to the workspace's end: %s, at most %.3g N; between ticks the force changes by %.0f N/m times the "
                "way and %.2g N",
                hand.device.substr(0, 60).c_str(), worst.steady() ? "PASS" : worst.rings ? "RINGS" : "NOT FINITE", worst.strongest,
                worst.stiffness, std::max(0.0, worst.jump));
  told.push_back(line);
  return worst.steady();
}

/// Whether a tick of the scene's step keeps its deadline, its hands on their paths.
haptic::DeadlineReport deadlineOf(const haptic::SceneDef& scene) {
  double seconds = 1;  // simulated; paths have touched their bodies within 10 s
  for (const haptic::HandDef& hand : scene.hands) seconds = std::clamp(hand.path.duration(), seconds, 10.0);
  const auto drive = [&](haptic::World& world) { haptic::followPaths(scene, world); };
  return haptic::certifyDeadline(scene.world, haptic::kShareOfTick * scene.world.settings.step, seconds, drive);
}

std::string lineOf(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

/// The words of the command line beside the loader's options.
struct Words {
  std::string name, device_file, missing = "stop";
  double rate = 0;  ///< [Hz]; 0: the scene's own
  bool strict = false, all = false, json = false;
};

/// False, and said: a word is wrong, or no scene is named.
bool read(int argc, char** argv, haptic::SceneOptions& options, Words& words) {
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const bool has_value = i + 1 < argc;
    if (argument == "--strict") {
      words.strict = true;
    } else if (argument == "--rigid") {
      options.rigid = true;
    } else if (argument == "--all") {
      words.all = true;
    } else if (argument == "--json") {
      words.json = true;
    } else if (argument == "--default-density" && has_value) {
      if (!readPositive("--default-density", argv[++i], "kg/m³", options.default_density)) return false;
    } else if (argument == "--rate" && has_value) {
      if (!readPositive("--rate", argv[++i], "Hz", words.rate)) return false;
    } else if (argument == "--device" && has_value) {
      words.device_file = argv[++i];
    } else if (argument == "--srdf" && has_value) {
      options.srdf = argv[++i];
    } else if (argument == "--missing-meshes" && has_value) {
      words.missing = argv[++i];
    } else if (argument == "--xacro" && has_value) {
      options.xacro.push_back(argv[++i]);
    } else if (argument == "--scenes" && has_value) {
      options.scene_folders.push_back(argv[++i]);
    } else if (words.name.empty() && argument.rfind("--", 0) != 0) {
      words.name = argument;
    } else {
      std::fprintf(stderr, "scene_check: unexpected '%s'\n%s", argument.c_str(), kUsage);
      return false;
    }
  }
  if (words.name.empty()) {
    std::fputs(kUsage, stderr);
    return false;
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  if (haptic::toldVersion(argc, argv, "scene_check")) return 0;
  haptic::SceneOptions options;
  Words words;
  if (!read(argc, argv, options, words)) return 2;
  try {
    if (words.rate > 0) options.step = 1 / words.rate;
    options.missing = haptic::missingMeshesNamed(words.missing);
    haptic::ProgressWatch watch([](const std::string& line) { std::fprintf(stderr, "scene_check: %s\n", line.c_str()); }, "loading "
        + words.name);
    options.progress = [&watch](const std::string& line) { watch.tell(line); };
    const haptic::SceneDef scene = haptic::loadScene(words.name, options);
    watch.stage("certificate of explicit steps");
    const haptic::World world(scene.world);
    const haptic::Certificate certificate = haptic::certify(scene.world);
    haptic::CheckReport report = haptic::checkReport(scene, certificate);
    watch.stage("cost of a step");
    report.cost = haptic::costLines(haptic::stepCost(scene.world));
    watch.stage("deadline of a tick");
    const haptic::DeadlineReport deadline = deadlineOf(scene);
    report.deadline = {deadline.text()};
    bool good = true;
    watch.stage("a hand pressed to the workspace's end");
    if (!words.device_file.empty()) {
      const haptic::DeviceDef device = haptic::loadDevice(words.device_file);
      for (const haptic::HandDef& hand : scene.hands) {
        const haptic::HandMapping mapping{hand.workspace.scale, hand.force_scale, hand.delay.total()};
        report.hands.push_back(lineOf(haptic::certifyHand(scene.world, hand.pointer, mapping, device).text()));
        good = passes(scene, hand, device, report.hands) && good;
      }
    }
    haptic::judge(scene, certificate, !good, report);
    if (words.json) {
      std::fputs(haptic::checkJson(report).c_str(), stdout);
    } else {
      std::fputs(haptic::checkText(report).c_str(), stdout);
      if (words.all) std::fputs((haptic::sceneText(scene) + world.planText() + certificate.text()).c_str(), stdout);
    }
    const int code = !good || (words.strict && report.warnings.size() + report.replaced.size() + report.weak_drives.size() > 0) ? 1 : 0;
    if (words.json) return code;
    std::printf("figure check.least_over_deadline %.3g 1\n", deadline.least * deadline.seconds_per_unit / deadline.deadline);
    std::printf("figure check.collisions_lost %d 1\nfigure check.replaced %zu 1\nfigure check.warnings %zu 1\n",
                scene.collisions_tried - scene.collisions_loaded, scene.replaced.size(), scene.warnings.size());
    return code;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "scene_check: %s\n", error.what());
    return 2;
  }
}
