/// MotrixSim's grasp (Motphys/motrixsim-docs, Grasp Contact Mechanics Benchmark, 2026) without the arm: two fingers on springs hold a
/// cube; when all is at rest friction is lowered to a factor f of what holds it, μ = f m g/N with N the force of both fingers together, as
/// their page counts it (μ_crit = .0902). f ≥ 1 holds, for ever; below the cube slides down by ½ g (1 − f) t². g = 9.81 m/s².
#pragma once
#include <cmath>
#include <functional>

#include "blocks.h"
#include "haptic_core/geometry/shapes/ball.h"

namespace haptic::scenes {

struct Grasp {
  static constexpr double kG = 9.81, kMass = 0.064, kSize = 0.04;    ///< [m/s²]; of the cube [kg], [m]
  static constexpr double kNormal = 6.96;                             ///< N of both fingers [N]
  static constexpr double kFinger = 0.2, kThickness = 0.02, kPad = 0.06;  ///< [kg], [m], [m]: 0.02 x 0.06 x 0.06 m
  static constexpr double kSpring = 300, kDamping = 6;  ///< of each hand that holds a finger [N/m], [N s/m]: steps of 10 ms bear it
  static constexpr double kLowered = 0.5;                             ///< time at which friction is lowered [s]
  static constexpr double kFirst = 3;                                 ///< times as much friction before
  static constexpr int kCube = 0, kLeft = 1;                          ///< links: the cube, then both fingers

  double factor = 1;                 ///< f
  double amplitude = 0, rate = 0;    ///< of the hands' way up and down once friction is lowered [m], [Hz]

  double mu() const { return factor * kMass * kG / kNormal; }
  /// Factor on μ once it is lowered, from the places of the fingers along x then: N is what their hands press with, not its nominal
  /// value, for soft surfaces give way.
  static double frictionFor(double left, double right) {
    const double press = 0.5 * kNormal / kSpring, open = 0.5 * kSize;
    return kNormal / (kSpring * ((-open + press - left) + (right - (open - press))));
  }

  /// Frame of a finger, −1: the left one: the middle of its inner face. There its hand holds it, and there is its centre of mass, so that
  /// neither weight nor friction tilts it, as a gripper's guides would not let it. It sags by its own weight and half of the cube's, which
  /// the hand makes up for.
  static Vector3 place(int side) { return {side * 0.5 * kSize, 0, 0}; }
  /// Where a hand wants its finger, and how fast that moves.
  Pose target(int side, double t, Vector3& velocity) const {
    const double sag = (kFinger + 0.5 * kMass) * kG / kSpring, press = 0.5 * kNormal / kSpring;
    const double w = 2 * M_PI * rate, since = std::max(0.0, t - kLowered);
    velocity = Vector3(0, 0, 0.5 * amplitude * w * elementary::sin(w * since));
    return Pose(Vector3(place(side) + Vector3(-side * press, 0, sag + 0.5 * amplitude * (1 - elementary::cos(w * since)))));
  }
  /// How far the cube has slid where it slides, rigid.
  double slid(double t) const {
    const double since = std::max(0.0, t - kLowered);
    return factor < 1 ? 0.5 * kG * (1 - factor) * since * since : 0;
  }
  double speed(double t) const { return factor < 1 ? kG * (1 - factor) * std::max(0.0, t - kLowered) : 0; }

