/// Runs a recorded session again and compares it with what was recorded, tick by tick.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

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

/// A link that the world has at some time of a session.
struct SeenLink {
  std::string name;
  bool moves = false;
  int now = -1;                   ///< its index in the world; −1: it has not come yet, or has gone
  Pose X_WL;                      ///< where it was at last
};

class ReplayRun {
 public:
  /// Loads scene and devices as they were recorded. Throws SetupError when they are not the same any more; a session of another
  /// build is taken as it is, for its scene has other last bits from the start.
  explicit ReplayRun(const RecordedSession& session);

  /// Runs it all; `after_tick` is called after each tick with its index, `before_change` before bodies come or go.
  ReplayReport run(const std::function<void(std::uint64_t)>& after_tick = nullptr, const std::function<void()>& before_change = nullptr);

  const SceneDef& scene() const { return scene_; }                  ///< with the bodies that there are now
  const std::vector<SeenLink>& links() const { return links_; }     ///< of the whole session, those of its start first
  int seen(int link) const { return seen_[static_cast<std::size_t>(link)]; }  ///< index in `links` of a link of the world
  /// What draws each of `links`, by its index there.
  const std::vector<std::pair<int, VisualDef>>& visuals() const { return visuals_; }
  World& world() { return replay_->world(); }
  HapticLoop& loop() { return replay_->loop(); }
  const TickHash& hash() const { return hash_; }                    ///< of the last tick
  const std::vector<DeviceDef>& devices() const { return devices_; }  ///< of the recorded hands

 private:
  void follow(const WorldDef& def);
  void see();
  void foresee(const WorldDef& def);

  const RecordedSession& session_;
  std::vector<DeviceDef> devices_;
  TickHash hash_;
  SceneDef scene_;
  std::unique_ptr<SessionReplay> replay_;
  std::vector<SeenLink> links_;
  std::vector<int> seen_;         ///< by link of the world
  std::vector<std::pair<int, VisualDef>> visuals_;
};

}  // namespace haptic
