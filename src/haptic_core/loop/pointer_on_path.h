/// Where a pointer is whose hand follows a scripted path, without device: where the grip should be.
#pragma once
#include <cmath>

#include "haptic_core/loop/workspace_map.h"
#include "haptic_core/spidar/hand_path.h"

namespace haptic {

/// At time `t` [s] of the path, which is followed over and over.
inline WorkspaceMap pointerOnPath(const WorkspaceSettings& workspace, const HandPath& path, double t) {
  const double period = path.duration();
  const double time = period > 0 ? std::fmod(t, period) : 0;
  const double dt = 1e-5;  // [s]: the path is a quintic; the error of the quotient is 1e-9 of its speed
  const GripPose grip = path.at(time), later = path.at(time + dt);
  const Twist V_BG{vectorFromRotation(Quaternion(later.X_BG.R) * Quaternion(grip.X_BG.R).conjugate()) / dt,
                   (later.X_BG.p - grip.X_BG.p) / dt};
  WorkspaceMap map(workspace);
  map.update(grip.X_BG, V_BG, false);
  return map;
}

}  // namespace haptic
