// Presses of random tools into random scenes, to the workspace's end and back: no jump, no ring, no more than the device's limit.
// `bench_hand [PRESSES [FIRST]]`: 2000 presses from the first on, then as many on thin bodies (hand_thin.h). Each of them that is not quiet
// is printed. `bench_hand thin [PRESSES [FIRST]]`: those on thin bodies alone.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>

#include "../scenes/touch.h"
#include "figure.h"
#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/half_space.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "haptic_core/loop/hand_trial.h"
#include "haptic_core/spidar/wall_bound.h"
#include "hand_thin.h"

namespace haptic::bench {
namespace {

struct Press {
  WorldDef world;
  HandSettings settings;
  DeviceDef device;
  TrialWay way;
  std::string text;
};

/// The random choices of one press.
class Chooser {
 public:
  explicit Chooser(unsigned press) : random_(press + 1) {}

  Press press() {
    Press p;
    const char* devices[] = {"spidar_g6x3r", "spidar_g6x3r", "spidar_g6x4", "spidar_g6x5r", "spidar_g6c", "spidar_4"};
    const char* device = devices[pick(6)];
    p.device = loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/" + device + ".yaml");
    p.world.settings.step = 1e-3;
    size_ = logUniform(1e-3, 20e-3);
    const double k = logUniform(1e5, 1e9), scale = logUniform(0.1, 20);
    ContactMaterial& material = p.world.settings.default_material;
    material.stiffness = k;
    material.mu_static = material.mu_dynamic = pick(3) == 0 ? 0 : 0.5;
    const char* scene = addScene(p.world);
    const char* tool = addTool(p.world);
    p.world.pointers.back().coupling.mode = pick(5) < 3 ? PointerCoupling::Mode::kDirect : PointerCoupling::Mode::kVirtual;
    p.settings.workspace.X_WB.p = home_;
    p.settings.workspace.scale = scale;
    const double tilt = uniform(0, 1), around = uniform(0, 6.28);
    p.way.direction = Vector3(std::sin(tilt) * std::cos(around), std::sin(tilt) * std::sin(around), -std::cos(tilt));
    p.way.speed = logUniform(0.005, 0.5);
    p.way.depth = std::min(uniform(0.2, 1) * workspaceEnd(p.device, p.way.direction), 3 * p.way.speed);
    p.way.turn = p.device.dof > 3 ? uniform(0, 0.3) * Vector3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)) : Vector3(0, 0, 0);
    p.way.jig = pick(2) == 0;
    char text[256];
    std::snprintf(text, sizeof text, "%s %.1f mm on %s, %s, k %.1e, scale %.2g, %s, %.3g m/s, %.0f mm, mu %g, %s", tool, 1e3 * size_,
                  scene, device, k, scale,
                  p.world.pointers.back().coupling.mode == PointerCoupling::Mode::kDirect ? "direct" : "virtual", p.way.speed,
                  1e3 * p.way.depth, material.mu_static, p.way.jig ? "jig" : "hand");
    p.text = text;
    return p;
  }

 private:
  double uniform(double low, double high) { return low + (high - low) * (random_() / 4294967296.0); }
  double logUniform(double low, double high) { return low * std::exp(std::log(high / low) * uniform(0, 1)); }
  int pick(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }

