/// Heaps: N ≤ 300 bodies of 0.1 kg in random orientations, over a bin of five boxes that touch: cubes of 5 cm, or round bodies.
#pragma once
#include "blocks.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "heap_poses.h"

namespace haptic::scenes {

struct HeapParameters {
  int count = 10;
  double stiffness = 1e8;   ///< k [N/m³]
  double mu = 0.5;
  double mass_ratio = 1;    ///< of every second cube over the others, which have 0.1 kg
};

constexpr int kFirstOfHeap = 5;  ///< link: 0…4 are floor and walls

/// Floor and walls of a bin of inner width `inner` [m].
inline void addBin(double inner, WorldDef& def) {
  constexpr double kWall = 0.2, kHeight = 2;
  const double out = 0.5 * (inner + kWall), z = 0.5 * kHeight, length = inner + 2 * kWall;
  def.articulations.push_back(staticBox("floor", Vector3(inner + 1, inner + 1, 0.5), Pose(Vector3(0, 0, -0.25))));
  def.articulations.push_back(staticBox("wall_px", Vector3(kWall, length, kHeight), Pose(Vector3(out, 0, z))));
  def.articulations.push_back(staticBox("wall_nx", Vector3(kWall, length, kHeight), Pose(Vector3(-out, 0, z))));
  def.articulations.push_back(staticBox("wall_py", Vector3(inner, kWall, kHeight), Pose(Vector3(0, out, z))));
  def.articulations.push_back(staticBox("wall_ny", Vector3(inner, kWall, kHeight), Pose(Vector3(0, -out, z))));
}

/// Where body i of a heap begins: in layers of a square grid of `side` a row, in an orientation of its own.
inline Pose heapPose(int i, int side, double pitch, double lowest, double layer_height) {
  const int layer = i / (side * side), row = i / side % side, column = i % side;
  const double* turn = kHeapTurns[i];
  return {rotationFromRpy(Vector3(turn[0], turn[1], turn[2])),
          Vector3((column - 0.5 * (side - 1)) * pitch, (row - 0.5 * (side - 1)) * pitch, lowest + layer * layer_height)};
}

/// Cubes, so many a row that 300 make twelve layers.
inline WorldDef heap(const HeapParameters& p, const WorldSettings& settings) {
  constexpr double kSize = 0.05, kPitch = 0.075, kLayer = 0.09;
  WorldDef def;
  def.name = "heap of " + std::to_string(p.count);
  def.settings = settings;
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = p.stiffness;
  m.dissipation = 10;
  m.mu_static = m.mu_dynamic = p.mu;
  const int side = p.count <= 10 ? 2 : p.count <= 100 ? 4 : 5;
  addBin(side * kPitch + 0.02, def);
  const auto shape = box(Vector3::Constant(kSize));
  for (int i = 0; i < p.count; ++i) {
    const double mass = i % 2 == 0 ? 0.1 : 0.1 * p.mass_ratio;
    def.articulations.push_back(freeBody("c" + std::to_string(i), shape, mass, boxInertia(Vector3::Constant(kSize), mass),
                                         heapPose(i, side, kPitch, 0.05, kLayer)));
  }
  return def;
}

/// `tubes`: cylinders of radius 2 cm and length 5 cm. `round`: a ball of radius 2.5 cm, a capsule of radius 1.5 cm whose centres are
/// 4 cm apart, a cylinder of radius 2 cm and length 4 cm, in turn. All homogeneous, of 0.1 kg.
enum class RoundHeap { kTubes, kRound };

/// The default material, but for friction and stiffness k [N/m³]; the default step and method.
inline WorldDef roundHeap(RoundHeap kind, int count, double stiffness) {
  constexpr double kPitch = 0.085, kLayer = 0.09, kLowest = 0.08, kMass = 0.1;
  WorldDef def;
  def.name = (kind == RoundHeap::kTubes ? "tubes" : "round") + std::to_string(count);
  def.settings.step = 1e-3;
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = stiffness;
  m.mu_static = 0.5;
  m.mu_dynamic = 0.4;
  const int side = std::max(2, static_cast<int>(std::lround(elementary::cbrt(0.5 * count))));
  addBin(side * kPitch + 0.02, def);
  std::vector<std::shared_ptr<const ConvexShape>> shapes;
  if (kind == RoundHeap::kTubes) {
    shapes = {std::make_shared<Rod>(0.02, 0.05, Rod::Ends::kFlat)};
  } else {
    shapes = {std::make_shared<Ball>(0.025), std::make_shared<Rod>(0.015, 0.04, Rod::Ends::kRound),
              std::make_shared<Rod>(0.02, 0.04, Rod::Ends::kFlat)};
  }
  for (int i = 0; i < count; ++i) {
    const auto& shape = shapes[i % shapes.size()];
    const double density = kMass / shape->massProperties(1).mass;
    def.articulations.push_back(freeBody("b" + std::to_string(i), shape, kMass, shape->massProperties(density).I_com,
                                         heapPose(i, side, kPitch, kLowest, kLayer)));
  }
  return def;
}

}  // namespace haptic::scenes
