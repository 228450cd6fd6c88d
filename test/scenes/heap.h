/// Heaps: N ≤ 300 bodies in random orientations, over a bin of five boxes that touch.
#pragma once
#include <cstdint>
#include <random>

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

/// Bodies of a heap, 0.1 kg each unless said, homogeneous.
enum class HeapKind {
  kCubes,   ///< edges of 5 cm
  kHulls,   ///< of 8, 20 and 60 points on a sphere of 3 cm, in turn
  kRods,    ///< boxes 120 × 12 × 12 mm
  kPlates,  ///< boxes 100 × 80 × 6 mm
  kMixed,   ///< boxes with edges uniform in 1…10 cm, 800 kg/m³
  kRatio,   ///< cubes of 5 cm, masses log-uniform in 1 g…1 kg
  kRound,   ///< ball r 2.5 cm, capsule r 1.5 cm with 4 cm between its centres, cylinder r 2 cm × 4 cm, in turn
  kTubes    ///< cylinders r 2 cm × 5 cm
};

/// Uniform numbers, the same on every system.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {}
  double uniform(double low, double high) { return low + (high - low) * std::ldexp(static_cast<double>(random_() >> 11), -53); }

 private:
  std::mt19937_64 random_;
};

/// Hull of so many points on a sphere of radius r [m], the i-th of the golden spiral moved by up to a tenth of its spacing.
inline std::shared_ptr<const ConvexPolyhedron> sphereHull(int points, double r, Dice& dice) {
  constexpr double kGoldenAngle = 2.399963229728653;  // π (3 - √5)
  std::vector<Vector3> vertices;
  for (int i = 0; i < points; ++i) {
    const double z = 1 - (2 * i + 0.5 + dice.uniform(0, 1)) / points, across = std::sqrt(std::max(0.0, 1 - z * z)),
                 turn = kGoldenAngle * i + dice.uniform(-0.1, 0.1);
    vertices.push_back(r * Vector3(across * elementary::cos(turn), across * elementary::sin(turn), z));
  }
  return std::make_shared<ConvexPolyhedron>(ConvexPolyhedron::hull(vertices));
}

/// The bodies of a kind in turn, and the masses: the i-th has the i-th of each, from the start again after the last [kg].
struct HeapBodies {
  std::vector<std::shared_ptr<const ConvexShape>> shapes;
  std::vector<double> masses = {0.1};
};

inline HeapBodies heapBodies(HeapKind kind, int count) {
  HeapBodies bodies;
  Dice dice(20260727);
  switch (kind) {
    case HeapKind::kCubes: bodies.shapes = {box(Vector3::Constant(0.05))}; break;
    case HeapKind::kHulls:
      for (const int points : {8, 20, 60}) bodies.shapes.push_back(sphereHull(points, 0.03, dice));
      break;
    case HeapKind::kRods: bodies.shapes = {box(Vector3(0.12, 0.012, 0.012))}; break;
    case HeapKind::kPlates: bodies.shapes = {box(Vector3(0.1, 0.08, 0.006))}; break;
    case HeapKind::kMixed:
      bodies.masses.clear();
      for (int i = 0; i < count; ++i) {
        const double x = dice.uniform(0.01, 0.1), y = dice.uniform(0.01, 0.1), z = dice.uniform(0.01, 0.1);
        bodies.shapes.push_back(box(Vector3(x, y, z)));
        bodies.masses.push_back(800 * x * y * z);
      }
      break;
    case HeapKind::kRatio:
      bodies.shapes = {box(Vector3::Constant(0.05))};
      bodies.masses.clear();
      for (int i = 0; i < count; ++i) bodies.masses.push_back(elementary::exp(dice.uniform(elementary::log(1e-3), 0)));
      break;
    case HeapKind::kRound:
      bodies.shapes = {std::make_shared<Ball>(0.025), std::make_shared<Rod>(0.015, 0.04, Rod::Ends::kRound),
                       std::make_shared<Rod>(0.02, 0.04, Rod::Ends::kFlat)};
      break;
    case HeapKind::kTubes: bodies.shapes = {std::make_shared<Rod>(0.02, 0.05, Rod::Ends::kFlat)}; break;
  }
  return bodies;
}

/// The default material, but for friction and stiffness k [N/m³]; the default step and method.
inline WorldDef heapOf(HeapKind kind, int count, double stiffness) {
  const bool wide = kind == HeapKind::kRods || kind == HeapKind::kPlates || kind == HeapKind::kMixed;
  const double pitch = wide ? 0.13 : 0.085, layer = wide ? 0.13 : 0.09;
  constexpr double kLowest = 0.08;
  WorldDef def;
  def.name = "heap of " + std::to_string(count);
  def.settings.step = 1e-3;
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = stiffness;
  m.mu_static = 0.5;
  m.mu_dynamic = 0.4;
  const int side = std::max(2, static_cast<int>(std::lround(elementary::cbrt(0.5 * count))));
  addBin(side * pitch + 0.02, def);
  const HeapBodies bodies = heapBodies(kind, count);
  for (int i = 0; i < count; ++i) {
    const auto& shape = bodies.shapes[i % bodies.shapes.size()];
    const double mass = bodies.masses[i % bodies.masses.size()], density = mass / shape->massProperties(1).mass;
    def.articulations.push_back(freeBody("b" + std::to_string(i), shape, mass, shape->massProperties(density).I_com,
                                         heapPose(i, side, pitch, kLowest, layer)));
  }
  return def;
}

}  // namespace haptic::scenes
