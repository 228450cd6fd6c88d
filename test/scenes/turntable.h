/// A block that stands on a disc whose surface turns as a belt does.
#pragma once
#include <cmath>

#include "blocks.h"

namespace haptic::scenes {

constexpr double kTurntableRadius = 0.3;    ///< of the block's place [m]
constexpr double kTurntableFriction = 0.3;  ///< μ
constexpr double kTurntableStiffness = 1e8; ///< k [N/m³]

/// Rate at which the block needs `share` of friction's limit [rad/s].
inline double turntableRate(double share) { return std::sqrt(share * kTurntableFriction * kGravity / kTurntableRadius); }

constexpr double kTurntableMass = 0.3, kTurntableArea = 4e-4;  ///< of the block [kg], [m²]

/// How far the layer under the block yields outward [m].
inline double turntableSlip(double share) {
  const double per_slip = DefaultMaterial::kTangentialRatio * kTurntableStiffness * kTurntableArea;  // [N/m]
  return share * kTurntableFriction * kTurntableMass * kGravity / per_slip;
}

/// Link 0 is the disc, its top at z = 0, link 1 a block of 2 × 2 × .2 cm at its rest depth, which moves with it.
inline WorldDef onTurntable(double share) {
  const Vector3 block(0.02, 0.02, 0.002), disc(2, 2, 0.1);
  const double mass = kTurntableMass, W = turntableRate(share);
  WorldDef def;
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = kTurntableStiffness;
  m.mu_static = m.mu_dynamic = kTurntableFriction;
  def.articulations.push_back(staticBox("disc", disc, Pose(Vector3(0, 0, -0.5 * disc.z()))));
  def.articulations[0].links[0].collisions[0].belt.V_L.angular = Vector3(0, 0, W);
  const double depth = mass * kGravity / (kTurntableStiffness * kTurntableArea);
  def.articulations.push_back(freeBox("block", block, mass, Pose(Vector3(kTurntableRadius, 0, 0.5 * block.z() - depth)),
                                      {Vector3(0, 0, W), Vector3(0, W * kTurntableRadius, 0)}));
  return def;
}

struct Turned {
  double radius = 0;   ///< of the block's place [m]
  double beyond = 0;   ///< its angle less that of the disc [rad]
};

inline Turned turnedTo(const World& world, double share) {
  const Vector3 p = rotationAbout(Vector3::UnitZ(), -turntableRate(share) * world.time()) * world.linkPose(1).p;
  return {p.head<2>().norm(), elementary::atan2(p.y(), p.x())};
}

}  // namespace haptic::scenes
