/// Heaps: N ≤ 300 cubes of 5 cm and 0.1 kg in random orientations, over a bin of five boxes that touch.
#pragma once
#include "blocks.h"
#include "heap_poses.h"

namespace haptic::scenes {

struct HeapParameters {
  int count = 10;
  double stiffness = 1e8;   ///< k [N/m³]
  double mu = 0.5;
  double mass_ratio = 1;    ///< of every second cube over the others, which have 0.1 kg
};

/// Links 0…4 are floor and walls, then come the cubes: in layers of a square grid, so many a row that 300 make twelve.
inline WorldDef heap(const HeapParameters& p, const WorldSettings& settings) {
  constexpr double kSize = 0.05, kPitch = 0.075, kLayer = 0.09, kWall = 0.2, kHeight = 2;
  WorldDef def;
  def.name = "heap of " + std::to_string(p.count);
  def.settings = settings;
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = p.stiffness;
  m.dissipation = 10;
  m.mu_static = m.mu_dynamic = p.mu;
  const int side = p.count <= 10 ? 2 : p.count <= 100 ? 4 : 5;
  const double inner = side * kPitch + 0.02, out = 0.5 * (inner + kWall), z = 0.5 * kHeight;
  const double length = inner + 2 * kWall;
  def.articulations.push_back(staticBox("floor", Vector3(inner + 1, inner + 1, 0.5), Pose(Vector3(0, 0, -0.25))));
  def.articulations.push_back(staticBox("wall_px", Vector3(kWall, length, kHeight), Pose(Vector3(out, 0, z))));
  def.articulations.push_back(staticBox("wall_nx", Vector3(kWall, length, kHeight), Pose(Vector3(-out, 0, z))));
  def.articulations.push_back(staticBox("wall_py", Vector3(inner, kWall, kHeight), Pose(Vector3(0, out, z))));
  def.articulations.push_back(staticBox("wall_ny", Vector3(inner, kWall, kHeight), Pose(Vector3(0, -out, z))));
  const auto shape = box(Vector3::Constant(kSize));
  for (int i = 0; i < p.count; ++i) {
    const int layer = i / (side * side), row = i / side % side, column = i % side;
    const Vector3 place((column - 0.5 * (side - 1)) * kPitch, (row - 0.5 * (side - 1)) * kPitch, 0.05 + layer * kLayer);
    const double* turn = kHeapTurns[i];
    const Matrix3 R = rotationFromRpy(Vector3(turn[0], turn[1], turn[2]));
    const double mass = i % 2 == 0 ? 0.1 : 0.1 * p.mass_ratio;
    def.articulations.push_back(freeBody("c" + std::to_string(i), shape, mass,
                                         boxInertia(Vector3::Constant(kSize), mass), Pose(R, place)));
  }
  return def;
}

}  // namespace haptic::scenes
