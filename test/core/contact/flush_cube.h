/// A cube of 0.1 m that sits flush and level in a floor: every integral over its patch is a closed form.
#pragma once
#include <gtest/gtest.h>

#include "haptic_core/contact/located_force.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/geometry/volume/contact_volume.h"

namespace haptic::test {

class FlushCube : public ::testing::Test {
 protected:
  static constexpr double kSide = 0.1, kArea = kSide * kSide, kTorsion = kArea * kArea / 6;  ///< [m], [m²], J [m⁴]

  FlushCube() : floor_(makeBox(Vector3(1, 1, 0.2))), cube_(makeBox(Vector3::Constant(kSide))) {
    workspace_.reserve(floor_, cube_);
    law_.material.stiffness = 1e6;
    law_.material.damping = 2e3;
    law_.material.dissipation = 5;
    law_.material.tangential_stiffness = 8e5;
    law_.material.tangential_damping = 3e3;
    law_.material.mu_static = 0.6;
    law_.material.mu_dynamic = 0.4;
    sinkTo(1e-4);
  }
  void sinkTo(double depth) {
    PairCache cache;
    X_AB_ = Pose(Vector3(0.02, -0.01, 0.15 - depth));
    contactVolume(floor_, cube_, X_AB_, cache, workspace_, contact_);
    depth_ = depth;
  }
  /// The cube goes on for a time as V says; the patch stays what it is.
  void move(const Twist& V, double time) {
    const Matrix3& R_AP = contact_.X_AP.R;
    const Vector3 turn = time * (R_AP * V.angular), way = time * (R_AP * V.linear);
    const double angle = turn.norm();
    const Matrix3 R = angle > 0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() : Matrix3::Identity();
    X_AB_ = Pose(R, contact_.X_AP.p + way - R * contact_.X_AP.p) * X_AB_;
  }
  /// After a step in which the cube moved as V says, where the memory knows of one.
  LocatedForce force(const Twist& V, const FrictionMemory& memory, const Advance& advance) {
    if (memory.touching != 0) move(V, advance.time);
    return locatedForce(contact_, X_AB_, workspace_, V, memory, law_, advance);
  }
  double load() const { return law_.material.stiffness * kArea * depth_; }  ///< N at rest [N]
  /// A vector of the floor in P's axes: n is the floor's z, the patch may be turned about it.
  Vector3 inP(const Vector3& a) const { return contact_.X_AP.R.transpose() * a; }

  ConvexPolyhedron floor_, cube_;
  ContactWorkspace workspace_;
  ContactVolume contact_;
  PairLaw law_;
  Pose X_AB_;   ///< of the cube, as friction is told
  double depth_ = 0;
};

}  // namespace haptic::test
