/// From the grip in its device to the pointer in the world: offset, rotation, scale and clutch.
#pragma once
#include "haptic_core/base/spatial.h"

namespace haptic {

struct WorkspaceSettings {
  Pose X_WB;                ///< device base in the world
  double scale = 1;         ///< world metres per grip metre; > 0
};

/// p_WP = p_WB + R_WB (scale · p_BG) + offset_W,  R_WP = R_WB R_BG R_GP. A clutch holds the pointer while the
/// grip moves on; at release the offsets take up the difference, so that the pointer never jumps.
class WorkspaceMap {
 public:
  explicit WorkspaceMap(const WorkspaceSettings& settings) : settings_(settings) {}

  /// (in realtime) Pointer pose and twist for the grip's pose and twist (at G's origin, in B).
  void update(const Pose& X_BG, const Twist& V_BG, bool clutch) noexcept {
    const Matrix3& R_WB = settings_.X_WB.R;
    const Pose grip(R_WB * X_BG.R, settings_.X_WB.p + R_WB * (settings_.scale * X_BG.p));
    if (clutched_ || clutch) {
      R_GP_ = grip.R.transpose() * X_WP_.R;
      offset_W_ = X_WP_.p - grip.p;
      V_WP_ = Twist{};
    } else {
      X_WP_ = Pose(grip.R * R_GP_, grip.p + offset_W_);
      V_WP_ = Twist{R_WB * V_BG.angular, R_WB * (settings_.scale * V_BG.linear)};
    }
    clutched_ = clutch;
  }

  /// The world's wrench on the hand at the pointer's origin, in W, as one on the grip in B.
  Wrench toGrip(const Wrench& F_W) const { return F_W.rotated(settings_.X_WB.R.transpose()); }

  const Pose& X_WP() const { return X_WP_; }
  const Twist& V_WP() const { return V_WP_; }
  bool clutched() const { return clutched_; }

 private:
  WorkspaceSettings settings_;
  Vector3 offset_W_ = Vector3::Zero();
  Matrix3 R_GP_ = Matrix3::Identity();
  Pose X_WP_;
  Twist V_WP_;
  bool clutched_ = false;
};

}  // namespace haptic