  WorldDef make(const WorldSettings& settings, double k) const {
    WorldDef def;
    def.name = "grasp";
    def.settings = settings;
    def.settings.gravity = Vector3(0, 0, -kG);
    ContactMaterial& m = def.settings.default_material;
    m.stiffness = k;
    m.mu_static = m.mu_dynamic = mu();
    def.articulations.push_back(freeBox("cube", Vector3::Constant(kSize), kMass, Pose()));
    for (const int side : {-1, 1}) {
      def.articulations.push_back(
          freeBox(side < 0 ? "left" : "right", Vector3(kThickness, kPad, kPad), kFinger, Pose(place(side))));
      def.articulations.back().links[0].collisions[0].X_LS.p.x() = side * 0.5 * kThickness;
      PointerDef hand;
      hand.articulation = static_cast<int>(def.articulations.size()) - 1;
      hand.link = 0;
      hand.coupling.mode = PointerCoupling::Mode::kVirtual;
      hand.coupling.stiffness = kSpring;
      hand.coupling.damping = kDamping;
      hand.coupling.rotational_stiffness = hand.coupling.rotational_damping = 0;
      def.pointers.push_back(hand);
    }
    return def;
  }
};

/// How far the cube has slid in the fingers: their mean height less the cube's, over that of another state. `height(link)` [m].
template <class Height>
double slipBetween(Height now, Height before) {
  const auto below = [](Height& z) { return 0.5 * (z(Grasp::kLeft) + z(Grasp::kLeft + 1)) - z(Grasp::kCube); };
  return below(now) - below(before);
}

/// Newton's cradle without its strings: balls in a row with gaps, the first one flies at the others. Equal balls that are rigid and
/// elastic hand on their speed one after the other: each then lies still, one gap farther on. No gravity, no friction.
struct Cradle {
  static constexpr int kBalls = 5;
  static constexpr double kRadius = 0.05, kMass = 1, kSpeed = 1, kGap = 1e-4, kRun = 0.05;  ///< [m], [kg], [m/s], [m], [m]

  static double start(int ball) { return ball == 0 ? -kRun - 2 * kRadius : (ball - 1) * (2 * kRadius + kGap); }
  /// When a ball is hit; the first flies from the start.
  static double hit(int ball) { return ball == 0 ? 0 : (kRun + (ball - 1) * kGap) / kSpeed; }
  static double speed(int ball, double t) {
    return t >= hit(ball) && (ball == kBalls - 1 || t < hit(ball + 1)) ? kSpeed : 0;
  }
  static double place(int ball, double t) {
    const double end = ball == kBalls - 1 ? t : std::min(t, hit(ball + 1));
    return start(ball) + kSpeed * std::max(0.0, end - hit(ball));
  }

  static WorldDef make(const WorldSettings& settings, double k) {
    WorldDef def;
    def.name = "cradle";
    def.settings = settings;
    def.settings.gravity.setZero();
    ContactMaterial& m = def.settings.default_material;
    m.stiffness = k;
    m.dissipation = m.damping = m.mu_static = m.mu_dynamic = 0;
    const auto ball = std::make_shared<Ball>(kRadius);
    for (int i = 0; i < kBalls; ++i) {
      def.articulations.push_back(freeBody("ball" + std::to_string(i), ball, kMass,
                                           0.4 * kMass * kRadius * kRadius * Matrix3::Identity(), Pose(Vector3(start(i), 0, 0)),
                                           {Vector3::Zero(), Vector3(speed(i, 0), 0, 0)}));
    }
    return def;
  }
};

/// A flat pyramid of cubes on the ground, `rows` at the bottom, as Box3D's benchmark has it.
struct CubePyramid {
  static constexpr double kSize = 0.1, kMass = 0.1, kPitch = 0.11;  ///< [m], [kg], between centres of a row [m]
  int rows = 100;

  int count() const { return rows * (rows + 1) / 2; }
  Vector3 place(int cube) const {
    int row = 0;
    while (cube >= rows - row) cube -= rows - row++;
    return {(cube - 0.5 * (rows - row - 1)) * kPitch, 0, (row + 0.5) * kSize};
  }
  WorldDef make(const WorldSettings& settings, double k) const {
    CubeParameters c;
    c.stiffness = k;
    WorldDef def = cubeOnFloor(c, settings);
    def.name = "pyramid";
    def.settings.default_material.damping = ContactMaterial::kUnset;
    def.settings.default_material.dissipation = 10;
    def.settings.default_material.tangential_damping = def.settings.default_material.tangential_stiffness = ContactMaterial::kUnset;
    def.articulations.assign(1, floorBox(4 + rows * kPitch));
    for (int i = 0; i < count(); ++i) def.articulations.push_back(cube("cube" + std::to_string(i), c, Pose(place(i))));
    return def;
  }
};

}  // namespace haptic::scenes
