// One round body that rolls, against closed forms.
#include <cmath>
#include <string>
#include <vector>

#include "../comparators/velocity_verlet.h"
#include "../scenes/balls.h"
#include "figure.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "round_figures.h"

namespace haptic::bench {
namespace {

WorldDef ballOnFloor(double h, double k, double slope, double mu, double speed) {
  constexpr double kRadius = 0.1;
  WorldDef def;
  def.settings.comparator = comparators::velocityVerlet;
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

/// A ball's period in a trough, and what of it is due to the energy that the swing loses: θ²/16 of the share lost, in the mean.
struct Swing {
  double period_error, error_of_loss, loss_per_period;
};

/// A ball swings in a trough of radius R, made of planks that touch the circle: an exact pendulum of the length R - r + depth whose
/// ball turns, I = ⅖ m r². The default method.
Swing swingInTrough(double R, double r, double h, int periods) {
  constexpr double kStiffness = 1e12, kSwing = 0.1, kMass = 1;
  constexpr int kPlanks = 512;
  const double span = 2.2 * kSwing + 0.1, turn = span / kPlanks;
  WorldDef def;
  def.settings.step = h;
  def.settings.gravity = Vector3(0, 0, -scenes::kBallGravity);
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = kStiffness;
  m.dissipation = 0;
  m.mu_static = m.mu_dynamic = 0.9;
  ArticulationDef trough = scenes::staticBox("trough", Vector3(2 * R * std::tan(turn / 2), 4 * r, r), Pose());
  const CollisionDef plank = trough.links[0].collisions[0];
  trough.links[0].collisions.assign(kPlanks, plank);
  const auto along = [](double angle, double radius) { return Vector3(radius * std::sin(angle), 0, -radius * std::cos(angle)); };
  for (int i = 0; i < kPlanks; ++i) {
    const double angle = (i + 0.5) * turn - 0.5 * span;
    trough.links[0].collisions[i].X_LS = Pose(Matrix3(Eigen::AngleAxisd(-angle, Vector3::UnitY())), along(angle, R + 0.5 * r));
  }
  def.articulations.push_back(trough);
  const double length = R - r + std::sqrt(kMass * scenes::kBallGravity / (kStiffness * M_PI * r));
  def.articulations.push_back(scenes::freeBody("ball", std::make_shared<Ball>(r), kMass, 0.4 * kMass * r * r * Matrix3::Identity(),
                                               Pose(along(kSwing, length))));
  World world(def);
  double x = world.linkPose(1).p.x(), first = 0, last = 0, lost = 0, all_lost = 0;
  for (int i = 0, passes = 0; passes <= 2 * periods && i * h < 60; ++i) {
    world.step();
    const double next = world.linkPose(1).p.x();
    if (x * next < 0) {
      last = (i + x / (x - next)) * h;
      if (passes++ == 0) first = last;
      // In the middle all is in the ball's speed: g length (1 - cos θ) of a rolling ball's 7/10 v².
      const double v2 = world.linkTwist(1).linear.squaredNorm();
      lost = 1 - 0.7 * v2 / (scenes::kBallGravity * length * (1 - std::cos(kSwing)));
      all_lost += lost;
    }
    x = next;
  }
  double a = 1, b = std::cos(kSwing / 2);  // K(sin(swing/2)) = π/2 over their arithmetic-geometric mean
  for (int i = 0; i < 20; ++i) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  const double exact = 2 * M_PI / a * std::sqrt(1.4 * length / scenes::kBallGravity);
  return {std::abs((last - first) / periods / exact - 1), kSwing * kSwing / 16 * all_lost / (2 * periods + 1),
          lost / (periods + 0.25)};
}

/// Two errors of the period have opposite signs and cancel in part: both are printed or said. Where the normal turns within a step
/// SDIRK2 loses energy, less with a smaller step, and a smaller swing is quicker (`error_of_loss`). Springs that yield make it slower,
/// at any step, by 1.1e-5 here: with k = 1e13 N/m³ by a third of that, so that the loss shows, 1.6e-5.
void measureTrough() {
  constexpr double kRadius = 0.5, kBall = 0.05;  // of the trough and of the ball [m]
  const Swing at_1ms = swingInTrough(kRadius, kBall, 1e-3, 5);
  figure("trough.radius", kRadius, "m");
  figure("trough.ball_radius", kBall, "m");
  figure("trough.period_err_rel", at_1ms.period_error, "");
  figure("trough.period_err_of_loss", -at_1ms.error_of_loss, "");
  figure("trough.energy_lost_per_period", at_1ms.loss_per_period, "");
  const Swing finer = swingInTrough(kRadius, kBall, 0.5e-3, 2);
  figure("trough.period_err_rel_half_step", finer.period_error, "");
  figure("trough.period_err_of_loss_half_step", -finer.error_of_loss, "");
  figure("trough.energy_lost_per_period_half_step", finer.loss_per_period, "");
}

}  // namespace

void measureRoundMotion() {
  measureRolling();
  measureCylinder();
  measureTrough();
}

}  // namespace haptic::bench
