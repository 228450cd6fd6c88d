/// Bodies that roll on a plane: how much of their motion is left, against the rigid motion (rolling_reference.py and closed forms).
#include <algorithm>
#include <cmath>
#include <memory>

#include "../scenes/balls.h"
#include "figure.h"
#include "haptic_core/geometry/shapes/cone.h"
#include "haptic_core/geometry/shapes/ellipsoid.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "haptic_core/geometry/volume/contact_workspace.h"
#include "right_figures.h"
#include "rolling_reference.h"

namespace haptic::bench {
namespace {

using scenes::kGravity;

/// How a body is put on a plane, and what it is made of.
struct Roller {
  std::shared_ptr<const ConvexShape> shape;
  double mass = 0;
  Matrix3 inertia = Matrix3::Identity(), R_WB = Matrix3::Identity();
  double stiffness = 1e8, dissipation = DefaultMaterial::kDissipation, step = 1e-3, mu = 0.8;
  bool torsion = true;
  Matrix3 R_WG = Matrix3::Identity();  ///< of the plane

  /// At the height at which the plane carries its weight, and its lowest point at rest.
  WorldDef make(const Vector3& turn) const {
    WorldDef def;
    def.settings.step = step;
    def.settings.torsional_friction = torsion;
    ContactMaterial& m = def.settings.default_material;
    m.stiffness = stiffness;
    m.dissipation = dissipation;
    m.mu_static = m.mu_dynamic = mu;
    def.articulations.push_back(scenes::groundPlane(Pose(R_WG, Vector3::Zero())));
    const Matrix3 R_GB = R_WG.transpose() * R_WB;
    const Vector3 lowest = shape->core(R_GB.transpose() * -Vector3::UnitZ());
    const Vector3 up = R_WG.col(2);
    const double surface = shape->rounding() - R_GB.row(2).dot(lowest);
    const Pose X_WB(R_WB, (surface - restDepth(R_GB, surface)) * up);
    const Vector3 to_floor = -shape->rounding() * up + R_WB * lowest;
    def.articulations.push_back(scenes::freeBody("body", shape, mass, inertia, X_WB, {turn, -turn.cross(to_floor)}));
    return def;
  }

