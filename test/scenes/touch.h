/// What a hand touches in tests of the loop: bodies of one shape, and a pointer over a wall.
#pragma once
#include "blocks.h"

namespace haptic::scenes {

/// A body of one shape, 0.1 kg, whose foundation has no damper: forces are those of the spring alone.
inline ArticulationDef springyBody(const std::string& name, const ConvexPolyhedron& shape, JointType type, const Vector3& p,
                                   double stiffness) {
  ArticulationDef def = freeBody(name, std::make_shared<ConvexPolyhedron>(shape), 0.1, 1e-5 * Matrix3::Identity(), Pose(p));
  def.links[0].joint.type = type;
  ContactMaterial& material = def.links[0].collisions[0].material;
  material.stiffness = stiffness;
  material.dissipation = 0;
  return def;
}

/// Makes the first link of an articulation a pointer.
inline void addPointer(WorldDef& world, int articulation, const std::string& device = {}) {
  PointerDef pointer;
  pointer.device = device;
  pointer.articulation = articulation;
  pointer.link = 0;
  world.pointers.push_back(pointer);
}

/// A free pointer at height `z` [m] over a fixed wall whose face is the plane z = 0.
inline WorldDef pointerOverWall(const ConvexPolyhedron& pointer, double z, double stiffness, double step) {
  WorldDef world;
  world.name = "wall";
  world.settings.step = step;
  world.articulations.push_back(springyBody("wall", makeBox({1, 1, 0.1}), JointType::kFixed, {0, 0, -0.05}, stiffness));
  world.articulations.push_back(springyBody("pointer", pointer, JointType::kFloating, {0, 0, z}, stiffness));
  addPointer(world, 1);
  return world;
}

}  // namespace haptic::scenes
