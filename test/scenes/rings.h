/// Closed chains in the plane: a free ring of hinged links, and a roller chain on two sprockets.
#pragma once
#include "blocks.h"
#include "haptic_core/geometry/shapes/rod.h"

namespace haptic::scenes {

constexpr double kRingLink = 0.04;      ///< from hinge to hinge [m]
constexpr double kRingLinkMass = 0.02;  ///< [kg]

/// Link `index` of a chain whose links turn about z: its frame is at the hinge, x along it. The first floats.
inline LinkDef ringLink(int index, double angle) {
  LinkDef link;
  link.name = "l" + std::to_string(index);
  link.parent = index - 1;
  link.joint.name = "j" + std::to_string(index);
  link.joint.type = index == 0 ? JointType::kFloating : JointType::kRevolute;
  link.joint.axis = Vector3::UnitZ();
  if (index > 0) {
    link.joint.X_PJ = Pose(Vector3(kRingLink, 0, 0));
    link.joint.position = angle;
  }
  link.inertia.mass = kRingLinkMass;
  link.inertia.p_LC = Vector3(kRingLink / 2, 0, 0);
  link.inertia.I_C = Vector3(2e-6, 8e-6, 8e-6).asDiagonal();
  return link;
}

/// The last link of articulation `chain` held to its first.
inline LoopDef ringClosure(const WorldDef& def, int chain, LoopDef::Type type) {
  LoopDef loop;
  loop.name = "closure";
  loop.articulation_a = loop.articulation_b = chain;
  loop.link_a = static_cast<int>(def.articulations[chain].links.size()) - 1;
  loop.link_b = 0;
  loop.X_AF = Pose(Vector3(kRingLink, 0, 0));
  loop.type = type;
  return loop;
}

/// A regular polygon of links without gravity, one of whose hinges turns at `rate` [rad/s] at the start; the first step takes the
/// part of that motion that would open the ring. `R`: how it lies in W.
inline WorldDef freeRing(int links, LoopDef::Type closure, double rate, const Matrix3& R = Matrix3::Identity()) {
  WorldDef def;
  def.settings.gravity.setZero();
  ArticulationDef chain;
  chain.name = "ring";
  chain.X_WA.R = R;
  for (int i = 0; i < links; ++i) chain.links.push_back(ringLink(i, 2 * M_PI / links));
  chain.links[2].joint.velocity = rate;
  def.articulations.push_back(std::move(chain));
  def.loops.push_back(ringClosure(def, 0, closure));
  return def;
}

/// Twelve links on two sprockets of six teeth; the first sprocket has a drive of effort, both a damper of .05 N·m·s/rad. The chain lies
/// on a plate. k 1e10, no friction.
inline WorldDef rollerChain(LoopDef::Type closure) {
  constexpr double kHub = 0.03, kTooth = 0.0105, kRoller = 0.009, kAxles = 0.12, kPitchRadius = kRingLink;
  WorldDef def;
  def.settings.default_material.stiffness = 1e10;
  def.settings.default_material.mu_static = def.settings.default_material.mu_dynamic = 0;
  const auto cylinder = [](double radius, double length, const Vector3& p_LS) {
    CollisionDef part;
    part.shape = std::make_shared<Rod>(radius, length, Rod::Ends::kFlat);
    part.X_LS = Pose(p_LS);
    return part;
  };
  for (int s = 0; s < 2; ++s) {
    ArticulationDef sprocket;
    sprocket.name = "s" + std::to_string(s);
    LinkDef link;
    link.name = sprocket.name;
    link.joint.name = "j_" + sprocket.name;
    link.joint.type = JointType::kRevolute;
    link.joint.axis = Vector3::UnitZ();
    link.joint.X_PJ = Pose(Vector3(s * kAxles, 0, 0));
    link.joint.damping = 0.05;
    if (s == 0) link.joint.drive = JointDef::Drive::kEffort;
    link.inertia.mass = 0.3;
    link.inertia.I_C = Vector3(1.3e-4, 1.3e-4, 2.4e-4).asDiagonal();
    link.collisions.push_back(cylinder(kHub, 0.02, Vector3::Zero()));
    for (int tooth = 0; tooth < 6; ++tooth) {  // between the rollers, which lie at 90° and every 60° from there
      const double angle = M_PI / 3 * tooth, r = kPitchRadius * elementary::cos(M_PI / 6);
      link.collisions.push_back(cylinder(kTooth, 0.016, Vector3(r * elementary::cos(angle), r * elementary::sin(angle), 0)));
    }
    sprocket.links.push_back(std::move(link));
    def.articulations.push_back(std::move(sprocket));
  }
  ArticulationDef chain;
  chain.name = "chain";
  chain.X_WA = Pose(Vector3(kAxles, kPitchRadius, 0));
  chain.X_WA.R = rotationAbout(Vector3::UnitZ(), -M_PI / 6);
  const int sixths[] = {0, -2, -2, -1, 0, 0, -1, -2, -2, -1, 0, 0};  // turns of the links, in 30°
  for (int i = 0; i < 12; ++i) {
    LinkDef link = ringLink(i, M_PI / 6 * sixths[i]);
    link.collisions.push_back(cylinder(kRoller, 0.02, Vector3::Zero()));
    chain.links.push_back(std::move(link));
  }
  for (int a = 0; a < 12; ++a) {
    for (int b = a + 1; b < 12; ++b) def.filters.push_back({2, a, 2, b});
  }
  def.articulations.push_back(std::move(chain));
  def.loops.push_back(ringClosure(def, 2, closure));
  def.articulations.push_back(staticBox("plate", Vector3(0.6, 0.4, 0.02), Pose(Vector3(kAxles / 2, 0, -0.021))));
  return def;
}

}  // namespace haptic::scenes
