/// Scenes of what acts on bodies from outside: wrenches, platforms and turntables whose motion is given, belts.
#pragma once
#include <algorithm>
#include <vector>

#include "blocks.h"
#include "haptic_core/world/led_motion.h"
#include "haptic_core/world/state.h"

namespace haptic::scenes {

/// A box of three unlike edges that touches nothing.
struct LoneBody {
  Vector3 size = Vector3(0.1, 0.2, 0.3);  ///< [m]
  double mass = 0.7;                      ///< [kg]
  Matrix3 inertia() const { return boxInertia(size, mass); }
};

inline WorldDef alone(const LoneBody& body, const WorldSettings& settings, const Pose& X_WL = Pose()) {
  WorldDef def;
  def.name = "alone";
  def.settings = settings;
  def.articulations.push_back(freeBox("body", body.size, body.mass, X_WL));
  return def;
}

/// What stands on a carrier or a belt: flat, so that friction tilts it little.
struct Load {
  Vector3 size = Vector3(0.2, 0.2, 0.04);  ///< [m]
  double mass = 1;                         ///< [kg]
  double stiffness = 2e7, mu = 0.5;        ///< k [N/m³], μ0 = μ
  Vector3 place = Vector3(0.3, 0.1, 0);    ///< on the carrier [m]
  double restDepth(double gravity = kGravity) const { return mass * gravity / (stiffness * size.x() * size.y()); }
};

inline void setSurfaces(const Load& load, WorldDef& def) {
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = load.stiffness;
  m.dissipation = 10;
  m.mu_static = m.mu_dynamic = load.mu;
}

/// Link 0 is the carrier, its top at its origin; link 1 the load, at rest on it. `path`: poses of the carrier, a row each `pace`; none: it
/// is told its poses.
inline WorldDef onCarrier(const Load& load, const WorldSettings& settings, const std::vector<Pose>& path, double pace,
                          bool repeat = false) {
  WorldDef def;
  def.name = "carried";
  def.settings = settings;
  setSurfaces(load, def);
  ArticulationDef carrier = freeBody("carrier", box(Vector3(2, 2, 0.1)), 5, Matrix3::Identity(), path.empty() ? Pose() : path[0]);
  carrier.links[0].collisions[0].X_LS = Pose(Vector3(0, 0, -0.05));
  carrier.links[0].inertia.p_LC = Vector3(0.1, -0.2, -0.05);  // a motion moves the link's frame, wherever the mass is
  MotionDef motion;
  motion.name = "carrier";
  motion.articulation = motion.link = 0;
  motion.pose = path;
  motion.repeat = repeat;
  for (std::size_t i = 0; i < path.size(); ++i) motion.time.push_back(pace * static_cast<double>(i));
  def.motions.push_back(motion);
  const Pose X_WL = carrier.X_WA * Pose(load.place + Vector3(0, 0, load.size.z() / 2 - load.restDepth()));
  def.articulations.push_back(carrier);
  def.articulations.push_back(freeBox("load", load.size, load.mass, X_WL));
  return def;
}

/// To and fro along (1, 2, 0), up and down, and turning: `seconds` long after a rest of two rows, back to where it began.
inline std::vector<Pose> wandering(double seconds, double pace) {
  std::vector<Pose> path;
  const int rows = static_cast<int>(std::lround(seconds / pace));
  for (int i = -2; i <= rows; ++i) {
    const double phase = 2 * M_PI * std::max(0, i) / rows;
    const double bell = 0.5 - 0.5 * elementary::cos(phase);  // 0 … 1 … 0
    const double a = 0.03 * seconds / 3 * bell * elementary::sin(3 * phase);
    path.emplace_back(rotationAbout(Vector3::UnitZ(), 0.8 * bell), Vector3(0.5 * a, a, 0.1 * bell));
  }
  return path;
}

/// The load's place on the carrier [m].
inline Vector3 placeOnCarrier(const World& world) { return world.linkPose(0).inverse() * world.linkPose(1).p; }

/// Link 0 is a belt that runs along x at `speed` [m/s], its top at z = 0; link 1 the load, at rest on it.
inline WorldDef onBelt(const Load& load, const WorldSettings& settings, double speed, double length = 400) {
  WorldDef def;
  def.name = "belt";
  def.settings = settings;
  setSurfaces(load, def);
  def.articulations.push_back(staticBox("belt", Vector3(length, 2, 0.5), Pose(Vector3(length / 2 - 2, 0, -0.25))));
  def.articulations[0].links[0].collisions[0].belt.V_L.linear = Vector3(speed, 0, 0);
  def.articulations.push_back(freeBox("load", load.size, load.mass, Pose(Vector3(0, 0, load.size.z() / 2 - load.restDepth()))));
  return def;
}

}  // namespace haptic::scenes
