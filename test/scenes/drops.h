/// Cards, plates, needles and prisms that are dropped on ground, smooth or rough by micrometres, at 1e8 to 1e14 N/m³.
#pragma once
#include <cmath>
#include <memory>
#include <random>

#include "ground.h"

namespace haptic::scenes {

constexpr double kDropNoise = 1e-6;  ///< of rough ground [m]

/// Numbers of one run.
class DropDice {
 public:
  explicit DropDice(int seed) : random_(static_cast<unsigned>(seed)) {}
  double uniform(double low, double high) { return low + (high - low) * (random_() / 4294967296.0); }
  double logUniform(double low, double high) { return low * elementary::exp(elementary::log(high / low) * uniform(0, 1)); }

 private:
  std::mt19937 random_;
};

/// Run `seed` of 2000: a body, articulation 1, that is tilted, up to 2 cm above ground, and in most runs moves.
inline WorldDef drop(int seed) {
  constexpr double kStiffnesses[] = {1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14}, kFrictions[] = {0, 0.1, 0.5};
  DropDice random(seed);
  WorldDef def;
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = kStiffnesses[seed % 7];
  m.mu_static = m.mu_dynamic = kFrictions[seed / 7 % 3];
  if (seed / 21 % 2 == 0) {
    def.articulations.push_back(floorBox());
  } else {
    def.articulations.push_back(
        staticPieces("ground", groundOf(heightGrid(3, 1, [&](double, double) { return kDropNoise * random.uniform(-1, 1); }))));
  }
  Vector3 size;
  std::shared_ptr<const ConvexPolyhedron> shape;
  switch (seed % 4) {
    case 0: size = Vector3(0.09, 0.06, random.logUniform(5e-4, 2e-3)); break;
    case 1: size = Vector3(random.uniform(0.05, 0.2), random.uniform(0.05, 0.2), random.logUniform(1e-3, 1e-2)); break;
    case 2: size = Vector3(random.logUniform(5e-4, 5e-3), random.logUniform(5e-4, 5e-3), random.uniform(0.05, 0.2)); break;
    default: size = Vector3::Constant(random.uniform(0.01, 0.05)); size.z() *= random.logUniform(0.2, 5);
  }
  shape = seed % 4 == 3 ? std::make_shared<ConvexPolyhedron>(makeCylinder(0.5 * size.x(), size.z(), 3 + seed % 5)) : box(size);
  const double mass = random.logUniform(150, 8000) * size.prod();
  const double tilt = seed % 2 ? random.logUniform(1e-4, 1) : random.uniform(0, 1.5);
  const Matrix3 R = rotationFromRpy(Vector3(tilt * random.uniform(-1, 1), tilt * random.uniform(-1, 1), random.uniform(-3, 3)));
  const double below = 0.5 * (R.row(2).cwiseAbs() * size)(0);
  const Twist V{Vector3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)) * random.uniform(0, 5),
                Vector3(random.uniform(-0.5, 0.5), 0, -random.uniform(0, 0.5))};
  def.articulations.push_back(freeBody("body", shape, mass, boxInertia(size, mass),
                                       Pose(R, Vector3(0.05, 0.03, below + 2 * kDropNoise + random.uniform(0, 0.02))), V));
  return def;
}

}  // namespace haptic::scenes
