// One round body that rolls, against closed forms.
#include <cmath>
#include <string>
#include <vector>

#include "../scenes/blocks.h"
#include "figure.h"
#include "haptic_core/geometry/ball.h"
#include "haptic_core/geometry/rod.h"
#include "round_figures.h"

namespace haptic::bench {
namespace {

WorldDef ballOnFloor(double h, double k, double slope, double mu, double speed) {
  constexpr double kRadius = 0.1;
  WorldDef def;
  def.settings.integrator = Integrator::kVelocityVerlet;
  def.settings.step = h;
  def.settings.gravity = scenes::kGravity * Vector3(std::sin(slope), 0, -std::cos(slope));
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = k;
  m.dissipation = 0;
  m.mu_static = m.mu_dynamic = mu;
  def.articulations.push_back(scenes::floorBox(10));
  const double force = scenes::kGravity * std::cos(slope);
  double depth = 0;
  for (int i = 0; i < 60; ++i) depth = std::sqrt(force / (k * M_PI * (kRadius - depth / 3)));
  def.articulations.push_back(scenes::freeBody(
      "ball", std::make_shared<Ball>(kRadius), 1, 0.4 * kRadius * kRadius * Matrix3::Identity(),
      Pose(Vector3(0, 0, kRadius - depth)), {Vector3::Zero(), Vector3(speed, 0, 0)}));
  return def;
}

/// Arm of the patch: V's centroid lies this far below the centre.
double armOf(const WorldDef& def) {
  const double R = 0.1, depth = R - def.articulations[1].X_WA.p.z();
  return R - depth * (2 * R / 3 - depth / 4) / (R - depth / 3);
}

void measureRolling() {
  const double h = 1e-4, slope = 0.1, R = 0.1;
  const WorldDef def = ballOnFloor(h, 1e8, slope, 0.5, 0);
  World world(def);
  for (int i = 0; i < 2000; ++i) world.step();
  const double before = world.linkTwist(1).linear.x();
  for (int i = 0; i < 5000; ++i) world.step();
  const double a = (world.linkTwist(1).linear.x() - before) / 0.5, r = armOf(def);
  figure("ball_slope.accel_err_rel",
         std::abs(a / (scenes::kGravity * std::sin(slope) / (1 + 0.4 * R * R / (r * r))) - 1), "");
  figure("ball_slope.accel_err_rel_rigid", std::abs(a / (scenes::kGravity * std::sin(slope) * 5 / 7) - 1),
         "");
  const double v0 = 2;
  const WorldDef sliding = ballOnFloor(h, 1e8, 0, 0.2, v0);
  World slide(sliding);
  for (int i = 0; i < 6000; ++i) slide.step();
  const double arm = armOf(sliding), share = arm * arm / (0.4 * R * R);
  // The time until friction ends is (v0 - v)/(μ g).
  figure("ball_slide_to_roll.time_err_rel",
         std::abs((v0 - slide.linkTwist(1).linear.x()) * (1 + share) / v0 - 1), "");
}

/// A cylinder rolls down a slope: against g sin α/(1 + R²/2r²), r the arm of its patch.
void measureCylinder() {
  constexpr double R = 0.1, L = 0.3, k = 1e8, h = 1e-4, slope = 0.1;
  const auto rod = std::make_shared<Rod>(R, L, Rod::Ends::kFlat);
  const auto segment = [](double d) {
    const double half = std::acos(1 - d / R);
    return R * R * (half - std::sin(half) * std::cos(half));
  };
  double low = 0, high = R;
  for (int i = 0; i < 100; ++i) {
    const double d = 0.5 * (low + high);
    (k * L * segment(d) < scenes::kGravity * std::cos(slope) ? low : high) = d;
  }
  WorldDef def = ballOnFloor(h, k, slope, 0.5, 0);
  def.articulations[1] = scenes::freeBody("cylinder", rod, 1, rod->massProperties(1 / rod->volume()).I_com,
                                          Pose(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitX()).toRotationMatrix(),
                                               Vector3(0, 0, R - low)));
  World world(def);
  for (int i = 0; i < 2000; ++i) world.step();
  const double before = world.linkTwist(1).linear.x();
  for (int i = 0; i < 5000; ++i) world.step();
  const double a = (world.linkTwist(1).linear.x() - before) / 0.5;
  const double r = 2.0 / 3 * std::pow(low * (2 * R - low), 1.5) / segment(low);
  figure("cylinder_roll.accel_err_rel",
         std::abs(a / (scenes::kGravity * std::sin(slope) / (1 + 0.5 * R * R / (r * r))) - 1), "");
  figure("cylinder_roll.accel_err_rel_rigid", std::abs(a / (scenes::kGravity * std::sin(slope) * 2 / 3) - 1), "");
}

}  // namespace

void measureRoundMotion() {
  measureRolling();
  measureCylinder();
}

}  // namespace haptic::bench
