/// Scenes in motion whose balances are known: two tumbling crosses, a table, dominoes, a rolling hexagon, a rod that is hit.
#pragma once
#include <vector>

#include "blocks.h"

namespace haptic::scenes {

inline Matrix3 turnXZ(double x, double z) {
  return rotationAbout(Vector3::UnitX(), x) * rotationAbout(Vector3::UnitZ(), z);
}

/// Three bars of 10 × 1 × 1 cm and 0.1 kg through one centre.
inline ArticulationDef crossOfBars(const std::string& name, const Pose& X_WL, const Twist& V_WL) {
  constexpr double kMass = 0.1;
  Matrix3 inertia = Matrix3::Zero();
  ArticulationDef def = freeBody(name, nullptr, 3 * kMass, Matrix3::Identity(), X_WL, V_WL);
  for (int axis = 0; axis < 3; ++axis) {
    Vector3 size = Vector3::Constant(0.01);
    size[axis] = 0.1;
    inertia += boxInertia(size, kMass);
    CollisionDef bar;
    bar.name = name + std::to_string(axis);
    bar.shape = box(size);
    def.links[0].collisions.push_back(bar);
  }
  def.links[0].inertia.I_C = inertia;
  return def;
}

/// Two such bodies that meet in free space.
inline WorldDef crosses(WorldSettings settings) {
  WorldDef def;
  def.name = "crosses";
  settings.gravity = Vector3::Zero();
  def.settings = settings;
  def.settings.default_material.stiffness = 1e9;  // 1e5 N/m on 1 cm²
  def.settings.default_material.mu_static = def.settings.default_material.mu_dynamic = 0.5;
  const Pose X_WA(turnXZ(0.2, 0.3), Vector3(-0.09, 0, 0)), X_WB(turnXZ(0.4, 0.3), Vector3(0.09, 0.02, 0));
  def.articulations.push_back(crossOfBars("A", X_WA, {Vector3(0.1, 0.4, 5), Vector3(0.5, 0, 0)}));
  def.articulations.push_back(crossOfBars("B", X_WB, {Vector3(0.3, -3, 0.2), Vector3(-0.5, 0, 0)}));
  return def;
}

/// A top of 0.7 × 0.7 × 0.1 m on four legs of 4 × 4 cm, 8 kg, of leg stiffness K = 4e5 N/m; the floor under one leg lies
/// lower by `lower`. The legs' lower ends are at z = -depth.
inline WorldDef table(const WorldSettings& settings, double lower, double depth) {
  constexpr double kLeg = 0.04, kHeight = 0.3, kMass = 8, kStiffness = 4e5;
  WorldDef def;
  def.name = "table";
  def.settings = settings;
  def.settings.default_material.stiffness = kStiffness / (kLeg * kLeg);
  for (int i = 0; i < 4; ++i) {
    const Vector3 at(i & 1 ? 0.3 : -0.3, i & 2 ? 0.3 : -0.3, -0.1 - (i == 0 ? lower : 0.0));
    def.articulations.push_back(staticBox("floor" + std::to_string(i), Vector3(0.2, 0.2, 0.2), Pose(at)));
  }
  ArticulationDef body = freeBody("table", nullptr, kMass, boxInertia(Vector3(0.7, 0.7, 0.1), kMass),
                                  Pose(Vector3(0, 0, kHeight + 0.05 - depth)));
  CollisionDef top;
  top.name = "top";
  top.shape = box(Vector3(0.7, 0.7, 0.1));
  body.links[0].collisions.push_back(top);
  for (int i = 0; i < 4; ++i) {
    CollisionDef leg;
    leg.name = "leg" + std::to_string(i);
    leg.shape = box(Vector3(kLeg, kLeg, kHeight));
    leg.X_LS = Pose(Vector3(i & 1 ? 0.3 : -0.3, i & 2 ? 0.3 : -0.3, -0.05 - kHeight / 2));
    body.links[0].collisions.push_back(leg);
  }
  def.articulations.push_back(body);
  return def;
}

/// Twelve stones of 48 × 24 × 7.5 mm, pitch 24 mm, the first tilted by `share` of its tip angle.
inline WorldDef dominoes(const WorldSettings& settings, double share) {
  constexpr double kHeight = 0.048, kWidth = 0.024, kThick = 0.0075, kMass = 0.005, kPitch = 0.024;
  WorldDef def;
  def.name = "dominoes";
  def.settings = settings;
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = 1e7;
  m.mu_static = m.mu_dynamic = 0.3;
  def.articulations.push_back(floorBox());
  const double angle = share * elementary::atan2(kThick, kHeight);
  for (int i = 0; i < 12; ++i) {
    Pose X(Vector3(i * kPitch, 0, kHeight / 2));
    if (i == 0) {  // about its lower front edge
      X.R = rotationAbout(Vector3::UnitY(), angle);
      X.p = Vector3(kThick / 2, 0, 0) + X.R * Vector3(-kThick / 2, 0, kHeight / 2);
    }
    def.articulations.push_back(freeBox("stone" + std::to_string(i), Vector3(kThick, kWidth, kHeight), kMass, X));
  }
  return def;
}

/// A hexagonal prism of circumradius 5 cm, 10 cm long, 0.3 kg, on a slope of 12°, started on an edge at `speed` [rad/s].
inline WorldDef hexagon(WorldSettings settings, double stiffness, double speed) {
  constexpr double kRadius = 0.05, kLength = 0.1, kMass = 0.3, kSlope = 12 * M_PI / 180;
  WorldDef def;
  def.name = "hexagon";
  settings.gravity = kGravity * Vector3(elementary::sin(kSlope), 0, -elementary::cos(kSlope));
  def.settings = settings;
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = stiffness;
  m.mu_static = m.mu_dynamic = 1;
  m.dissipation = 100;
  def.articulations.push_back(floorBox(20));
  const auto prism = std::make_shared<ConvexPolyhedron>(makeCylinder(kRadius, kLength, 6));
  const double along = kMass * kRadius * kRadius * 5 / 12,  // of a hexagon about its axis
      across = kMass * (kRadius * kRadius * 5 / 24 + kLength * kLength / 12);
  Matrix3 R;  // its axis along y, a corner down
  R.col(2) = Vector3::UnitY();
  R.col(0) = -Vector3::UnitZ();
  R.col(1) = R.col(2).cross(R.col(0));
  ArticulationDef body = freeBody("hexagon", prism, kMass, Vector3(across, across, along).asDiagonal(),
                                  Pose(R, Vector3(-8, 0, kRadius)), {Vector3(0, speed, 0), Vector3(speed * kRadius, 0, 0)});
  def.articulations.push_back(body);
  return def;
}

/// A rod of 0.6 m and 1 kg that hangs on a hinge, and a cube of 0.2 kg that flies at 2 m/s flat against it, 0.5 m below the
/// hinge. Elastic: then ω = kRodRate and the cube's speed kCubeSpeed. Contact stiffness 1e7 N/m.
constexpr double kRodRate = 40.0 / 17, kCubeSpeed = -14.0 / 17;
inline WorldDef rodAndCube(WorldSettings settings, double stiffness = 1e7) {
  constexpr double kLength = 0.6, kRod = 0.04, kCube = 0.04;
  WorldDef def;
  def.name = "rod and cube";
  settings.gravity = Vector3::Zero();
  def.settings = settings;
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = stiffness / (kCube * kRod);
  m.dissipation = 0;
  m.mu_static = m.mu_dynamic = 0;
  ArticulationDef rod = freeBody("rod", nullptr, 1, boxInertia(Vector3(0, 0, kLength), 1), Pose());
  LinkDef& link = rod.links[0];
  link.joint.type = JointType::kRevolute;
  link.joint.axis = -Vector3::UnitY();
  link.inertia.p_LC = Vector3(0, 0, -kLength / 2);
  CollisionDef shape;
  shape.name = "rod";
  shape.shape = box(Vector3(kRod, kRod, kLength));
  shape.X_LS = Pose(Vector3(0, 0, -kLength / 2));
  link.collisions.push_back(shape);
  def.articulations.push_back(rod);
  const Vector3 start(-(kRod + kCube) / 2 - 0.0037, 0, -0.5);  // touches inside a step
  def.articulations.push_back(freeBox("cube", Vector3::Constant(kCube), 0.2, Pose(start), {Vector3::Zero(), Vector3(2, 0, 0)}));
  return def;
}

}  // namespace haptic::scenes
