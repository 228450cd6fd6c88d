#include "loop_rig.h"

#include <dirent.h>

#include <algorithm>
#include <cstdio>

#include "haptic_core/base/error.h"
#include "haptic_core/loop/hand.h"

namespace haptic::bench {

std::string repositoryFile(const std::string& path) { return std::string(HAPTIC_SOURCE_DIR) + "/" + path; }

Rig::Rig(const SceneDef& scene_def, const RigSettings& settings)
    : scene(scene_def), step(1 / settings.rate), world(scene.world), loop(std::make_unique<HapticLoop>(world)) {
  const DeviceDef def = loadDevice(repositoryFile("urdf/devices/" + settings.device + ".yaml"));
  for (const HandDef& hand : scene.hands) {
    device.push_back(std::make_unique<Spidar>(def));
    TwinSettings twin_settings;
    twin_settings.period = step;
    twin_settings.path = hand.path;
    twin.push_back(std::make_unique<DeviceTwin>(def, twin_settings));
    HandSettings hand_settings;
    hand_settings.workspace = hand.workspace;
    hand_settings.force_scale = hand.force_scale;
    hand_settings.passivity.mode = settings.passivity;
    hand_settings.soft_start_s = settings.soft_start;
    loop->attach(*device.back(), hand.pointer, hand_settings);
    device.back()->calibrateAtHome();
    device.back()->setForceEnabled(true);
  }
}

void Rig::exchange() noexcept {
  for (std::size_t i = 0; i < twin.size(); ++i) samples[i] = twin[i]->exchange(device[i]->drive());
}

void Rig::run(int count) noexcept {
  for (int i = 0; i < count; ++i) {
    exchange();
    tick();
  }
}

SessionStart Rig::start() const {
  SessionStart start;
  start.step = step;
  start.world_state = world.save();
  start.world_tuning = world.tuning().numbers();
  start.paused = loop->paused();
  for (std::size_t i = 0; i < device.size(); ++i) {
    start.hands.push_back({scene.hands[i].device, device[i]->def(), scene.hands[i].pointer,
                           loop->hand(static_cast<int>(i)).settings(), device[i]->save()});
  }
  return start;
}

void Rig::recordedTick(std::vector<TickInput>& inputs, std::vector<LoopEvent>& events, std::vector<TickHash>& hashes) {
  exchange();
  TickInput input;
  input.tick = ticks++;
  input.hands = static_cast<int>(device.size());
  for (int i = 0; i < input.hands; ++i) {
    input.sample[i] = samples[i];
    const LoopCommand command{AskDevice{device[i]->takeRequests(samples[i])}, i};
    if (!std::get<AskDevice>(command.kind).requests.any()) continue;
    loop->take(command);
    events.push_back({input.tick, command});
  }
  loop->tick(input, step);
  inputs.push_back(input);
  hashes.emplace_back();
  hashTick(*loop, hashes.back());
}

SceneDef sceneNamed(const std::string& name, double rate) {
  SceneDef scene = loadScene(repositoryFile("urdf/scenes/" + name + ".urdf"));
  scene.world.settings.step = 1 / rate;
  return scene;
}

std::vector<std::string> loadableScenes() {
  std::vector<std::string> files, names;
  if (DIR* folder = opendir(repositoryFile("urdf/scenes").c_str())) {
    while (const dirent* entry = readdir(folder)) files.push_back(entry->d_name);
    closedir(folder);
  }
  std::sort(files.begin(), files.end());
  for (const std::string& file : files) {
    const std::size_t dot = file.find_last_of('.');
    const std::string suffix = dot == std::string::npos ? "" : file.substr(dot);
    if (suffix != ".urdf" && suffix != ".yaml") continue;
    const std::string path = repositoryFile("urdf/scenes/" + file);
    try {
      if (loadScene(path).hands.size() <= kMaxHands) names.push_back(path);
    } catch (const SetupError& error) {
      std::printf("scene left out: %s\n", error.what());
    }
  }
  return names;
}

}  // namespace haptic::bench
