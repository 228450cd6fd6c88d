/// Scenes with an exact rigid solution: tilted cube, stick-slip, top, torque-free body, slope.
#pragma once
#include <array>

#include "blocks.h"

namespace haptic::scenes {

inline Matrix3 rotationY(double angle) { return rotationAbout(Vector3::UnitY(), angle); }

/// Cube of 2 m and 1 kg, tilted by 0.1 rad about an edge that lies in the floor just as deep as it carries the pivot
/// force of the rigid motion's start. It falls back on its face: link 1.
inline WorldDef tiltedCube(const WorldSettings& settings, double k = 4e4, double tangential_ratio = 0.25) {
  constexpr double kSize = 2, kMass = 1, kTilt = 0.1, kPivotForce = 6.855;
  WorldDef def;
  def.name = "tilted cube";
  def.settings = settings;
  def.settings.pressure_law = PressureLaw::kLinear;
  CubeParameters c;
  c.size = kSize;
  c.mass = kMass;
  c.stiffness = k;
  c.tangential = 1;
  c.tangential_ratio = tangential_ratio;
  def.settings.default_material = c.material();
  def.settings.default_material.mu_static = def.settings.default_material.mu_dynamic = 10;  // it must not slip
  def.articulations.push_back(floorBox(12, 1));
  // k × (triangle under the floor) × length = pivot force.
  const double depth = std::sqrt(2 * kPivotForce * elementary::sin(kTilt) * elementary::cos(kTilt) / (k * kSize));
  const Matrix3 R = rotationY(-kTilt);  // lifts +x
  const Vector3 edge = R * Vector3(-kSize / 2, 0, -kSize / 2);
  const Pose X_WL(R, Vector3(0, 0, -depth) - edge);
  def.articulations.push_back(cube("cube", c, X_WL));
  return def;
}

/// Rotation of the tilted cube about -y [rad].
inline double tiltOf(const Pose& X_WL) { return elementary::atan2(X_WL.R(2, 0), X_WL.R(0, 0)); }

/// Block of 2 kg on a floor (μ0 0.265, μ 0.160), pulled through 400 N/m by a hand that moves at 0.0642 m/s along x.
struct StickSlip {
  static constexpr double kMass = 2, kSpring = 400, kSpeed = 0.0642, kStatic = 0.265, kDynamic = 0.160;
  static constexpr double kStiffness = 1e8;  ///< k = k_t [N/m³]: 1e6 N/m on 0.1 m × 0.1 m

  static WorldDef scene(const WorldSettings& settings) {
    CubeParameters c;
    c.mass = kMass;
    c.stiffness = kStiffness;
    c.ratio = 0.5;
    c.tangential = 1;
    c.mu_static = kStatic;
    c.mu_dynamic = kDynamic;
    WorldDef def = cubeOnFloor(c, settings);
    def.name = "stick-slip";
    def.settings.pressure_law = PressureLaw::kLinear;
    PointerDef hand;
    hand.articulation = 1;
    hand.link = 0;
    hand.coupling.mode = PointerCoupling::Mode::kVirtual;
    hand.coupling.stiffness = kSpring;
    hand.coupling.damping = hand.coupling.rotational_stiffness = hand.coupling.rotational_damping = 0;
    def.pointers.push_back(hand);
    return def;
  }
  /// Moves the hand to where it is at the end of the next step, and steps.
  static void step(World& world, double height) {
    const double t = world.time() + world.settings().step;
    Twist V;
    V.linear.x() = kSpeed;
    world.setPointerTarget(0, Pose(Vector3(kSpeed * t, 0, height)), V);
    world.step();
  }

  /// Exact rigid motion of the block: position and velocity along x at time t.
  struct Motion {
    double position, velocity;
  };
  static Motion motion(double t, double mu_static = kStatic) {
    const double onset = mu_static * kMass * kGravity / (kSpring * kSpeed);  // first release
    if (t <= onset) return {0, 0};
    const double w = std::sqrt(kSpring / kMass), drop = (mu_static - kDynamic) * kMass * kGravity;
    // Slip: u = spring stretch - μ m g/k obeys ü = -w² u with u(0) = drop/k, u̇(0) = V; ends when u̇ = V again.
    const double u0 = drop / kSpring, phase = elementary::atan2(kSpeed / w, u0);
    const double slip = (M_PI + 2 * phase) / w;
    const double stick = 2 * u0 / kSpeed, period = slip + stick;
    const double cycles = std::floor((t - onset) / period), s = t - onset - cycles * period;
    const double advance = kSpeed * period;
    if (s >= slip) return {(cycles + 1) * advance, 0};
    const double u = u0 * elementary::cos(w * s) + kSpeed / w * elementary::sin(w * s);
    const double u_dot = -u0 * w * elementary::sin(w * s) + kSpeed * elementary::cos(w * s);
    return {cycles * advance + kSpeed * s + u0 - u, kSpeed - u_dot};
  }
  static double position(double t) { return motion(t).position; }
  static double period() {
    const double w = std::sqrt(kSpring / kMass), u0 = (kStatic - kDynamic) * kMass * kGravity / kSpring;
    return (M_PI + 2 * elementary::atan2(kSpeed / w, u0)) / w + 2 * u0 / kSpeed;
  }
};

/// Cone with its apex down on the floor, spinning, in slow steady precession; axis of the cone = z of link 1, origin at
/// the centre of mass, 37.5 mm above the apex.
struct Top {
  static constexpr double kRadius = 0.1, kHeight = 0.05, kMass = 0.1, kTilt = 0.2, kSpin = 50, kArm = 0.0375;
  static constexpr double kAxial = 3.000e-4, kTransverse = 1.59375e-4;  ///< [kg·m²] about the centre of mass
  static constexpr double kExact = 2.5805277, kExactSliding = 2.5159137;  ///< precession [rad/s]
  static constexpr int kFacets = 64;

