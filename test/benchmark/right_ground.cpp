/// Ground as files have it: height fields with noise, planes in single precision, tiles with gaps and laps. A ball, a box and a cylinder
/// are led over it at .5 m/s at a constant height, beside a half-space; and a ball rolls freely.
#include <algorithm>
#include <cmath>
#include <vector>

#include "../scenes/ground.h"
#include "../scenes/offsets.h"
#include "figure.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "right_figures.h"

namespace haptic::bench {
namespace {

using namespace scenes;

constexpr double kStiffness = 1e7, kMass = 1, kSpeed = 0.5, kTile = 0.1;  ///< [N/m³], [kg], [m/s], [m]
constexpr int kLedSteps = 800;

/// At the depth at which it carries its weight on a plane.
struct Rider {
  LedBody body;
  double area = 0, depth = 0, chord = 0;  ///< of its patch [m²], [m], [m]
};

std::vector<Rider> riders() {
  const double weight = kMass * kGravity, r = 0.05, ball = std::sqrt(weight / (kStiffness * M_PI * r)),
               disc = M_PI * r * r, square = 4 * r * r;
  const auto flat = [&](double area) { return weight / (kStiffness * area); };
  return {{{std::make_shared<Ball>(r), r - ball, kMass}, 2 * M_PI * r * ball, ball, 2 * std::sqrt(2 * r * ball)},
          {{box(Vector3::Constant(2 * r)), r - flat(square), kMass}, square, flat(square), 2 * r},
          {{std::make_shared<Rod>(r, 0.02, Rod::Ends::kFlat), 0.01 - flat(disc), kMass}, disc, flat(disc), 2 * r}};
}

WorldDef over(const std::vector<ArticulationDef>& ground, const LedBody& body, const Pose& X_WG = Pose()) {
  WorldDef def = ledOver(ground, body);
  def.settings.default_material = ContactMaterial{};
  def.settings.default_material.stiffness = kStiffness;
  def.settings.default_material.mu_static = def.settings.default_material.mu_dynamic = 0.5;
  def.articulations.back().X_WA = X_WG * Pose(Vector3(0, 0, 1));
  return def;
}

std::vector<ArticulationDef> plane(const Pose& X_WG) { return {staticPieces("plane", {std::make_shared<HalfSpace>()}, X_WG)}; }

/// Largest difference of the normal force from that of the plane z = 0 of G [N].
double forceError(const std::vector<ArticulationDef>& ground, const LedBody& body, const Pose& X_WG) {
  World rough(over(ground, body, X_WG)), smooth(over(plane(X_WG), body, X_WG));
  const LedMotion way{Vector3(-0.2, -0.07, 0), kSpeed * Vector3(0.96, 0.28, 0), 0.4};
  const Vector3 n = X_WG.R.col(2);
  double worst = 0;
  for (int k = 0; k < kLedSteps; ++k) {
    const Twist V = way.twist();
    for (World* world : {&rough, &smooth}) {
      world->setPointerTarget(0, X_WG * way.at(k * world->settings().step, body.height), {X_WG.R * V.angular, X_WG.R * V.linear});
      world->step();
    }
    if (k > kEntered) worst = std::max(worst, std::abs(n.dot(rough.pointerWrench(0).force - smooth.pointerWrench(0).force)));
  }
  return worst;
}

GroundShapes noisy(double amplitude) {
  Offsets offsets;
  return groundOf(heightGrid(20, 2, [&](double, double) { return amplitude * offsets.next(); }));
}

/// Triangles of a plane whose corners are rounded to single precision. `rounding`: the largest change of a corner [m].
GroundShapes inSinglePrecision(const Pose& X_WG, double& rounding) {
  TriangleMesh mesh = surfaceOf(heightGrid(20, 2, [](double, double) { return 0.0; }), "plane");
  rounding = 0;
  for (Vector3& p : mesh.vertices) {
    const Vector3 exact = X_WG * p;
    p = exact.cast<float>().cast<double>();
    rounding = std::max(rounding, (p - exact).norm());
  }
  GroundReport report;
  return groundPieces(mesh, 0.2, "plane", report);
}

/// Boxes side by side under z = 0, with gaps between them, or laps where `gap` is negative.
std::vector<ArticulationDef> looseTiles(double gap) {
  std::vector<ArticulationDef> out;
  constexpr int kRows = 7, kColumns = 14;
  for (int i = 0; i < kRows * kColumns; ++i) {
    const Vector3 middle(kTile * (i % kColumns - 6), kTile * (i / kColumns - 3), -0.1);
    out.push_back(staticBox("tile" + std::to_string(i), Vector3(kTile - gap, kTile - gap, 0.2), Pose(middle)));
  }
  return out;
}

/// Speed after a metre of a ball that begins to roll, over that at the start.
double speedKept(const std::vector<ArticulationDef>& ground) {
  const Rider ball = riders()[0];
  WorldDef def = over(ground, ball.body);
  def.pointers.clear();
  ArticulationDef& body = def.articulations.back();
  const double rolls_on = ball.body.height + 0.5 * ball.depth;
  body.links[0].inertia.I_C = 0.4 * kMass * 0.05 * 0.05 * Matrix3::Identity();
  body.X_WA = Pose(Vector3(-0.5, 0.013, ball.body.height));
  body.V_WA = {Vector3(0, kSpeed / rolls_on, 0), Vector3(kSpeed, 0, 0)};
  World world(def);
  const int link = world.linkCount() - 1;
  for (int i = 0; i < 4000 && world.linkPose(link).p.x() < 0.5; ++i) world.step();
  return world.linkPose(link).p.x() < 0.5 ? 0.0 : world.linkTwist(link).linear.norm() / kSpeed;
}

}  // namespace

void runGround() {
  const double weight = kMass * kGravity;
  double noise = 0, single = 0, tiled = 0, wide = 0;
  for (const Rider& rider : riders()) {
    const auto share = [&](double error, double own) { return std::max(0.0, error - own) / weight; };
    for (const double a : {1e-9, 1e-8, 5e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3}) {
      noise = std::max(noise, share(forceError({staticPieces("field", noisy(a))}, rider.body, Pose()), kStiffness * rider.area * a));
    }
    for (const double z : {0., 1., 10.}) {
      const Pose X_WG(rotationFromRpy(Vector3(0.05, 0.03, 0)), Vector3(0, 0, z));
      double rounding = 0;
      const GroundShapes pieces = inSinglePrecision(X_WG, rounding);
      single = std::max(single, share(forceError({staticPieces("plane", pieces)}, rider.body, X_WG), kStiffness * rider.area * rounding));
    }
    for (const double gap : {1e-9, 1e-7, 2e-6, 1e-5, 1e-4, 4e-4, 1e-3}) {
      for (const double side : {-1., 1.}) {
        const double own = 2 * kStiffness * rider.depth * rider.chord * gap;  // a strip along each of the tiles' directions
        const double error = share(forceError(looseTiles(side * gap), rider.body, Pose()), own);
        (gap <= 0.1 * rider.depth ? tiled : wide) = std::max(gap <= 0.1 * rider.depth ? tiled : wide, error);
      }
    }
  }
  figure("ground.noise_force_rel_field", noise, "1");
  figure("ground.noise_force_rel_single", single, "1");
  figure("ground.noise_force_rel_tiles", tiled, "1");       // gaps and laps up to a tenth of the depth
  figure("ground.noise_force_rel_wide_gaps", wide, "1");
  figure("ground.noise_force_rel", std::max({noise, single, tiled, wide}), "1");
  double kept = 1;
  for (const double a : {1e-9, 1e-8, 5e-8, 1e-7, 1e-6, 9e-6}) {
    kept = std::min(kept, speedKept({staticPieces("field", noisy(a))}));
    for (const double side : {-1., 1.}) kept = std::min(kept, speedKept(looseTiles(side * a)));
  }
  figure("ground.speed_kept", kept, "1");
  figure("ground.speed_kept_smooth", speedKept(plane(Pose())), "1");
  figure("ground.speed_kept_lap_400um", speedKept(looseTiles(-4e-4)), "1");
}

}  // namespace haptic::bench
