/// SimBenchmark's scenes of balls (Kang, Hwangbo, ETH Zürich 2018, leggedrobotics/SimBenchmark), shared by benchmarks and the
/// report. g = 9.81 m/s², balls of 0.1 m radius.
#pragma once
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "blocks.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/half_space.h"
#include "offsets.h"

namespace haptic::scenes {

constexpr double kBallGravity = 9.81, kBallRadius = 0.1;  ///< [m/s²], [m]

/// All below the plane z = 0 of X_WG.
inline ArticulationDef groundPlane(const Pose& X_WG = Pose()) {
  ArticulationDef def = freeBody("ground", std::make_shared<HalfSpace>(), 1, Matrix3::Identity(), X_WG);
  def.links[0].joint.type = JointType::kFixed;
  return def;
}

inline ArticulationDef freeBall(const std::string& name, const std::shared_ptr<const ConvexShape>& shape, double mass,
                                const Vector3& p) {
  return freeBody(name, shape, mass, 0.4 * mass * kBallRadius * kBallRadius * Matrix3::Identity(), Pose(p));
}

/// Depth at which a ball carries its weight on k: k π R d² = m g, but for d/3R.
inline double ballRestDepth(double mass, double k) {
  return std::sqrt(mass * kBallGravity / (k * M_PI * kBallRadius));
}

/// Balls of 10 kg in a grid over the ground, link 0.
struct BallGrid {
  int side = 6, layers = 6;
  double pitch = 0.21, lowest = 0.101;  ///< between centres, of the lowest centres [m]
  double jitter = 1e-3;                 ///< offsets in x and y [m]
  double mu = 0.5;
  double stiffness = 1e9;               ///< k [N/m³]
  double dissipation = 10;              ///< [s/m]; 0: elastic, without any damper

  int count() const { return side * side * layers; }
  WorldDef make(const WorldSettings& settings, const std::shared_ptr<const ConvexShape>& shape) const {
    WorldDef def;
    def.name = "balls";
    def.settings = settings;
    def.settings.gravity = Vector3(0, 0, -kBallGravity);
    ContactMaterial& m = def.settings.default_material;
    m.stiffness = stiffness;
    m.dissipation = dissipation;
    if (dissipation == 0) m.damping = 0;
    m.mu_static = m.mu_dynamic = mu;
    def.articulations.push_back(groundPlane());
    Offsets offsets;
    for (int i = 0; i < count(); ++i) {
      const double dx = jitter * offsets.next(), dy = jitter * offsets.next();
      const Vector3 p((i % side - 0.5 * (side - 1)) * pitch + dx, (i / side % side - 0.5 * (side - 1)) * pitch + dy,
                      lowest + i / (side * side) * pitch);
      def.articulations.push_back(freeBall("ball" + std::to_string(i), shape, 10, p));
    }
    return def;
  }
};

/// Sum of the squared overlaps of true balls with one another and with the ground [m²].
inline double squaredOverlaps(const std::vector<Vector3>& centres) {
  const auto square = [](double x) { return x * x; };
  double sum = 0;
  for (std::size_t i = 0; i < centres.size(); ++i) {
    sum += square(std::max(0.0, kBallRadius - centres[i].z()));
    for (std::size_t j = 0; j < i; ++j) {
      const double distance = (centres[i] - centres[j]).norm();
      if (distance < 2 * kBallRadius) sum += square(2 * kBallRadius - distance);
    }
  }
  return sum;
}

/// 25 balls of 1 kg on a box of 10 kg on the ground, which is pulled: the box slides, the balls roll on it. Link 0 is the ground,
/// link 1 the box, then come the balls.
struct RollingBalls {
  static constexpr double kForce = 150, kBox = 10, kBall = 1, kBoxSize = 20, kHeight = 0.1;  ///< [N], [kg], [kg], [m], [m]
  static constexpr int kSide = 5, kBalls = kSide * kSide;
  static constexpr double kPitch = 2;      ///< [m]
  static constexpr double kGround = 5e-6;  ///< of k: the box's face has 400 m²
  Vector3 direction = Vector3(0.5, std::sqrt(0.75), 0);  ///< of the pull, level and unit

