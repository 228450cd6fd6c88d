/// From the grip in its device to the pointer in the world: offset, rotation, scale, clutch and glide.
#pragma once
#include <cmath>

#include "haptic_core/base/spatial.h"

namespace haptic {

/// How the map takes up a difference between the grip's place and the pointer's.
enum class Rebase : unsigned char {
  kNone,
  kKeep,   ///< the pointer stays where it is and moves on from there (a body was grabbed)
  kGlide,  ///< the pointer starts where it is and glides to the grip's place (reset, restore, load)
};

/// Where a device stands in the world, and its scale.
struct WorkspaceSettings {
  Pose X_WB;                ///< device base in the world
  double scale = 1;         ///< world metres per grip metre; > 0

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.X_WB), visit(s.scale);
  }
};

/// Maps the grip in its device to the pointer in the world.
/// p_WP = p_WB + R_WB (scale · p_BG) + offset_W,  R_WP = R_WB R_BG R_GP. A clutch holds the pointer while the
/// grip moves on; at release the offsets take up the difference, so that the pointer never jumps. `rebase` does the
/// same where the world moved the pointer; when it glides, the offsets shrink to zero with s(t) = 1 - x³(10 - 15x +
/// 6x²), x = t/T (minimum jerk): the pointer comes to the grip's place without a step in speed.
class WorkspaceMap {
 public:
  /// Without offset: the pointer is where the grip is.
  explicit WorkspaceMap(const WorkspaceSettings& settings) : settings_(settings) {}

  /// Another base or scale from now on; the pointer keeps its place. Between two ticks.
  void setSettings(const WorkspaceSettings& settings) {
    settings_ = settings;
    rebase_ = Rebase::kKeep;
  }

  /// (in realtime) From the next update on the pointer is at `X_WP`; `glide_s` [s] is T; 0: it jumps.
  void rebase(const Pose& X_WP, Rebase how, double glide_s) noexcept {
    if (how == Rebase::kGlide && !(glide_s > 0)) {
      offset_W_.setZero();
      R_GP_.setIdentity();
      return;
    }
    X_WP_ = X_WP;
    rebase_ = how;
    glide_left_ = glide_s_ = how == Rebase::kGlide ? glide_s : 0;
  }

  /// (in realtime) Pointer pose and twist for the grip's pose and twist (at G's origin, in B), `h` [s] after the last.
  void update(const Pose& X_BG, const Twist& V_BG, bool clutch, double h = 0) noexcept {
    const Matrix3& R_WB = settings_.X_WB.R;
    const Pose grip(R_WB * X_BG.R, settings_.X_WB.p + R_WB * (settings_.scale * X_BG.p));
    if (clutched_ || clutch || rebase_ != Rebase::kNone) {
      R_GP_ = grip.R.transpose() * X_WP_.R;
      offset_W_ = X_WP_.p - grip.p;
      if (rebase_ != Rebase::kGlide && glide_left_ > 0) glide_left_ = 0;  // the offset of the clutch stays
      glide_offset_W_ = offset_W_;
      glide_turn_ = vectorFromRotation(Quaternion(R_GP_));
      rebase_ = Rebase::kNone;
      V_WP_ = Twist{};
    } else {
      V_WP_ = Twist{R_WB * V_BG.angular, R_WB * (settings_.scale * V_BG.linear)};
      if (glide_left_ > 0) glide(grip.R, h);
      X_WP_ = Pose(grip.R * R_GP_, grip.p + offset_W_);
    }
    clutched_ = clutch;
  }

  /// The world's wrench on the hand at the pointer's origin, in W, as one on the grip in B. A lever is scaled as a way is, else a push
  /// and a turn would not return the work that they took: power at the grip is the world's over the scale.
  Wrench toGrip(const Wrench& F_W) const {
    const Wrench F_B = F_W.rotated(settings_.X_WB.R.transpose());
    return {F_B.torque / settings_.scale, F_B.force};
  }

  /// All but the settings.
  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.offset_W_), visit(s.glide_offset_W_), visit(s.R_GP_), visit(s.glide_turn_), visit(s.X_WP_), visit(s.V_WP_);
    visit(s.glide_left_), visit(s.glide_s_), visit(s.rebase_), visit(s.clutched_);
  }

  /// Pose of the pointer.
  const Pose& X_WP() const { return X_WP_; }
  /// Twist of the pointer at its origin, in W.
  const Twist& V_WP() const { return V_WP_; }
  /// The pointer is held.
  bool clutched() const { return clutched_; }
  /// As last set.
  const WorkspaceSettings& settings() const { return settings_; }

 private:
  void glide(const Matrix3& R_WG, double h) noexcept {
    glide_left_ = std::fmax(0.0, glide_left_ - h);
    const double x = 1 - glide_left_ / glide_s_;
    const double share = 1 - x * x * x * (10 - x * (15 - 6 * x));
    const double rate = -30 * x * x * (1 - x) * (1 - x) / glide_s_;  // of the share [1/s]
    offset_W_ = share * glide_offset_W_;
    R_GP_ = rotationFromVector(share * glide_turn_).toRotationMatrix();
    V_WP_.linear += rate * glide_offset_W_;
    V_WP_.angular += rate * (R_WG * glide_turn_);
  }

  WorkspaceSettings settings_;
  Vector3 offset_W_ = Vector3::Zero(), glide_offset_W_ = Vector3::Zero();
  Matrix3 R_GP_ = Matrix3::Identity();
  Vector3 glide_turn_ = Vector3::Zero();  ///< rotation vector of R_GP where the glide began [rad]
  Pose X_WP_;
  Twist V_WP_;
  double glide_left_ = 0, glide_s_ = 0;   ///< [s]
  Rebase rebase_ = Rebase::kNone;
  bool clutched_ = false;
};

}  // namespace haptic
