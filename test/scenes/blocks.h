/// Scenes of boxes, shared by unit tests, benchmarks and the report. SI; gravity 9.8 m/s² along -z; floor at z = 0.
#pragma once
#include <cmath>
#include <memory>
#include <string>

#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/world/world.h"

namespace haptic::scenes {

constexpr double kGravity = 9.8;  ///< [m/s²]

inline std::shared_ptr<const ConvexPolyhedron> box(const Vector3& size) {
  return std::make_shared<ConvexPolyhedron>(makeBox(size));
}

inline Matrix3 boxInertia(const Vector3& size, double mass) {
  const Vector3 s2 = size.cwiseProduct(size);
  return (mass / 12 * Vector3(s2.y() + s2.z(), s2.x() + s2.z(), s2.x() + s2.y())).asDiagonal();
}

/// A body of one shape on a floating joint.
inline ArticulationDef freeBody(const std::string& name, std::shared_ptr<const ConvexShape> shape, double mass,
                                const Matrix3& inertia, const Pose& X_WL, const Twist& V_WL = {}) {
  ArticulationDef def;
  def.name = name;
  def.X_WA = X_WL;
  def.V_WA = V_WL;
  LinkDef link;
  link.name = name;
  link.joint.name = name + "_joint";
  link.joint.type = JointType::kFloating;
  link.inertia.mass = mass;
  link.inertia.I_C = inertia;
  if (shape) {
    CollisionDef collision;
    collision.name = name;
    collision.shape = std::move(shape);
    link.collisions.push_back(collision);
  }
  def.links.push_back(link);
  return def;
}

inline ArticulationDef freeBox(const std::string& name, const Vector3& size, double mass, const Pose& X_WL,
                               const Twist& V_WL = {}) {
  return freeBody(name, box(size), mass, boxInertia(size, mass), X_WL, V_WL);
}

inline ArticulationDef staticBox(const std::string& name, const Vector3& size, const Pose& X_WL) {
  ArticulationDef def = freeBody(name, box(size), 1, Matrix3::Identity(), X_WL);
  def.links[0].joint.type = JointType::kFixed;
  return def;
}

/// Floor whose top is the plane z = 0.
inline ArticulationDef floorBox(double size = 4, double thickness = 0.5) {
  return staticBox("floor", Vector3(size, size, thickness), Pose(Vector3(0, 0, -thickness / 2)));
}

/// Edge, mass and foundation of the cubes that most scenes are made of.
struct CubeParameters {
  double size = 0.1;       ///< [m]
  double mass = 0.1;       ///< [kg]
  double stiffness = 1e6;  ///< k [N/m³]
  double ratio = 1;        ///< damping ratio of the heave on a full face, linear law
  double tangential = 2.0 / 3.0;  ///< k_t / k
  double tangential_ratio = 0.5;  ///< damping ratio of the sway, on k_t A and the mass
  double mu_static = 0.5, mu_dynamic = 0.5;

  double area() const { return size * size; }
  double restDepth() const { return mass * kGravity / (stiffness * area()); }
  ContactMaterial material() const {
    ContactMaterial m;
    m.stiffness = stiffness;
    m.damping = 2 * ratio * std::sqrt(stiffness * mass / area());
    m.dissipation = m.damping / (stiffness * restDepth());  // Hunt–Crossley with the same damper at rest
    m.tangential_stiffness = tangential * stiffness;
    m.tangential_damping = 2 * tangential_ratio * std::sqrt(tangential * stiffness * mass / area());
    m.mu_static = mu_static;
    m.mu_dynamic = mu_dynamic;
    return m;
  }
};

inline ArticulationDef cube(const std::string& name, const CubeParameters& c, const Pose& X_WL,
                            const Twist& V_WL = {}) {
  return freeBox(name, Vector3::Constant(c.size), c.mass, X_WL, V_WL);
}

/// One cube at its rest depth (`above` = 0) or over it, on the floor.
inline WorldDef cubeOnFloor(const CubeParameters& c, const WorldSettings& settings, double above = 0) {
  WorldDef def;
  def.name = "cube on floor";
  def.settings = settings;
  def.settings.default_material = c.material();
  def.articulations.push_back(floorBox());
  def.articulations.push_back(cube("cube", c, Pose(Vector3(0, 0, c.size / 2 - c.restDepth() + above))));
  return def;
}

/// `n` cubes on one another, each contact at the depth that carries what lies above.
inline WorldDef stack(int n, const CubeParameters& c, const WorldSettings& settings, double jitter = 0) {
  WorldDef def;
  def.name = "stack of " + std::to_string(n);
  def.settings = settings;
  def.settings.default_material = c.material();
  def.articulations.push_back(floorBox());
  double top = 0;
  for (int i = 0; i < n; ++i) {
    top -= (n - i) * c.restDepth();
    const Vector3 aside(jitter * elementary::sin(1.7 * i), jitter * elementary::cos(2.3 * i), 0);
    def.articulations.push_back(
        cube("cube" + std::to_string(i), c, Pose(Vector3(aside + Vector3(0, 0, top + c.size / 2)))));
    top += c.size;
  }
  return def;
}

}  // namespace haptic::scenes