 private:
  double restDepth(const Matrix3& R_GB, double surface) const {
    const HalfSpace plane;
    ContactWorkspace workspace;
    workspace.reserve(plane, *shape);
    const double load = mass * kGravity * R_WG(2, 2);
    double low = 0, high = 0.1 * surface;
    for (int i = 0; i < 80; ++i) {
      const double depth = 0.5 * (low + high);
      ContactVolume volume;
      PairCache cache;
      contactVolume(plane, *shape, Pose(R_GB, Vector3(0, 0, surface - depth)), cache, workspace, volume);
      const double force = volume.status == ContactVolume::Status::kOverlap ? stiffness * volume.volume : 0;
      (force < load ? low : high) = depth;
    }
    return 0.5 * (low + high);
  }
};

double energyOf(const World& world, const Roller& roller) {
  const Pose X = world.linkPose(1);
  const Twist V = world.linkTwist(1);
  const Vector3 w = X.R.transpose() * V.angular;
  return 0.5 * (roller.mass * V.linear.squaredNorm() + w.dot(roller.inertia * w)) + roller.mass * kGravity * X.p.z();
}

struct Kept {
  double damped, plain;  ///< of the start's energy
};

/// Euler's disk on its edge, its centre at rest, after 0.3 s.
Kept coinKept(double tilt, double k, double step) {
  constexpr double kRadius = 0.0375, kThickness = 0.001, kMass = 0.1;
  Roller coin;
  coin.shape = std::make_shared<Rod>(kRadius, kThickness, Rod::Ends::kFlat);
  coin.mass = kMass;
  coin.inertia = coin.shape->massProperties(kMass / coin.shape->volume()).I_com;
  coin.stiffness = k;
  coin.step = step;
  coin.torsion = false;
  const double sine = elementary::sin(tilt), cosine = elementary::cos(tilt);
  coin.R_WB << cosine, 0, sine, 0, 1, 0, -sine, 0, cosine;
  const double spin = -2 * std::sqrt(kGravity / (kRadius * sine)) * sine;
  const auto kept = [&](double dissipation) {
    coin.dissipation = dissipation;
    WorldDef def = coin.make(spin * Vector3(-cosine, 0, sine));
    def.articulations[1].V_WA.linear.setZero();
    World world(def);
    const double start = energyOf(world, coin);
    while (world.time() < 0.3 - 0.5 * step) world.step();
    return energyOf(world, coin) / start;
  };
  return {kept(DefaultMaterial::kDissipation), kept(0)};
}

void runCoins() {
  double least = 1, least_plain = 1;
  for (const double tilt : {0.05, 0.1, 0.35, 0.7, 1.2}) {
    for (const double k : {1e8, 1e9, 1e10, 1e11, 1e12}) {
      for (const double step : {1e-3, 1e-4}) {
        const Kept kept = coinKept(tilt, k, step);
        std::printf("coin: tilt %.2f, k %.0e, h %.0e: %.4f of its energy, %.4f without damper\n", tilt, k, step, kept.damped, kept.plain);
        least = std::min(least, kept.damped / kept.plain);
        if (step == 1e-3) least_plain = std::min(least_plain, kept.plain);
      }
    }
  }
  figure("roll.coin_kept", least, "1");
  figure("roll.coin_kept_undamped", least_plain, "1");
}

/// An egg that rocks for 15 swings: its largest tilt in the last one, and its period.
void runEggs() {
  double error = 0, period_error = 0;
  for (const double k : {1e8, 1e9, 1e10}) {
    Roller egg;
    egg.shape = std::make_shared<Ellipsoid>(Vector3(0.06, 0.03, 0.03));
    egg.mass = 0.3;
    egg.inertia = egg.shape->massProperties(egg.mass / egg.shape->volume()).I_com;
    egg.stiffness = k;
    egg.R_WB = rotationAbout(Vector3::UnitY(), 0.05);
    World world(egg.make(Vector3::Zero()));
    double before = 0.05, first = 0, last = 0, largest = 0;
    int swings = 0;
    while (world.time() < 15.3 * kEggPeriod) {
      world.step();
      const Matrix3 R = world.linkPose(1).R;
      const double tilt = elementary::atan2(-R(2, 0), R(0, 0));
      if (before < 0 && tilt >= 0) {
        last = world.time() - egg.step * tilt / (tilt - before);
        if (swings++ == 0) first = last;
        largest = 0;
      }
      largest = std::max(largest, tilt);
      before = tilt;
    }
    std::printf("egg: k %.0e: %.4f of its amplitude after %d swings\n", k, largest / 0.05, swings);
    error = std::max(error, std::abs(largest / 0.05 / kEggAmplitude - 1));
    period_error = std::max(period_error, std::abs((last - first) / (swings - 1) / kEggPeriod - 1));
  }
  figure("roll.egg_amplitude_err", error, "1");
  figure("roll.egg_period_err", period_error, "1");
}

/// First reversal of a rattleback's yaw [s].
void runRattlebacks() {
  double worst = 0;
  for (const double k : {1e8, 1e9, 1e10}) {
    Roller body;
    body.shape = std::make_shared<Ellipsoid>(Vector3(0.1, 0.025, 0.015));
    body.mass = 0.2;
    const Matrix3 turn = rotationAbout(Vector3::UnitZ(), 5 * M_PI / 180);
    body.inertia = turn * body.shape->massProperties(body.mass / body.shape->volume()).I_com * turn.transpose();
    body.stiffness = k;
    body.torsion = false;
    body.mu = 2;
    body.R_WB = rotationAbout(Vector3::UnitY(), -0.03);
    World world(body.make(-5 * Vector3::UnitZ()));
    double before = -5;
    while (world.time() < 3) {
      world.step();
      const double yaw = world.linkTwist(1).angular.z();
      if (before < 0 && yaw >= 0) break;
      before = yaw;
    }
    std::printf("rattleback: k %.0e: turns back at %.4f s\n", k, world.time());
    if (std::abs(world.time() - kRattlebackReversal) > std::abs(worst - kRattlebackReversal) || worst == 0) worst = world.time();
  }
  figure("roll.rattleback_s", worst, "s");
  figure("roll.rattleback_exact_s", kRattlebackReversal, "s");
}

/// A cone that rocks on its side about the steepest line of a slope.
void runCones() {
  constexpr double kRadius = 0.03, kHeight = 0.08, kSlope = 0.2, kStart = 0.5;
  double error = 0;
  const double half_angle = elementary::atan2(kRadius, kHeight), cosine = elementary::cos(half_angle);
  // A pendulum's swing of that angle takes so much longer than a small one. The stand-in's 64 sides are 0.1 rad each.
  const double longer = 1 + kStart * kStart / 16 + 11 * std::pow(kStart, 4) / 3072;
  const double slope = elementary::sin(kSlope);
  const double exact = longer * 2 * M_PI * std::sqrt(kHeight * (1 + 5 * cosine * cosine) / (5 * kGravity * slope * cosine));
  for (const double k : {1e8, 1e9, 1e10}) {
    Roller cone;
    cone.shape = std::make_shared<Cone>(kRadius, 0.0, kHeight);
    cone.mass = 0.2;
    const MassProperties properties = cone.shape->massProperties(cone.mass / cone.shape->volume());
    cone.inertia = properties.I_com;
    cone.stiffness = k;
    // The plane's x points up the slope. The cone's side lies along it, the tip uphill; then it is turned about the plane's normal.
    cone.R_WG = rotationAbout(Vector3::UnitY(), -kSlope);
    cone.R_WB = cone.R_WG * rotationAbout(Vector3::UnitZ(), kStart) * rotationAbout(Vector3::UnitY(), M_PI / 2 + half_angle);
    WorldDef def = cone.make(Vector3::Zero());
    def.articulations[1].links[0].inertia.p_LC = properties.com;
    World world(def);
    const auto yaw = [&] {
      const Vector3 axis = cone.R_WG.transpose() * world.linkPose(1).R.col(2);
      return elementary::atan2(axis.y(), axis.x());
    };
    double before = yaw(), first = 0, last = 0;
    int crossings = 0;
    while (world.time() < 3) {
      world.step();
      const double now = yaw();
      if ((before < 0) != (now < 0)) {
        last = world.time() - cone.step * now / (now - before);
        if (crossings++ == 0) first = last;
      }
      before = now;
    }
    const double period = 2 * (last - first) / (crossings - 1);
    std::printf("cone: k %.0e: period %.4f s, exact %.4f s\n", k, period, exact);
    error = std::max(error, std::abs(period / exact - 1));
  }
  figure("roll.cone_period_err", error, "1");
}

}  // namespace

void runRolling() {
  runCoins();
  runEggs();
  runRattlebacks();
  runCones();
}

}  // namespace haptic::bench
