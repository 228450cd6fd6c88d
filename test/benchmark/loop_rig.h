/// Twins on the hands of a scene, and the loop between them: what the benchmarks of the loop run.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "haptic_core/loop/haptic_loop.h"
#include "haptic_core/loop/session.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/spidar/spidar.h"
#include "scene/scene_file.h"

namespace haptic::bench {

std::string repositoryFile(const std::string& path);

struct RigSettings {
  double rate = 1000;                ///< [Hz]
  PassivityMode passivity = PassivityMode::kObserve;
  double soft_start = 0.5;           ///< [s]
  std::string device = "spidar_g6x3r";
};

class Rig {
 public:
  Rig(const SceneDef& scene, const RigSettings& settings);

  void exchange() noexcept;                       ///< fills the samples
  void tick() noexcept { loop->tick(samples.data(), step); }
  void run(int ticks) noexcept;

  /// The same, recorded as the bridge does it.
  void recordedTick(std::vector<TickInput>& inputs, std::vector<LoopEvent>& events, std::vector<TickHash>& hashes);
  SessionStart start() const;

  SceneDef scene;
  double step;
  World world;
  std::vector<std::unique_ptr<Spidar>> device;
  std::vector<std::unique_ptr<DeviceTwin>> twin;
  std::unique_ptr<HapticLoop> loop;
  std::array<DeviceSample, kMaxHands> samples;
  std::uint64_t ticks = 0;
};

/// Names of the scenes that load (urdf/scenes); those whose models are not on this machine are left out.
std::vector<std::string> loadableScenes();
SceneDef sceneNamed(const std::string& name, double rate);

/// Parts of the benchmark; each prints its figures.
void measureStability();
void measureGear();

}  // namespace haptic::bench
