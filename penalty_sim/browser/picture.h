/// Picture of a scene and its loop for a page: JSON once, and numbers for each frame.
#pragma once
#include <string>
#include <vector>

#include "haptic_core/loop/haptic_loop.h"
#include "haptic_core/spidar/device_def.h"
#include "scene/scene_file.h"

namespace haptic {

/// A hand as it is drawn, in the order of the loop's at the start.
struct DrawnHand {
  std::string name;            ///< of its device
  WorkspaceSettings workspace; ///< where the device stands
  DeviceDef device;            ///< its strings and grip
};

/// The fixed parts, as JSON: links, visuals without their corners, hands with their devices, the layout of `Picture`. The names
/// of the fields are those of a session's page (penalty_sim/session/view_data.py).
std::string pictureText(const SceneDef& scene, const World& world, const std::vector<DrawnHand>& hands, const std::string& about);

/// The drawn state as numbers: `kHead` of the whole, then per link a pose (x, y, z, then quaternion x, y, z, w), per hand `kPerHand` and
/// a tension per string, then per patch `kPatchNumbers`. A hand that the loop has lost stands at its base's origin.
struct Picture {
  static constexpr int kHead = 11;          ///< time, links, hands, patches, contacts, solved islands, finite, flags, energies
  static constexpr int kPerHand = 19;       ///< grip in its base, force asked and presented in the base, six of the contact
  static constexpr int kPatchNumbers = 12;  ///< centroid, normal, force on B, radius, pressure, 1 if it sticks
  static constexpr int kMostPatches = 64;   ///< the first of them; more cannot be told apart

  /// Fills `out` anew.
  static void draw(HapticLoop& loop, const std::vector<DrawnHand>& hands, std::vector<double>& out);
};

}  // namespace haptic
