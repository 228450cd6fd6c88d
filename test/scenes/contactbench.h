/// Scenes after ContactBench (Le Lidec and others: Contact models in robotics, a comparative analysis, 2023), sizes ours: a cube that is
/// dragged or dropped, two cubes of mass ratio 1000, a driven finger. g = 9.81 m/s²; link 0 is the ground, z = 0. Each has an exact
/// solution by the rigid law: no overlap, no rebound, Coulomb's friction.
#pragma once
#include <cmath>

#include "balls.h"

namespace haptic::scenes {

/// Away from the axes, along which friction pyramids are exact [rad]: from x.
constexpr double kDragTurn = 0.5;
inline Vector3 dragDirection() { return {elementary::cos(kDragTurn), elementary::sin(kDragTurn), 0}; }

/// Material of the scenes: one coefficient of friction, a damper that leaves next to no rebound.
inline ContactMaterial ruledMaterial(double k, double mu) {
  ContactMaterial m;
  m.stiffness = k;
  m.dissipation = 10;  // [s/m]
  m.mu_static = m.mu_dynamic = mu;
  return m;
}

/// Place and speed along a direction.
struct Along {
  double way = 0, speed = 0;  ///< [m], [m/s]
};

/// A cube that a constant force pulls at its centre, or that falls flat with a speed along the plane.
struct DraggedCube {
  static constexpr double kSize = 0.1, kMass = 1, kMu = 0.4;  ///< [m], [kg], [1]
  static constexpr double kLead = 1e-6;  ///< damper of the hand that pulls [N·s/m]: the cube's speed changes the force by 1e-6 of it
  double pull = 0;    ///< force over μ m g: above 1 the cube slides
  double height = 0;  ///< of its lower face at the start [m]; with a height nothing pulls
  double speed = 0;   ///< at the start [m/s]

  double force() const { return pull * kMu * kMass * kBallGravity; }
  double landing() const { return std::sqrt(2 * height / kBallGravity); }  ///< time of the impact [s]
  /// Impact: the plane takes the normal speed g t, friction μ times that.
  Along along(double t) const {
    const double fall = landing();
    if (t < fall) return {speed * t, speed};
    const double after = std::max(0.0, speed - kMu * kBallGravity * fall), a = kMu * kBallGravity * (pull - 1);
    const double since = a < 0 ? std::min(t - fall, after / -a) : t - fall;
    return {speed * fall + (after + 0.5 * a * since) * since, after + a * since};
  }
  /// Of the centre, and its speed.
  Along upright(double t) const {
    const double left = height - 0.5 * kBallGravity * t * t;
    return t < landing() ? Along{0.5 * kSize + left, -kBallGravity * t} : Along{0.5 * kSize, 0};
  }
  WorldDef make(const WorldSettings& settings, double k) const {
    WorldDef def;
    def.name = "dragged cube";
    def.settings = settings;
    def.settings.gravity = Vector3(0, 0, -kBallGravity);
    def.settings.default_material = ruledMaterial(k, kMu);
    def.articulations.push_back(groundPlane());
    const double depth = height > 0 ? 0 : kMass * kBallGravity / (k * kSize * kSize);
    def.articulations.push_back(freeBox("cube", Vector3::Constant(kSize), kMass, Pose(Vector3(0, 0, 0.5 * kSize + height - depth)),
                                        {Vector3::Zero(), speed * dragDirection()}));
    if (pull > 0) def.pointers.push_back(ledBy(1, 0, kLead));
    return def;
  }
  /// A hand on a spring and a damper that turns nothing.
  static PointerDef ledBy(int articulation, double stiffness, double damping) {
    PointerDef hand;
    hand.articulation = articulation;
    hand.link = 0;
    hand.coupling.mode = PointerCoupling::Mode::kVirtual;
    hand.coupling.stiffness = stiffness;
    hand.coupling.damping = damping;
    hand.coupling.rotational_stiffness = hand.coupling.rotational_damping = 0;
    return hand;
  }
};

/// Two cubes on one another at rest, one a thousand times as heavy.
struct UnequalStack {
  static constexpr double kSize = 0.1, kLight = 0.1, kRatio = 1000, kMu = 0.5;  ///< [m], [kg], [1], [1]
  bool heavy_above = true;