  /// Between the box and each ball [N].
  double ballForce() const {
    const double f1 = 0.4 * (kBox + kBalls * kBall) * kBallGravity;
    return (kForce - f1) / kBox / (3.5 / kBall + kBalls / kBox);
  }
  double boxAcceleration() const {
    return (kForce - 0.4 * (kBox + kBalls * kBall) * kBallGravity - kBalls * ballForce()) / kBox;
  }
  static Vector3 place(int ball) {
    return {(ball % kSide - 0.5 * (kSide - 1)) * kPitch, (ball / kSide - 0.5 * (kSide - 1)) * kPitch, kHeight + kBallRadius};
  }
  /// The exact motion of the box (-1) or a ball, rigid.
  Pose poseAt(double t, int body) const {
    if (body < 0) return Pose(Vector3(0.5 * boxAcceleration() * t * t * direction + Vector3(0, 0, 0.5 * kHeight)));
    return {rotationAbout(axis(), 0.5 * spin() * t * t),
            place(body) + 0.5 * ballForce() / kBall * t * t * direction};
  }
  Twist twistAt(double t, int body) const {
    if (body < 0) return {Vector3::Zero(), boxAcceleration() * t * direction};
    return {spin() * t * axis(), ballForce() / kBall * t * direction};
  }

  /// At rest in the depth that carries them. A hand holds the box by a damper of `kPull`: led at kForce/kPull it pulls with kForce,
  /// which the box's own speed changes by 1e-8.
  WorldDef make(const WorldSettings& settings, double k, const std::shared_ptr<const ConvexShape>& shape) const {
    WorldDef def;
    def.name = "rolling";
    def.settings = settings;
    def.settings.gravity = Vector3(0, 0, -kBallGravity);
    ContactMaterial material;
    material.stiffness = k;
    material.dissipation = 0;  // a damper over a patch resists rolling, which rigid balls do not know
    material.mu_static = material.mu_dynamic = 0.8;
    ContactMaterial ground = material;
    ground.stiffness = kGround * k;
    ground.dissipation = 10;
    ground.mu_static = ground.mu_dynamic = 0.2;  // 0.4 with the box: the geometric mean
    const auto put = [&def](ArticulationDef body, const ContactMaterial& m) {
      body.links[0].collisions[0].material = m;
      def.articulations.push_back(std::move(body));
    };
    put(groundPlane(), ground);
    const double pair = 2 * kGround / (1 + kGround) * k;
    const double sink = (kBox + kBalls * kBall) * kBallGravity / (pair * kBoxSize * kBoxSize);
    put(freeBox("box", Vector3(kBoxSize, kBoxSize, kHeight), kBox, Pose(Vector3(0, 0, 0.5 * kHeight - sink))), material);
    for (int i = 0; i < kBalls; ++i) {
      put(freeBall("ball" + std::to_string(i), shape, kBall, place(i) - Vector3(0, 0, sink + ballRestDepth(kBall, k))), material);
    }
    PointerDef hand;
    hand.articulation = 1;
    hand.link = 0;
    hand.coupling.mode = PointerCoupling::Mode::kVirtual;
    hand.coupling.stiffness = hand.coupling.rotational_stiffness = hand.coupling.rotational_damping = 0;
    hand.coupling.damping = kPull;
    def.pointers.push_back(hand);
    return def;
  }
  static constexpr double kPull = 1e-6;  ///< [N s/m]
  Twist handTwist() const { return {Vector3::Zero(), kForce / kPull * direction}; }

  /// SimBenchmark's error of one instant: squared errors of the velocities of the box, and of the balls in the mean [m²/s²].
  /// `velocity(body)` as for `poseAt`.
  template <class Velocity>
  double squaredError(double t, Velocity velocity) const {
    double sum = 0;
    for (int body = -1; body < kBalls; ++body) {
      sum += (velocity(body) - twistAt(t, body).linear).squaredNorm() / (body < 0 ? 1 : kBalls);
    }
    return sum;
  }

 private:
  Vector3 axis() const { return direction.cross(Vector3::UnitZ()); }
  static double spinOf(double force) { return force / (0.4 * kBall * kBallRadius); }  // [rad/s²]
  double spin() const { return spinOf(ballForce()); }
};

}  // namespace haptic::scenes
