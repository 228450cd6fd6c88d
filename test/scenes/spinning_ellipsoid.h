/// An ellipsoid that spins on a floor without friction and without losses: what it has of energy it keeps.
#pragma once
#include <algorithm>
#include <cmath>
#include <memory>

#include "../comparators/velocity_verlet.h"
#include "blocks.h"
#include "haptic_core/geometry/shapes/ellipsoid.h"

namespace haptic::scenes {

/// Tilted by 0.3 rad and spun at 30 rad/s about a tilted axis, it nods, turns and is pushed about by a floor of 1e7 N/m³.
struct SpinningEllipsoid {
  const Vector3 radii{0.06, 0.045, 0.03};  ///< [m]
  const double mass = 0.4;                 ///< [kg]
  const double stiffness = 1e7;            ///< [N/m³]

  /// By velocity Verlet in steps of `h` [s].
  WorldDef def(double h) const {
    WorldDef def;
    def.settings.step = h;
    def.settings.comparator = comparators::velocityVerlet;
    def.settings.gravity = Vector3(0, 0, -kGravity);
    def.settings.energy_ledger = true;
    ContactMaterial& m = def.settings.default_material;
    m.stiffness = stiffness;
    m.dissipation = 0;
    m.mu_static = m.mu_dynamic = 0;
    def.articulations.push_back(floorBox());
    const auto shape = std::make_shared<Ellipsoid>(radii);
    const Matrix3 R = rotationAbout(Vector3(1, 0.5, 0).normalized(), 0.3);
    const double height = radii.cwiseProduct(R.transpose() * Vector3::UnitZ()).norm() - 1e-3;
    const Twist spin{Vector3(2, -1, 30), Vector3::Zero()};
    def.articulations.push_back(
        freeBody("ellipsoid", shape, mass, shape->massProperties(mass / shape->volume()).I_com, Pose(R, Vector3(0, 0, height)), spin));
    return def;
  }

  /// Largest change of the total energy over that at the start, in `seconds`.
  double energyError(double h, double seconds) const {
    World world(def(h));
    world.step();
    const double start = world.report().energy.total();
    double worst = 0;
    for (int i = 1; i < std::lround(seconds / h); ++i) {
      world.step();
      worst = std::max(worst, std::abs(world.report().energy.total() / start - 1));
    }
    return worst;
  }
};

}  // namespace haptic::scenes