  static WorldDef scene(const WorldSettings& settings, double k = 1e13, double mu = 10, int facets = kFacets) {
    std::vector<Vector3> points = {Vector3(0, 0, -kArm)};
    for (int i = 0; i < facets; ++i) {
      const double a = 2 * M_PI * i / facets;
      points.emplace_back(kRadius * elementary::cos(a), kRadius * elementary::sin(a), kHeight - kArm);
    }
    auto shape = std::make_shared<ConvexPolyhedron>(ConvexPolyhedron::hull(points));
    const Matrix3 R = rotationY(kTilt);
    const Vector3 axis = R.col(2);
    const double precession = mu > 0 ? kExact : kExactSliding;
    Twist V;
    V.angular = kSpin * axis + precession * (Vector3::UnitZ() - axis.z() * axis);
    // A frictionless apex slides under a centre of mass that stays.
    if (mu > 0) V.linear = V.angular.cross(kArm * axis);
    // The apex sinks until the cone's tip carries the weight: k (π/3) (r/h)² d³ = m g, tilted a little more.
    const double slope = kRadius / kHeight;
    const double depth = elementary::cbrt(kMass * kGravity / (k * M_PI / 3 * slope * slope));
    WorldDef def;
    def.name = "top";
    def.settings = settings;
    def.settings.torsional_friction = false;
    ContactMaterial& m = def.settings.default_material;
    m.stiffness = k;
    m.dissipation = 0;
    m.tangential_stiffness = k;
    m.mu_static = m.mu_dynamic = mu;
    def.articulations.push_back(floorBox(2, 0.2));
    const Vector3 p = kArm * axis - Vector3(0, 0, depth);
    def.articulations.push_back(freeBody("top", shape, kMass, Vector3(kTransverse, kTransverse, kAxial).asDiagonal(),
                                         Pose(R, Vector3(0, 0, p.z())), V));
    return def;
  }
  static double azimuth(const Pose& X_WL) { return elementary::atan2(X_WL.R(1, 2), X_WL.R(0, 2)); }
  static double tilt(const Pose& X_WL) { return elementary::atan2(X_WL.R.col(2).head<2>().norm(), X_WL.R(2, 2)); }
};

/// Free rotation near the unstable axis: link 0.
inline WorldDef tumblingBody(const WorldSettings& settings) {
  WorldDef def;
  def.name = "torque-free body";
  def.settings = settings;
  def.settings.gravity.setZero();
  Twist V;
  V.angular = Vector3(0.01, 5, 0.01);
  def.articulations.push_back(freeBody("body", nullptr, 1, Vector3(1, 2, 2.5).asDiagonal(), Pose(), V));
  return def;
}

/// Cube on a slab that a hand turns about the cube's centre: link 0 the slab (pointer 0), link 1 the cube.
struct Slope {
  static WorldDef scene(const CubeParameters& c, const WorldSettings& settings) {
    WorldDef def;
    def.name = "slope";
    def.settings = settings;
    def.settings.default_material = c.material();
    def.articulations.push_back(
        freeBox("slab", Vector3(20 * c.size, 4 * c.size, c.size), 1, slab(c, 0)));
    def.articulations.push_back(cube("cube", c, Pose(Vector3(0, 0, c.size / 2 - c.restDepth()))));
    PointerDef hand;
    hand.articulation = 0;
    hand.link = 0;
    def.pointers.push_back(hand);
    return def;
  }
  static Pose slab(const CubeParameters& c, double angle) {
    const Vector3 centre(0, 0, c.size / 2), below(0, 0, -c.size);
    return Pose(rotationY(angle), centre + rotationY(angle) * below);
  }
  /// One step with the slope at `tangent`, growing at `rate` [1/s].
  static void step(World& world, const CubeParameters& c, double tangent, double rate) {
    Twist V;
    V.angular.y() = rate / (1 + tangent * tangent);
    const Pose X = slab(c, elementary::atan2(tangent, 1));
    V.linear = V.angular.cross(X.p - Vector3(0, 0, c.size / 2));
    world.setPointerTarget(0, X, V);
    world.step();
  }
};

}  // namespace haptic::scenes
