/// A cube in the corner of a floor and a wall that stands on it, gravity turned towards the wall.
#pragma once
#include <vector>

#include "blocks.h"

namespace haptic::scenes {

/// The 24 rotations that turn the axes into one another.
inline std::vector<Matrix3> quarterTurns() {
  std::vector<Matrix3> turns;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      for (int signs = 0; signs < 4 && j != i; ++signs) {
        Matrix3 R = Matrix3::Zero();
        R(i, 0) = signs & 1 ? 1 : -1;
        R(j, 1) = signs & 2 ? 1 : -1;
        R.col(2) = R.col(0).cross(R.col(1));
        turns.push_back(R);
      }
    }
  }
  return turns;
}

struct CornerParameters {
  Matrix3 R = Matrix3::Identity();  ///< the whole is turned by it
  double tilt = 25 * M_PI / 180;    ///< of gravity against the floor's normal [rad]
  double mass = 0.5;                ///< [kg]
  double stiffness = 1e6;           ///< k [N/m³]
  double mu = 0;
  double gap = 0;                   ///< between floor and wall [m]
  bool one_body = false, cube_first = false;

  double wallForce() const { return mass * kGravity * elementary::sin(tilt); }
  double floorForce() const { return mass * kGravity * elementary::cos(tilt); }
};

inline WorldDef innerCorner(const CornerParameters& p, const WorldSettings& settings) {
  CubeParameters c;
  c.mass = p.mass;
  c.stiffness = p.stiffness;
  c.mu_static = c.mu_dynamic = p.mu;
  WorldDef def;
  def.name = "corner";
  def.settings = settings;
  def.settings.gravity = p.R * (kGravity * Vector3(elementary::sin(p.tilt), 0, -elementary::cos(p.tilt)));
  def.settings.default_material = c.material();
  const double per_depth = p.stiffness * c.area();
  const Pose turn(p.R, Vector3::Zero());
  ArticulationDef floor = staticBox("floor", Vector3(1, 1, 0.1), turn * Pose(Vector3(0, 0, -0.05)));
  ArticulationDef wall = staticBox("wall", Vector3(0.1, 1, 0.4), turn * Pose(Vector3(0.15, 0, 0.2 + p.gap)));
  const ArticulationDef body =
      cube("cube", c, turn * Pose(Vector3(0.05 + p.wallForce() / per_depth, 0, 0.05 - p.floorForce() / per_depth)));
  if (p.one_body) {
    CollisionDef piece = wall.links[0].collisions[0];
    piece.X_LS = Pose(Vector3(0.15, 0, 0.25 + p.gap));  // in the floor's frame
    floor.links[0].collisions.push_back(piece);
  }
  if (p.cube_first) def.articulations.push_back(body);
  def.articulations.push_back(floor);
  if (!p.one_body) def.articulations.push_back(wall);
  if (!p.cube_first) def.articulations.push_back(body);
  return def;
}

/// How far the wall's and the floor's force on the cube are from statics [N]: each is the weight's share along its own
/// normal, and nothing across. For μ = 0.
inline double cornerForceError(const World& world, const CornerParameters& p) {
  const int cube_link = world.linkIndex("cube");
  const Vector3 wall(-p.wallForce(), 0, 0), floor(0, 0, p.floorForce());
  double error = world.contactCount() == 2 ? 0 : p.mass * kGravity;
  for (int i = 0; i < world.contactCount(); ++i) {
    const ContactReport& c = world.contact(i);
    const Vector3 force = p.R.transpose() * ((c.link_b == cube_link ? 1 : -1) * c.F_BP_W.force);
    error = std::max(error, std::min((force - wall).norm(), (force - floor).norm()));
  }
  return error;
}

}  // namespace haptic::scenes
