/// Motions that `./run bench step` compares with the same motion at small steps: slide, spin, push, press, rock, table,
/// crosses, dominoes, hexagon, stick-slip.
#pragma once
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "blocks.h"
#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "motions.h"
#include "moving.h"

namespace haptic::scenes {

/// A motion, and how finely its reference is stepped.
struct StepMotion {
  std::string name;
  double seconds;  ///< simulated
  int link;        ///< whose pose is compared
  int fine;        ///< steps of the reference (velocity Verlet) in one of the motion
  std::function<WorldDef(const WorldSettings&)> make;
  std::function<void(World&)> aim = [](World&) {};  ///< moves the hand to where it is at the end of the next step
};

constexpr double kHandPeriod = 0.4;  ///< of the hands that push and press [s]

/// A hand that goes to and fro along `way` and starts at rest: at `from`, and at from + way half a period later.
inline void swingHand(World& world, const Vector3& from, const Vector3& way) {
  const double w = 2 * M_PI / kHandPeriod, phase = w * (world.time() + world.settings().step);
  Twist V;
  V.linear = 0.5 * w * elementary::sin(phase) * way;
  world.setPointerTarget(0, Pose(from + 0.5 * (1 - elementary::cos(phase)) * way), V);
}

/// A cube of 0.1 m that slides at 1 m/s over the floor and spins [rad/s].
inline WorldDef slidingCube(const WorldSettings& settings, double k, double spin) {
  CubeParameters c;
  c.stiffness = k;
  WorldDef def = cubeOnFloor(c, settings);
  def.articulations[1].V_WA = Twist{Vector3(0, 0, spin), Vector3(1, 0, 0)};
  return def;
}

/// A cube on the floor, and a ball of 2 cm on a hand: link 2.
inline WorldDef cubeAndFinger(const WorldSettings& settings, double k, const Vector3& p_WF, const PointerCoupling& coupling = {}) {
  CubeParameters c;
  c.stiffness = k;
  WorldDef def = cubeOnFloor(c, settings);
  def.articulations.push_back(freeBody("finger", std::make_shared<Ball>(0.02), 0.1, 1.6e-5 * Matrix3::Identity(), Pose(p_WF)));
  PointerDef hand;
  hand.articulation = 2;
  hand.link = 0;
  hand.coupling = coupling;
  def.pointers.push_back(hand);
  return def;
}

/// A block of 5 × 5 × 20 cm on its edge, tilted by 0.1 rad: it rocks.
inline WorldDef rockingBlock(const WorldSettings& settings, double k) {
  constexpr double kWide = 0.05, kHigh = 0.2, kTilt = 0.1;
  WorldDef def;
  def.name = "rocking block";
  def.settings = settings;
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = k;
  m.dissipation = 10;
  m.mu_static = m.mu_dynamic = 0.8;
  def.articulations.push_back(floorBox());
  const Matrix3 R = rotationY(-kTilt);
  const Vector3 edge = R * Vector3(-kWide / 2, 0, -kHigh / 2);
  def.articulations.push_back(freeBox("block", Vector3(kWide, kWide, kHigh), 0.5, Pose(R, Vector3(0, 0, -1e-5) - edge)));
  return def;
}

/// All motions, at k 1e8 and 1e10 N/m³ where the contact's stiffness is free.
inline std::vector<StepMotion> stepMotions() {
  std::vector<StepMotion> all;
  PointerCoupling spring;
  spring.mode = PointerCoupling::Mode::kVirtual;
  spring.stiffness = 1000;
  spring.damping = 2;
  spring.rotational_stiffness = 0.1;
  spring.rotational_damping = 1e-4;
  const Vector3 beside(-0.072, 0, 0.04), above(0.01, 0, 0.122);
  const auto push = [beside](World& world) { swingHand(world, beside, Vector3(0.02, 0, 0)); };
  const auto press = [above](World& world) { swingHand(world, above, Vector3(0, 0, -0.01)); };
  for (const double k : {1e8, 1e10}) {
    const std::string of = k == 1e8 ? "_1e8" : "_1e10";
    const int fine = k == 1e8 ? 50 : 250;
    all.push_back({"slide" + of, 0.3, 1, fine, [k](const WorldSettings& s) { return slidingCube(s, k, 0); }});
    all.push_back({"spin" + of, 0.3, 1, fine, [k](const WorldSettings& s) { return slidingCube(s, k, 10); }});
    all.push_back({"push" + of, 0.6, 1, fine, [=](const WorldSettings& s) { return cubeAndFinger(s, k, beside); }, push});
    all.push_back({"press" + of, 0.6, 1, fine, [=](const WorldSettings& s) { return cubeAndFinger(s, k, above, spring); }, press});
    all.push_back({"rock" + of, 0.6, 1, fine, [k](const WorldSettings& s) { return rockingBlock(s, k); }});
  }
  all.push_back({"table", 0.6, 4, 20, [](const WorldSettings& s) { return table(s, 1e-3, 1e-4); }});
  all.push_back({"crosses", 0.25, 0, 50, [](const WorldSettings& s) { return crosses(s); }});
  all.push_back({"dominoes", 0.6, 12, 20, [](const WorldSettings& s) { return dominoes(s, 1.05); }});
  all.push_back({"hexagon", 1, 1, 50, [](const WorldSettings& s) { return hexagon(s, 1e8, 4); }});
  const auto pull = [](World& world) {
    CubeParameters c;
    c.mass = StickSlip::kMass;
    c.stiffness = StickSlip::kStiffness;
    Twist V;
    V.linear.x() = StickSlip::kSpeed;
    const double t = world.time() + world.settings().step;
    world.setPointerTarget(0, Pose(Vector3(StickSlip::kSpeed * t, 0, c.size / 2 - c.restDepth())), V);
  };
  all.push_back({"stick_slip", 2, 1, 20, [](const WorldSettings& s) { return StickSlip::scene(s); }, pull});
  return all;
}

}  // namespace haptic::scenes
