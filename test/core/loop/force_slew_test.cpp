// The law of the port: no faster than a wall of K by the grip's way, and ρ beside it; and in the loop, where the world strikes the tool.
#include "haptic_core/spidar/force_slew.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "../../scenes/touch.h"
#include "haptic_core/loop/haptic_loop.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/world/hand_bound.h"
#include "haptic_core/spidar/spidar.h"

namespace haptic {
namespace force_slew_test {

constexpr double kPeriod = 1e-3, kStiffness = 4000, kReach = 0.02;  // [s], [N/m], [m]

Vector3 some(std::mt19937& random, double size) {
  std::normal_distribution<double> normal;
  return size * Vector3(normal(random), normal(random), normal(random));
}

TEST(ForceSlew, KeepsItsBoundAndArrives) {
  std::mt19937 random(1);
  const ForceSlew slew{kStiffness, kReach, kForceRate};
  int held = 0, whole = 0;
  for (int i = 0; i < 2000; ++i) {
    const double change = std::exp(-7 + 9.0 * (i % 10) / 9);
    const Wrench last{some(random, 0.1), some(random, 3)};
    const Wrench before{last.torque + some(random, 0.02 * change), last.force + some(random, change)};
    const Wrench F{before.torque + some(random, 0.02 * change), before.force + some(random, change)};
    const Twist moved{some(random, 0.3), some(random, 0.05)};
    const Wrench given = slew.led(F, before, last, moved, kPeriod);
    const double way = kPeriod * moved.linear.norm(), turn = kPeriod * moved.angular.norm();
    const double force = kStiffness * way + kForceRate * kPeriod, torque = kReach * (force + kStiffness * kReach * turn);
    EXPECT_LE((given.force - last.force).norm(), force * (1 + 1e-12));
    EXPECT_LE((given.torque - last.torque).norm(), torque * (1 + 1e-12));
    if ((F.force - last.force).norm() <= force) { EXPECT_EQ(given.force, F.force); }
    if ((F.torque - last.torque).norm() <= torque) { EXPECT_EQ(given.torque, F.torque); }
    ++((given.force - F.force).norm() > 0 ? held : whole);
    // Where the world's force stays it is straight ahead, and as far as it may.
    const Wrench towards = slew.led(F, F, last, moved, kPeriod);
    const Vector3 rest = F.force - towards.force, all = F.force - last.force;
    EXPECT_NEAR(rest.norm(), std::max(0.0, all.norm() - force), 1e-12 * (1 + all.norm()));
    EXPECT_LT(rest.cross(all).norm(), 1e-12 * (1 + all.squaredNorm()));
  }
  EXPECT_GT(held, 200);
  EXPECT_GT(whole, 200);
}

// A force that swings faster than it may turns in the tick in which the world's turns: what only runs after it turns late.
TEST(ForceSlew, TurnsWithTheWorld) {
  const ForceSlew slew{kStiffness, kReach, kForceRate};
  const Twist moved{Vector3::Zero(), Vector3(0.2, 0, 0)};  // 0.8 N in a tick
  Wrench world, given;
  int turns = 0;
  double last_change = 0, last_given_change = 0;
  for (int i = 1; i < 200; ++i) {
    const Wrench next{Vector3::Zero(), Vector3(0, 0, 9 * std::sin(2 * M_PI * i / 16.0))};  // up to 3.5 N in a tick
    const Wrench led = slew.led(next, world, given, moved, kPeriod);
    const double change = next.force.z() - world.force.z(), given_change = led.force.z() - given.force.z();
    if (i > 32 && change * last_change < 0) {
      ++turns;
      EXPECT_LT(given_change * last_given_change, 0) << i;
    }
    last_change = change, last_given_change = given_change;
    world = next, given = led;
  }
  EXPECT_GT(turns, 15);
}

// The world lets go of F at once. A grip that goes back meets the force of a spring of K, F²/2K in all, whatever its speed.
TEST(ForceSlew, GivesTheHandNoMoreThanASpringHolds) {
  const ForceSlew slew{kStiffness, kReach, kForceRate};
  const double most = 10;
  for (const double speed : {0.05, 0.5}) {
    Wrench F{Vector3::Zero(), Vector3(0, 0, most)};
    const Twist back{Vector3::Zero(), Vector3(0, 0, speed)};
    double work = 0;
    int ticks = 0;
    for (; F.force.norm() > 0 && ticks < 1000; ++ticks) {
      const Wrench next = slew.led(Wrench{}, Wrench{}, F, back, kPeriod);
      work += 0.5 * (F.force + next.force).dot(back.linear) * kPeriod;
      F = next;
    }
    const double slope = kStiffness + kForceRate / speed;  // [N/m]
    EXPECT_NEAR(work, most * most / (2 * slope), 0.5 * slope * speed * speed * kPeriod * kPeriod);  // the last tick
    EXPECT_NEAR(ticks, most / (slope * speed * kPeriod), 1);
  }
  Wrench F{Vector3::Zero(), Vector3(0, 0, most)};
  int ticks = 0;
  for (; F.force.norm() > 0 && ticks < 1000; ++ticks) F = slew.led(Wrench{}, Wrench{}, F, Twist{}, kPeriod);
  EXPECT_NEAR(ticks, most / (kForceRate * kPeriod), 1);
}

// A cube flies against the tool of a grip that rests: newtons within a tick of the world, and the hand gets what the law gives.
TEST(ForceSlew, NoBodyStrikesTheHand) {
  WorldDef world = scenes::pointerOverWall(makeBox(Vector3::Constant(0.01)), 0.1, 1e8, kPeriod);
  world.settings.gravity.setZero();
  ArticulationDef cube = scenes::springyBody("cube", makeBox(Vector3::Constant(0.01)), JointType::kFloating, Vector3::Zero(), 1e8);
  cube.X_WA.p.z() = 0.7;
  cube.V_WA.linear.z() = -0.5;  // 0.1 kg on 4571 N/m: 11 N within 7 ms
  world.articulations.push_back(cube);
  const DeviceDef def = loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/spidar_g6x3r.yaml");
  World scene(world);
  Spidar spidar(def);
  TwinSettings settings;
  settings.period = kPeriod;
  DeviceTwin twin(def, settings);
  HapticLoop loop(scene);
  HandSettings hand;
  hand.workspace.X_WB.p = Vector3(0, 0, 0.1);
  loop.attach(spidar, 0, hand);
  spidar.calibrateAtHome();
  spidar.setForceEnabled(true);
  double world_jump = 0, jump = 0, most = 0;
  Vector3 last = Vector3::Zero(), last_world = Vector3::Zero();
  GripPose last_grip;
  for (int i = 0; i < 3000; ++i) {
    twin.place(GripPose{});
    const DeviceSample sample = twin.exchange(loop.drive(0));
    loop.tick(&sample, kPeriod);
    const HandReport& now = loop.report().hand[0];
    const double way = i == 0 ? 0 : (now.X_BG.p - last_grip.X_BG.p).norm();
    jump = std::max(jump, (now.F_asked_B.force - last).norm() - spidar.stableStiffness() * way);
    world_jump = std::max(world_jump, (scene.pointerWrench(0).force - last_world).norm());
    most = std::max(most, now.F_asked_B.force.norm());
    last = now.F_asked_B.force, last_world = scene.pointerWrench(0).force, last_grip.X_BG = now.X_BG;
  }
  EXPECT_GT(world_jump, 1);
  EXPECT_GT(most, 0.5);
  EXPECT_LE(jump, kForceRate * kPeriod * (1 + 1e-9));
}

}  // namespace force_slew_test
}  // namespace haptic
