/// Runs a recorded session again and compares it with what was recorded, tick by tick.
#pragma once
#include <functional>
#include <memory>

#include "replay/recorded_session.h"
#include "scene/scene_file.h"

namespace haptic {

struct ReplayReport {
  std::uint64_t steps = 0, compared = 0, mismatches = 0;
  std::uint64_t first_tick = 0;   ///< of the first mismatch
  std::string first_part;         ///< first body or hand that differs in it
  double seconds = 0;             ///< that the replay took
  double simulated = 0;           ///< that it covers [s]
};

class ReplayRun {
 public:
  /// Loads scene and devices as they were recorded. Throws SetupError when they are not the same any more; a session of another
  /// build is taken as it is, for its scene has other last bits from the start.
  explicit ReplayRun(const RecordedSession& session);

  /// Runs it all; `after_tick` is called after each tick with its index.
  ReplayReport run(const std::function<void(std::uint64_t)>& after_tick = nullptr);

  const SceneDef& scene() const { return scene_; }
  World& world() { return replay_->world(); }
  HapticLoop& loop() { return replay_->loop(); }
  const TickHash& hash() const { return hash_; }                    ///< of the last tick
  const std::vector<DeviceDef>& devices() const { return devices_; }  ///< of the recorded hands

 private:
  const RecordedSession& session_;
  std::vector<DeviceDef> devices_;
  TickHash hash_;
  SceneDef scene_;
  std::unique_ptr<SessionReplay> replay_;
};

}  // namespace haptic