  /// Something to press on whose top is at z = 0.
  const char* addScene(WorldDef& world) {
    using namespace scenes;
    const double cube = uniform(1, 4) * size_;
    switch (pick(5)) {
      case 0:
        world.articulations.push_back(staticBox("wall", Vector3(0.5, 0.5, 0.1), Pose(Vector3(0, 0, -0.05))));
        return "box";
      case 1: {
        ArticulationDef ground = staticBox("ground", Vector3(1, 1, 0.1), Pose());
        ground.links[0].collisions[0].shape = std::make_shared<HalfSpace>();
        world.articulations.push_back(ground);
        return "half-space";
      }
      case 2:
        world.articulations.push_back(staticBox("floor", Vector3(1, 1, 0.1), Pose(Vector3(0, 0, -0.05 - 2 * cube))));
        for (int i = 0; i < 2; ++i) world.articulations.push_back(loose("cube" + std::to_string(i), cube, {0, 0, -(i + 0.5) * cube}));
        return "stack";
      case 3: {
        const double wall = 5 * cube;
        world.articulations.push_back(staticBox("floor", Vector3(wall, wall, 0.02), Pose(Vector3(0, 0, -cube - 0.01))));
        for (int i = 0; i < 4; ++i) {
          const double s = i < 2 ? -1 : 1;
          const Vector3 along = i % 2 ? Vector3::UnitX() : Vector3::UnitY();
          const Vector3 size = Vector3(wall, wall, wall) - (wall - 0.02) * along;
          world.articulations.push_back(staticBox("side" + std::to_string(i), size, Pose(s * (wall / 2 + 0.01) * along)));
        }
        for (int i = 0; i < 3; ++i) {
          world.articulations.push_back(loose("cube" + std::to_string(i), cube, {(i - 1) * 1.1 * cube, 0, -0.5 * cube}));
        }
        return "bin";
      }
      default: {
        ArticulationDef arm = staticBox("arm", Vector3(0.2, 0.04, 0.02), Pose(Vector3(-0.08, 0, -0.01)));
        arm.links[0].inertia = {0.5, Vector3::Zero(), boxInertia(Vector3(0.2, 0.04, 0.02), 0.5)};
        arm.links[0].joint.type = JointType::kRevolute;
        arm.links[0].joint.axis = Vector3::UnitY();
        arm.links[0].joint.damping = 0.05;
        arm.links[0].joint.drive = JointDef::Drive::kPosition;
        arm.links[0].joint.drive_stiffness = logUniform(5, 500);
        arm.links[0].joint.drive_damping = 0.1;
        world.articulations.push_back(arm);
        return "robot";
      }
    }
  }

  ArticulationDef loose(const std::string& name, double size, const Vector3& p) {
    return scenes::freeBox(name, Vector3::Constant(size), std::max(1e-3, 800 * size * size * size), Pose(p));
  }

  /// A tool of `size_` above the scene, its pointer.
  const char* addTool(WorldDef& world) {
    const char* name = "";
    std::vector<std::pair<std::shared_ptr<const ConvexShape>, Vector3>> pieces;
    switch (pick(5)) {
      case 0:
        name = "ball";
        pieces = {{std::make_shared<Ball>(size_), Vector3::Zero()}};
        break;
      case 1:
        name = "box";
        pieces = {{std::make_shared<ConvexPolyhedron>(makeBox(size_ * Vector3(uniform(0.3, 2), uniform(0.3, 2), uniform(0.3, 2)))),
                   Vector3::Zero()}};
        break;
      case 2:
        name = "capsule";
        pieces = {{std::make_shared<Rod>(0.5 * size_, uniform(0.5, 8) * size_, Rod::Ends::kRound), Vector3::Zero()}};
        break;
      case 3:
        name = "hull";
        pieces = {{std::make_shared<ConvexPolyhedron>(makeSphere(size_)), Vector3::Zero()}};
        break;
      default:
        name = "pieces";
        for (int i = 0; i < 3; ++i) {
          pieces.push_back({std::make_shared<ConvexPolyhedron>(makeBox(size_ * Vector3(1, 1, 1))), Vector3((i - 1) * size_, 0, 0)});
        }
        pieces.push_back({std::make_shared<ConvexPolyhedron>(makeBox(size_ * Vector3(1, 1, 1))), Vector3(0, 0, -size_)});
    }
    const Quaternion turned = Quaternion(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)).normalized();
    double lowest = 0;
    for (const auto& piece : pieces) lowest = std::max(lowest, piece.second.norm() + piece.first->boundingRadius());
    home_ = Vector3(0, 0, lowest + 1e-3);
    ArticulationDef tool = scenes::freeBody("tool", pieces[0].first, 0.05, 2e-6 * Matrix3::Identity(), Pose(turned, home_));
    tool.links[0].collisions.clear();
    for (const auto& piece : pieces) {
      CollisionDef collision;
      collision.name = "tool";
      collision.shape = piece.first;
      collision.X_LS.p = piece.second;
      tool.links[0].collisions.push_back(collision);
    }
    world.articulations.push_back(tool);
    scenes::addPointer(world, static_cast<int>(world.articulations.size()) - 1, "spidar");
    return name;
  }

  std::mt19937 random_;
  double size_ = 0;
  Vector3 home_ = Vector3::Zero();
};

}  // namespace

