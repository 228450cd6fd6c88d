// Logs that stand and roll, and how deep an overhanging cube is.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "../comparators/velocity_verlet.h"
#include "../scenes/blocks.h"
#include "../scenes/spinning_ellipsoid.h"
#include "figure.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/world/world.h"
#include "shapes_figures.h"

namespace haptic::bench {
namespace {

const Matrix3 kLying = Eigen::AngleAxisd(M_PI / 2, Vector3::UnitX()).toRotationMatrix();

ArticulationDef logOf(const std::string& name, double radius, double length, double mass, const Vector3& p) {
  const auto rod = std::make_shared<Rod>(radius, length, Rod::Ends::kFlat);
  const MassProperties solid = rod->massProperties(mass / rod->volume());
  return scenes::freeBody(name, rod, mass, solid.I_com, Pose(kLying, p));
}

/// cases/logs.urdf: `rows` rows of logs, the lowest on a floor.
WorldDef pile(int rows, double mu) {
  constexpr double kRadius = 0.05;
  WorldDef def;
  def.settings.step = 1e-3;
  def.settings.gravity = Vector3(0, 0, -scenes::kGravity);
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = 1e9;
  m.mu_static = m.mu_dynamic = mu;
  def.articulations.push_back(scenes::floorBox(4));
  for (int row = 0; row < rows; ++row) {
    for (int i = 0; i < rows - row; ++i) {
      const Vector3 p((2 * i - (rows - row - 1)) * kRadius, 0, kRadius * (1 + std::sqrt(3.0) * row));
      def.articulations.push_back(
          logOf("log" + std::to_string(row) + std::to_string(i), kRadius, 0.4, 0.5, p));
    }
  }
  return def;
}

/// Largest way that a log has gone in `seconds` [m]; stops at `enough`.
double motionOf(const WorldDef& def, double seconds, double enough) {
  World world(def);
  const int count = def.articulations.size(), steps = std::lround(seconds / def.settings.step);
  double most = 0;
  for (int i = 0; i < steps && most < enough; ++i) {
    world.step();
    for (int body = 1; body < count; ++body) {
      most = std::max(most, (world.linkPose(body).p - def.articulations[body].X_WA.p).norm());
    }
  }
  return most;
}

/// Rows of logs that lie side by side part, and each outer log stands for tan 15°. But where three rows or more press, a log in the
/// middle bears on its neighbours askew: with N, F at the six contacts of three rows in balance, one of them needs F/N ≥ 0.434.
double leastFriction(int rows) {
  constexpr double kMoved = 1e-3, kSeconds = 5;
  double falls = 0.2, stands = 1;
  if (motionOf(pile(rows, stands), kSeconds, kMoved) >= kMoved) return std::nan("");
  while (stands - falls > 2e-4) {
    const double mu = 0.5 * (falls + stands);
    (motionOf(pile(rows, mu), kSeconds, kMoved) < kMoved ? stands : falls) = mu;
  }
  return stands;
}

/// cases/README.md, "roll over": a cylinder off the top of a fixed one.
double rollOver(double k, double h) {
  constexpr double kBelow = 0.05, kAbove = 0.03, kMass = 0.3, kStart = M_PI / 180;
  WorldDef def;
  def.settings.step = h;
  def.settings.comparator = comparators::velocityVerlet;
  def.settings.gravity = Vector3(0, 0, -scenes::kGravity);
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = k;
  m.dissipation = 0;
  m.mu_static = m.mu_dynamic = 2;
  ArticulationDef fixed = logOf("fixed", kBelow, 0.2, 1, Vector3::Zero());
  fixed.links[0].joint.type = JointType::kFixed;
  def.articulations.push_back(fixed);
  // As deep as carries m g cos: parallel lens, found by the volume itself.
  const Rod below(kBelow, 0.2, Rod::Ends::kFlat), above(kAbove, 0.1, Rod::Ends::kFlat);
  double low = 0, high = 0.01;
  for (int i = 0; i < 60; ++i) {
    const double depth = 0.5 * (low + high), D = kBelow + kAbove - depth;
    const auto part = [](double r, double d) {
      const double f = std::acos(1 - d / r);
      return r * r * (f - std::sin(f) * std::cos(f));
    };
    const double a = depth * (kAbove - kBelow + D) / (2 * D), b = depth - a;
    (k * 0.1 * (part(kBelow, a) + part(kAbove, b)) < kMass * scenes::kGravity * std::cos(kStart) ? low
                                                                                                 : high) =
        depth;
  }
  const double D = kBelow + kAbove - high;
  def.articulations.push_back(
      logOf("rolls", kAbove, 0.1, kMass, D * Vector3(std::sin(kStart), 0, std::cos(kStart))));
  World world(def);
  double worst = 0;
  const double end = 50 * M_PI / 180;
  for (int i = 0; i < 1000000; ++i) {
    world.step();
    const Vector3 p = world.linkPose(1).p;
    const double theta = std::atan2(p.x(), p.z()), v = world.linkTwist(1).linear.norm();
    if (theta > end) break;
    const double exact =
        std::sqrt(4.0 / 3 * scenes::kGravity * (kBelow + kAbove) * (std::cos(kStart) - std::cos(theta)));
    if (theta > 10 * M_PI / 180) worst = std::max(worst, std::abs(v / exact - 1));
  }
  return worst;
}

}  // namespace

void measureLogs() {
  figure("roll_over.err_rel", rollOver(1e10, 2e-5), "");
  const WorldDef standing = pile(3 - 1, 0.3);
  figure(
      "logs.creep_um",
      1e6 *
          [&] {
            World world(standing);
            for (int i = 0; i < 1000; ++i) world.step();
            Vector3 start[3];
            for (int body = 0; body < 3; ++body) start[body] = world.linkPose(body + 1).p;
            for (int i = 0; i < 10000; ++i) world.step();
            double most = 0;
            for (int body = 0; body < 3; ++body)
              most = std::max(most, (world.linkPose(body + 1).p - start[body]).norm());
            return most;
          }(),
      "um");
  figure("logs.stands_mu", leastFriction(2), "");
  figure("logs.ten_stands_mu", leastFriction(4), "");
}

void measureEllipsoid() {
  figure("ellipsoid.energy_err_rel", scenes::SpinningEllipsoid().energyError(1e-4, 5), "");
}

void measureOverhang() {
  // A cube of 10 cm, level, overhangs a table's edge by 6 cm.
  const ConvexPolyhedron table = makeBox(Vector3(1, 1, 0.2)), cube = makeBox(Vector3(0.1, 0.1, 0.1));
  ContactWorkspace workspace;
  workspace.reserve(table, cube);
  double worst = 0;
  for (const double depth : {1e-5, 1e-4, 1e-3, 1e-2}) {
    for (const bool table_first : {true, false}) {
      const Pose X(Vector3(0.5 - 0.04 + 0.05, 0.1, 0.1 + 0.05 - depth));
      PairCache cache;
      ContactVolume out;
      if (table_first)
        contactVolume(table, cube, X, cache, workspace, out);
      else
        contactVolume(cube, table, X.inverse(), cache, workspace, out);
      worst = std::max(worst, std::abs(out.depth / depth - 1));
    }
  }
  figure("overhang.depth_err_rel", worst, "");
}

}  // namespace haptic::bench
