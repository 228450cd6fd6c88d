/// A parallelogram linkage that swings in the x-z plane: crank, coupler, rocker, and the ring that closes it.
#pragma once
#include "haptic_core/dynamics/ring.h"

namespace haptic::test {

constexpr double kCrank = 0.2, kCoupler = 0.3, kCrankMass = 0.1, kCouplerMass = 0.3;

/// Cranks hang along −z at q = 0; q = (crank, coupler over crank, rocker).
inline TreeDef fourBar() {
  TreeDef def;
  def.name = "four_bar";
  const auto rod = [](const char* name, int parent, const Vector3& at, const Vector3& along, double mass) {
    BodyDef body;
    body.name = name;
    body.parent = parent;
    body.joint.name = std::string(name) + "_hinge";
    body.joint.type = JointType::kRevolute;
    body.joint.axis = Vector3::UnitY();
    body.joint.X_PJ = Pose(at);
    body.inertia.mass = mass;
    body.inertia.p_LC = 0.5 * along;
    const double l2 = along.squaredNorm();
    body.inertia.I_C = mass / 12 * (l2 * Matrix3::Identity() - along * along.transpose()) +
                       1e-6 * Matrix3::Identity();  // a rod of some thickness
    return body;
  };
  def.links = {rod("crank", -1, Vector3::Zero(), {0, 0, -kCrank}, kCrankMass),
               rod("coupler", 0, {0, 0, -kCrank}, {kCoupler, 0, 0}, kCouplerMass),
               rod("rocker", -1, {kCoupler, 0, 0}, {0, 0, -kCrank}, kCrankMass)};
  return def;
}

inline std::vector<RingDef> fourBarRing() {
  RingDef ring;
  ring.name = "ring";
  ring.link_a = 1;
  ring.link_b = 2;
  ring.X_AF = Pose(Vector3(kCoupler, 0, 0));
  ring.X_BF = Pose(Vector3(0, 0, -kCrank));
  ring.type = RingDef::Type::kHinge;
  ring.axis = Vector3::UnitY();
  return {ring};
}

/// θ̈ = −this · sin θ [1/s²].
inline double fourBarStiffness() {
  const double crank = kCrankMass * kCrank * kCrank / 3 + 1e-6;
  return 9.8 * (kCrankMass * kCrank + kCouplerMass * kCrank) / (2 * crank + kCouplerMass * kCrank * kCrank);
}

}  // namespace haptic::test
