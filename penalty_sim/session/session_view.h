/// A recorded session as a picture needs it: bodies and devices once, contact patches over time.
///
/// Poses of bodies and grips are columns of SessionTable already. Written beside them: NAME.view.yaml (visuals, links that
/// stand, devices), NAME.meshes.bin (float32 vertices x 3 [m], then uint32 triangles x 3, mesh after mesh),
/// NAME.patches.bin (rows of kPatchNumbers float32).
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "replay/replay_run.h"

namespace haptic {

class SessionView {
 public:
  /// `run` is the session's and has not run yet.
  SessionView(const RecordedSession& session, ReplayRun& run);

  /// Of each patch: tick since the start, link A, link B, centroid in the world [m] (3), normal from A to B (3), force on B [N]
  /// (3), area [m²], normal force [N], 1 if it sticks.
  static constexpr int kPatchNumbers = 15;

  /// Notes patches of the tick that `run` has just made, and bases that moved.
  void addTick();
  /// NAME.view.yaml as text; after the last tick. Appends the meshes that visuals name to `meshes`.
  std::string text(std::string& meshes) const;
  /// Rows of the ticks since the last call.
  std::vector<float> takePatches() { return std::exchange(patches_, {}); }

 private:
  /// Where the base of a hand's device stood from a tick on.
  struct Base {
    std::uint64_t tick;
    int hand;
    Pose X_WB;
    double scale;
  };

  const RecordedSession& session_;
  ReplayRun& run_;
  std::uint64_t tick_ = 0, stride_;
  std::vector<float> patches_;
  std::vector<Base> bases_;
  std::vector<std::size_t> last_base_;  ///< by hand, index in `bases_`
};

}  // namespace haptic
