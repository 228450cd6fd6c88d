// How stiff a wall the twin bears (Z-width), against the bound of Colgate & Schenkel, and how passive the port stays with
// the controller, measured on the twin's true motion.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "../scenes/touch.h"
#include "figure.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/spidar/wall_bound.h"
#include "loop_rig.h"

namespace haptic::bench {
namespace {

constexpr double kNeedle = 0.002;   // side of the pointer: small, so that its tilt has no lever [m]
constexpr double kDamping = 1.0;    // B of the grip [N·s/m]
constexpr double kGripMass = 0.1;   // [kg]
constexpr int kCalmHands = 32;      // whether one alone meets the edge of a count at the wrong moment is luck

/// A needle over a wall; `stiffness` [N/m] is that of the contact while the needle stands upright.
SceneDef wallScene(double stiffness, double rate) {
  SceneDef scene;
  const double k = stiffness / (kNeedle * kNeedle);
  scene.world = scenes::pointerOverWall(makeBox({kNeedle, kNeedle, 0.04}), 0.021, k, 1 / rate);
  for (ArticulationDef& body : scene.world.articulations) {
    ContactMaterial& material = body.links[0].collisions[0].material;
    material.mu_static = material.mu_dynamic = 0;
  }
  HandDef hand;
  hand.pointer = 0;
  hand.workspace.X_WB.p = Vector3(0, 0, 0.021);  // home is 1 mm above touch
  scene.hands.push_back(hand);
  return scene;
}

struct WallRig {
  WallRig(double stiffness, double rate, const TwinSettings& with, PassivityMode mode, double damping)
      : rig(wallScene(stiffness, rate), settingsOf(rate, mode)) {
    DeviceDef def = rig.device[0]->def();
    def.grip_mass = kGripMass;
    def.grip_damping = damping;
    TwinSettings settings = with;
    settings.period = 1 / rate;
    rig.twin[0] = std::make_unique<DeviceTwin>(def, settings);
  }
  static RigSettings settingsOf(double rate, PassivityMode mode) {
    RigSettings settings;
    settings.rate = rate;
    settings.passivity = mode;
    settings.soft_start = 0.05;
    return settings;
  }
  Rig rig;
};

/// The grip falls 1 mm onto the wall and lies on it under its weight. Stable: after 5 s its amplitude is at most two
/// encoder quanta.
bool isStable(double stiffness, double rate, bool with_hand) {
  TwinSettings twin;
  // Without a hand a jig still holds the grip upright, or the needle falls over.
  if (!with_hand) twin.hand_stiffness = twin.hand_damping = 0;
  twin.gravity = 9.8;
  if (with_hand) twin.path.keys = {{0, Vector3(0, 0, -0.003), Vector3::Zero(), 0}};
  WallRig wall(stiffness, rate, twin, PassivityMode::kOff, kDamping);
  Rig& rig = wall.rig;
  rig.run(static_cast<int>(5 * rate));
  double low = INFINITY, high = -INFINITY;
  for (int i = 0; i < static_cast<int>(0.5 * rate); ++i) {
    rig.run(1);
    const double z = rig.twin[0]->pose().X_BG.p.z();
    low = std::min(low, z);
    high = std::max(high, z);
  }
  const double quantum = std::fabs(rig.device[0]->def().strings[0].length_per_count);
  return 0.5 * (high - low) <= 2 * quantum && high < 0.01;
}

double largestStable(double rate, double guess, bool with_hand) {
  double low = guess / 8, high = guess * 8;
  if (!isStable(low, rate, with_hand)) return 0;
  for (int i = 0; i < 10; ++i) {
    const double middle = std::sqrt(low * high);
    (isStable(middle, rate, with_hand) ? low : high) = middle;
  }
  return low;
}

/// Force that was asked for against that of the world, over the ticks in contact after the soft start.
struct Distortion {
  double changed = 0, all = 0;  ///< [N²]
  void add(Rig& rig) {
    const HandReport& hand = rig.loop->report().hand[0];
    const Vector3 world = rig.world.pointerWrench(0).force;
    if (world.norm() == 0 || hand.fade < 1) return;
    changed += (hand.F_asked_B.force - world).squaredNorm();
    all += world.squaredNorm();
  }
  double percent() const { return 100 * std::sqrt(changed / all); }
};

/// Energy that the port absorbs, on the true motion: -Σ F·Δx with what the strings really did. `sample` is the largest
/// |F·v T| of one tick.
double lowestPortEnergy(WallRig& wall, int ticks, double& sample, Distortion& distortion) {
  Rig& rig = wall.rig;
  double energy = 0, lowest = 0;
  for (int i = 0; i < ticks; ++i) {
    const GripPose before = rig.twin[0]->pose();
    rig.run(1);
    distortion.add(rig);
    const GripPose& now = rig.twin[0]->pose();
    const Wrench& F = rig.twin[0]->stringWrench();
    const Vector3 turn = vectorFromRotation(Quaternion(Matrix3(now.X_BG.R * before.X_BG.R.transpose())));
    const double work = F.force.dot(now.X_BG.p - before.X_BG.p) + F.torque.dot(turn);
    energy -= work;
    lowest = std::min(lowest, energy);
    sample = std::max(sample, std::fabs(work));
  }
  return lowest;
}

/// 10³ hands of random stiffness, damping and path tap and rub on walls up to five times the bound.
void measurePassivity() {
  std::mt19937 random(7);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  double lowest = 0, lowest_off = 0, worst_over_sample = -INFINITY;
  Distortion distortion, undistorted;
  for (int hand = 0; hand < 1000; ++hand) {
    TwinSettings twin;
    twin.hand_stiffness = std::exp(uniform(std::log(50), std::log(1500)));
    twin.hand_damping = std::exp(uniform(std::log(0.5), std::log(15)));
    for (int k = 0; k < 6; ++k) {
      twin.path.keys.push_back({0.15 * (k + 1), Vector3(uniform(-5e-3, 5e-3), uniform(-5e-3, 5e-3), uniform(-8e-3, 2e-3)),
                                Vector3(uniform(-.05, .05), uniform(-.05, .05), 0), 0});
    }
    const double stiffness = uniform(200, 3000);
    double sample = 0, unused = 0;
    WallRig acting(stiffness, 1000, twin, PassivityMode::kAct, 0);
    const double energy = lowestPortEnergy(acting, 1000, sample, distortion);
    lowest = std::min(lowest, energy);
    worst_over_sample = std::max(worst_over_sample, -energy / std::max(sample, 1e-9));
    if (hand % 10 == 0) {
      WallRig observing(stiffness, 1000, twin, PassivityMode::kObserve, 0);
      lowest_off = std::min(lowest_off, lowestPortEnergy(observing, 1000, unused, undistorted));
    }
  }
  std::printf("lowest port energy without the controller (100 of the hands): %.3g J; with it at most %.2f of the largest "
              "|F·v T| below zero\n", lowest_off, worst_over_sample);
  figure("passivity.min_port_energy_j", lowest, "J");
  figure("passivity.min_port_energy_samples", -worst_over_sample, "1");
  figure("passivity.force_distortion_pct", distortion.percent(), "%");
}

/// What the controller changes of the force where nothing is unstable: calm hands press a soft wall.
void measureDistortion() {
  Distortion distortion;
  double dissipated = 0;
  for (int hand = 0; hand < kCalmHands; ++hand) {
    const double deeper = 1e-4 * hand / kCalmHands;  // six counts of a string
    TwinSettings twin;
    twin.path.keys = {{0.2, Vector3::Zero(), Vector3::Zero(), 0}, {1.0, Vector3(0, 0, -0.006 - deeper), Vector3::Zero(), 0},
                      {1.8, Vector3(0, 0, -0.002), Vector3::Zero(), 0}, {2.6, Vector3(0, 0, -0.007 - deeper), Vector3::Zero(), 0}};
    WallRig wall(500, 1000, twin, PassivityMode::kAct, kDamping);
    for (int i = 0; i < 3000; ++i) {
      wall.rig.run(1);
      distortion.add(wall.rig);
    }
    dissipated = std::max(dissipated, wall.rig.loop->report().hand[0].dissipated);
  }
  std::printf("passivity controller on %d calm hands: at most %.3g J dissipated\n", kCalmHands, dissipated);
  figure("passivity.force_distortion_calm_pct", distortion.percent(), "%");
}

}  // namespace

void measureStability() {
  // Delay of the twin: counts of tick n lead to tensions that act from tick n + 1 on, one period; the half period is
  // the hold's.
  double ratio_worst = 1;
  for (const double rate : {1000.0, 10000.0}) {
    const double bound = largestWallStiffness(kDamping, 0, 1 / rate, loopDelay(1 / rate, 0));
    const double free = largestStable(rate, bound, false);
    const double held = largestStable(rate, 8 * bound, true);
    const std::string suffix = rate == 1000 ? "_1k" : "_10k";
    figure("zwidth.k_max_n_per_mm" + suffix, 1e-3 * free, "N/mm");
    figure("zwidth.k_max_hand_n_per_mm" + suffix, 1e-3 * held, "N/mm");
    std::printf("bound at %.0f Hz: %.4g N/mm, measured over bound %.3f\n", rate, 1e-3 * bound, free / bound);
    if (std::fabs(std::log(free / bound)) >= std::fabs(std::log(ratio_worst))) ratio_worst = free / bound;
  }
  figure("zwidth.ratio_to_bound", ratio_worst, "1");
  measurePassivity();
  measureDistortion();
}

}  // namespace haptic::bench
