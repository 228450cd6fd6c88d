/// A face of a contact volume seen along the normal of the contact.
#pragma once
#include "haptic_core/geometry/volume/cut_solid.h"

namespace haptic {

/// A face of V over the patch: z = height + slope·r, in P.
struct ContactSheet {
  /// Faces with a smaller |N·n| have no projection to speak of: its width is below 1e-9 of the depth, and the height above r
  /// loses as many digits.
  static constexpr double kSteep = 1e-9;

  double height = 0;                 ///< at P's origin [m]
  Vector2 slope = Vector2::Zero();   ///< along x and y [1]

  /// Of a face that is not steep.
  ContactSheet(const ContactFace& face, const Pose& X_AP) {
    const Vector3 N = X_AP.R.transpose() * face.normal;
    height = (face.offset - face.normal.dot(X_AP.p)) / N.z();
    slope = -N.head<2>() / N.z();
  }
  double at(const Vector2& r) const { return height + slope.dot(r); }  ///< z at r [m]
};

}  // namespace haptic
