/// A cube that friction holds on a carrier that moves: a turntable, a shaken platform, a ramp that tilts to and fro.
///
/// The carriers are heavy bodies on joints, moved by their own inertia, so that they are where the step says at its end.
#pragma once
#include "blocks.h"

namespace haptic::scenes {

struct CarriedCube {
  double size = 0.01, mass = 0.2;   ///< [m], [kg]
  double stiffness = 5e8;           ///< k [N/m³]
  double mu = 0.45;
  double radius = 0.2;              ///< of its place from the carrier's axis [m]
};

enum class Carrier { kTurntable, kPlatform, kRamp };

/// Period of the platform and of the ramp [s], and the turntable's angular acceleration [rad/s²].
inline double periodOf(Carrier carrier) { return carrier == Carrier::kPlatform ? 0.4 : 4.0; }
constexpr double kSpinUp = 0.2;

/// Link 0 is the carrier, link 1 the cube. `start`: of the turntable [rad/s].
inline WorldDef carried(Carrier carrier, const CarriedCube& c, const WorldSettings& settings, double start = 0) {
  constexpr double kMass = 1e5, kInertia = 1e5;  // what the cube does to it moves it by 1e-6 of its motion
  WorldDef def;
  def.name = "carried cube";
  def.settings = settings;
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = c.stiffness;
  m.dissipation = 10;
  m.mu_static = m.mu_dynamic = c.mu;
  ArticulationDef base = freeBody("carrier", box(Vector3(1, 1, 0.1)), kMass, kInertia * Matrix3::Identity(), Pose());
  LinkDef& link = base.links[0];
  link.collisions[0].X_LS = Pose(Vector3(0, 0, -0.05));
  JointDef& joint = link.joint;
  joint.type = carrier == Carrier::kPlatform ? JointType::kPrismatic : JointType::kRevolute;
  joint.axis = carrier == Carrier::kTurntable ? Vector3::UnitZ() : carrier == Carrier::kPlatform ? Vector3::UnitX() : Vector3::UnitY();
  const double depth = c.mass * kGravity / (c.stiffness * c.size * c.size);
  Twist V;
  if (carrier == Carrier::kTurntable) {
    joint.drive = JointDef::Drive::kEffort;
    joint.drive_effort = kInertia * kSpinUp;
    joint.velocity = start;
    V = {Vector3(0, 0, start), Vector3(0, start * c.radius, 0)};
  } else {
    const double omega = 2 * M_PI / periodOf(carrier);
    // Peaks at 0.7 of the limit: of the acceleration, or of the tangent of the angle.
    const double most = carrier == Carrier::kPlatform ? 0.7 * c.mu * kGravity / (omega * omega) : elementary::atan2(0.7 * c.mu, 1);
    joint.drive = JointDef::Drive::kPosition;
    joint.drive_stiffness = kMass * omega * omega;
    joint.velocity = most * omega;
    V = carrier == Carrier::kPlatform ? Twist{Vector3::Zero(), Vector3(most * omega, 0, 0)}
                                      : Twist{Vector3(0, most * omega, 0), Vector3(0, 0, -most * omega * c.radius)};
  }
  def.articulations.push_back(base);
  def.articulations.push_back(freeBox("cube", Vector3::Constant(c.size), c.mass, Pose(Vector3(c.radius, 0, c.size / 2 - depth)), V));
  return def;
}

/// Of the cube's lower face in the carrier's frame [m].
inline Vector3 placeOnCarrier(const World& world, const CarriedCube& c) {
  return world.linkPose(0).inverse() * (world.linkPose(1) * Vector3(0, 0, -c.size / 2));
}

}  // namespace haptic::scenes