  double mass(bool above) const { return above == heavy_above ? kRatio * kLight : kLight; }
  /// Exact force through the contact below the lower (false) or the upper cube [N].
  double force(bool upper) const { return kBallGravity * (mass(true) + (upper ? 0 : mass(false))); }
  static Vector3 place(bool above) { return {0, 0, (above ? 1.5 : 0.5) * kSize}; }
  WorldDef make(const WorldSettings& settings, double k) const {
    WorldDef def;
    def.name = "unequal stack";
    def.settings = settings;
    def.settings.gravity = Vector3(0, 0, -kBallGravity);
    def.settings.default_material = ruledMaterial(k, kMu);
    def.articulations.push_back(groundPlane());
    double sink = 0;
    for (const bool above : {false, true}) {
      sink += force(above) / (k * kSize * kSize);
      def.articulations.push_back(freeBox(above ? "upper" : "lower", Vector3::Constant(kSize), mass(above),
                                          Pose(Vector3(place(above) - Vector3(0, 0, sink)))));
    }
    return def;
  }
};

/// A ball that a hand presses on the plane and leads along it by a critically damped spring: it sticks until the spring pulls with μ N and
/// then runs after the hand. Its frame, its centre of mass and the hand are at its lowest point, so that nothing turns it.
struct Finger {
  static constexpr double kRadius = 0.02, kMass = 0.1, kMu = 0.5, kPress = 5;  ///< [m], [kg], [1], N with the weight [N]
  static constexpr double kSpring = 300, kSpeed = 0.05;                       ///< [N/m], of the hand [m/s]

  static double rate() { return std::sqrt(kSpring / kMass); }                 ///< ω [1/s]
  static double damping() { return 2 * std::sqrt(kSpring * kMass); }          ///< [N·s/m]
  static double height() { return (kMass * kBallGravity - kPress) / kSpring; }  ///< of the hand's target [m]
  static double slips() { return (kMu * kPress - damping() * kSpeed) / (kSpring * kSpeed); }  ///< when it starts to slide [s]
  /// With y = v t - x: m y'' + c y' + K y = μ N from x' = 0 on, so x' = v (1 - (1 + ω s) exp(-ω s)).
  static Along along(double t) {
    const double s = t - slips(), w = rate();
    if (s <= 0) return {};
    const double fade = elementary::exp(-w * s);
    return {kSpeed * (s - (2 - (2 + w * s) * fade) / w), kSpeed * (1 - (1 + w * s) * fade)};
  }
  /// Depth at which the cap carries what the spring still presses with: k π d² (R - d/3) = N - K d.
  static double depth(double k) {
    double d = 0;
    for (int i = 0; i < 100; ++i) d = std::sqrt((kPress - kSpring * d) / (k * M_PI * (kRadius - d / 3)));
    return d;
  }
  static WorldDef make(const WorldSettings& settings, double k) {
    WorldDef def;
    def.name = "finger";
    def.settings = settings;
    def.settings.gravity = Vector3(0, 0, -kBallGravity);
    def.settings.default_material = ruledMaterial(k, kMu);
    def.articulations.push_back(groundPlane());
    def.articulations.push_back(freeBody("finger", std::make_shared<Ball>(kRadius), kMass,
                                         0.4 * kMass * kRadius * kRadius * Matrix3::Identity(), Pose(Vector3(0, 0, -depth(k)))));
    def.articulations.back().links[0].collisions[0].X_LS.p.z() = kRadius;
    def.pointers.push_back(DraggedCube::ledBy(1, kSpring, damping()));
    return def;
  }
};

}  // namespace haptic::scenes