constexpr int kJudgedOfAll = 4;  ///< every fourth press is judged by `check` too, and each one that rings

void measurePresses(int presses, int first) {
  TrialResult worst;
  int judged = 0, warned_and_quiet = 0, passed_and_rang = 0;
  long ticks = 0, touching = 0, impacts = 0, over = 0, led = 0;
  int rings = 0, jumps = 0, infinite = 0, refused = 0;
  for (int i = first; i < first + presses; ++i) {
    try {
      const Press p = Chooser(static_cast<unsigned>(i)).press();
      const TrialResult r = tryHand(p.world, 0, p.settings, p.device, p.way);
      ticks += r.ticks, touching += r.touching, impacts += r.impacts, over += r.over_limit, led += r.led;
      rings += r.rings, infinite += !r.finite;
      worst.jump = std::max(worst.jump, r.jump);
      worst.torque_jump = std::max(worst.torque_jump, r.torque_jump);
      worst.tension_jump = std::max(worst.tension_jump, r.tension_jump);
      if (i % kJudgedOfAll == 0 || r.rings) {
        const bool passes = pressHand(p.world, 0, p.settings, p.device).steady();
        judged += i % kJudgedOfAll == 0;
        warned_and_quiet += i % kJudgedOfAll == 0 && !passes && !r.rings;
        passed_and_rang += passes && r.rings;
      }
      if (r.steady() && r.jump <= kQuietJump && r.over_limit == 0) continue;
      jumps += r.jump > kQuietJump;
      std::printf("press %d: jump %.2f N %.3f N·m, tensions %.2f N, most %.1f N, over %d%s%s: %s\n", i, r.jump, r.torque_jump,
                  r.tension_jump, r.strongest, r.over_limit, r.rings ? ", rings" : "", r.finite ? "" : ", not finite", p.text.c_str());
    } catch (const SetupError& error) {
      std::printf("press %d refused: %s\n", i, error.what());
      ++refused;
    }
    std::fflush(stdout);
  }
  std::printf("%d presses, %d with a jump, %d refused, %d not finite\n", presses, jumps, refused, infinite);
  figure("hand.jump_over_stiffness_n", worst.jump, "N");
  figure("hand.jump_over_stiffness_nm", worst.torque_jump, "N·m");
  figure("hand.tension_jump_over_n", worst.tension_jump, "N");
  figure("hand.rings", rings, "1");
  figure("hand.check_says_pass_and_rings", passed_and_rang, "1");
  figure("hand.check_warns_and_is_quiet_pct", 100.0 * warned_and_quiet / std::max(1, judged), "%");
  figure("hand.asked_over_limit", static_cast<double>(over), "1");
  figure("hand.impact_ticks_pct", 100.0 * static_cast<double>(impacts) / static_cast<double>(std::max(1l, touching)), "%");
  figure("hand.led_ticks_pct", 100.0 * static_cast<double>(led) / static_cast<double>(std::max(1l, touching)), "%");
  figure("hand.presses_that_jump", jumps, "1");
  const DeviceDef device = loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/spidar_g6x3r.yaml");
  figure("hand.k_max_n_per_m",
         largestWallStiffness(device.grip_damping + kRelaxedHandDamping, 0, 1e-3, loopDelay(1e-3, device.delay_s)), "N/m");
}

}  // namespace haptic::bench

int main(int argc, char** argv) {
  using namespace haptic;
  const bool thin_alone = argc > 1 && std::strcmp(argv[1], "thin") == 0;
  if (thin_alone) --argc, ++argv;
  const int presses = argc > 1 ? std::atoi(argv[1]) : 2000, first = argc > 2 ? std::atoi(argv[2]) : 0;
  if (!thin_alone) bench::measurePresses(presses, first);
  bench::measureThinPresses(presses, first);
}
