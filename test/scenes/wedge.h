/// A wedge of 0.2 kg that a spring pulls from under a guided block of 5 kg: two patches slide on one body, and the pull is known.
#pragma once
#include <cmath>

#include "blocks.h"
#include "haptic_core/base/elementary.h"

namespace haptic::scenes {

struct Wedge {
  double angle = M_PI / 180;                ///< α of its upper side [rad]
  double stiffness = 1e10;                  ///< k [N/m³]
  double mu = 0.2, mass = 0.2, load = 5;    ///< of wedge and block [kg]
  double speed = 5e-3;                      ///< of the spring's far end [m/s]

  static constexpr double kSpring = 2000, kDamper = 20;  ///< [N/m], [N·s/m]
  /// Pull at which the wedge slides on at a constant speed: (M g (tan(α + φ) + μ) + m g μ), tan φ = μ.
  double pull() const {
    const double tan = elementary::sin(angle) / elementary::cos(angle);
    return kGravity * (load * ((tan + mu) / (1 - tan * mu) + mu) + mass * mu);
  }
};

/// Articulations: floor, wedge, block on a vertical slide, a carriage so heavy that it goes on at its speed.
inline WorldDef wedge(const Wedge& w) {
  constexpr double kLength = 0.3, kWidth = 0.05, kThin = 0.02, kPlace = 0.08;  // [m]; the block's middle
  const double tan = elementary::sin(w.angle) / elementary::cos(w.angle), thick = kThin + kLength * tan;
  WorldDef def;
  def.name = "wedge";
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = w.stiffness;
  m.mu_static = m.mu_dynamic = w.mu;
  def.articulations.push_back(floorBox());
  std::vector<Vector3> corners;
  for (const double y : {-kWidth, kWidth}) {
    for (const double z : {0.0, thick}) corners.push_back(Vector3(-kLength / 2, y, z));
    for (const double z : {0.0, kThin}) corners.push_back(Vector3(kLength / 2, y, z));
  }
  const Matrix3 moments = Vector3(2e-4, 1.5e-3, 1.6e-3).asDiagonal();
  const auto shape = std::make_shared<ConvexPolyhedron>(ConvexPolyhedron::hull(corners));
  def.articulations.push_back(freeBody("wedge", shape, w.mass, moments, Pose()));
  const double half = 0.03, low = 0.5 * (kThin + thick) - kPlace * tan;
  const Matrix3 R = rotationFromRpy(Vector3(0, w.angle, 0));
  ArticulationDef block = freeBody("block", box(Vector3(0.08, 0.08, 2 * half)), w.load, 1e-2 * Matrix3::Identity(),
                                   Pose(Vector3(kPlace, 0, low) + half * R.col(2)));
  block.links[0].collisions[0].X_LS = Pose(R, Vector3::Zero());
  block.links[0].joint.type = JointType::kPrismatic;
  block.links[0].joint.axis = Vector3::UnitZ();
  def.articulations.push_back(block);
  ArticulationDef carriage = freeBody("carriage", nullptr, 1e8, Matrix3::Identity(), Pose(Vector3(kLength / 2, 0, 0.01)));
  carriage.links[0].joint.type = JointType::kPrismatic;
  carriage.links[0].joint.axis = Vector3::UnitX();
  carriage.links[0].joint.velocity = w.speed;
  def.articulations.push_back(carriage);
  ForceDef spring;
  spring.articulation_a = 3, spring.link_a = 0, spring.articulation_b = 1, spring.link_b = 0;
  spring.p_B = Vector3(kLength / 2, 0, 0.01);
  spring.set("stiffness", Wedge::kSpring);
  spring.set("damping", Wedge::kDamper);
  def.forces.push_back(spring);
  return def;
}

/// Of the spring [N]. q, v: those of the wedge's free joint, of the block and of the carriage follow.
inline double pullOf(const World& world) {
  return Wedge::kSpring * (world.q()[8] - world.q()[0]) + Wedge::kDamper * (world.v()[7] - world.v()[3]);
}

}  // namespace haptic::scenes
