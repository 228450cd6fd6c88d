/// Random presses on thin bodies, for the bench `hand` and the tests of the loop: a tool that is often larger than the plate it goes
/// through, at any rate, scale and mass. A number gives a press, the same on every machine.
#pragma once
#include <cmath>
#include <cstdio>
#include <random>
#include <string>

#include "haptic_core/geometry/pairs/shape_distance.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/loop/hand_trial.h"
#include "touch.h"

namespace haptic::scenes {

/// One press: the world, the hand on it, and its way.
struct ThinPress {
  WorldDef world;
  HandSettings settings;
  std::string device;  ///< name of its file
  TrialWay way;
  std::string text;
  bool isVirtual() const { return world.pointers.back().coupling.mode == PointerCoupling::Mode::kVirtual; }
};

/// Ball of 6 mm and 0.5 kg over a fixed plate of 2 mm: the smallest scene in which a virtual coupling rang with all of the device's force.
inline WorldDef ballOverThinPlate(double mass = 0.5, double radius = 0.006, double thickness = 0.002, double side = 0.3, double k = 2e7) {
  WorldDef world;
  world.settings.default_material.stiffness = k;
  world.settings.default_material.mu_static = world.settings.default_material.mu_dynamic = 0.5;
  world.articulations.push_back(staticBox("plate", Vector3(side, side, thickness), Pose(Vector3(0, 0, -thickness / 2))));
  const double moment = 0.4 * mass * radius * radius;
  world.articulations.push_back(
      freeBody("tool", std::make_shared<Ball>(radius), mass, moment * Matrix3::Identity(), Pose(Vector3(0, 0, radius + 0.004))));
  addPointer(world, 1, "spidar");
  world.pointers[0].coupling.mode = PointerCoupling::Mode::kVirtual;
  return world;
}

/// The random choices of a press.
class ThinPresses {
 public:
  explicit ThinPresses(unsigned press) : random_(7919u * press + 11u) {}

  ThinPress press() {
    ThinPress p;
    const char* devices[] = {"spidar_g6x3r", "spidar_g6x3r", "spidar_g6x4", "spidar_g6x5r", "spidar_g6c"};
    p.device = devices[pick(5)];
    const double rates[] = {1e3, 2e3, 5e3, 10e3};
    const double rate = rates[pick(4)];
    p.world.settings.step = 1 / rate;
    ContactMaterial& material = p.world.settings.default_material;
    material.stiffness = logUniform(1e6, 1e10);
    material.mu_static = material.mu_dynamic = pick(3) == 0 ? 0 : 0.5;
    if (pick(4) == 0) p.world.settings.gravity.setZero();
    thickness_ = logUniform(0.5e-3, 20e-3);
    size_ = logUniform(2e-3, 20e-3);
    const double mass = logUniform(5e-3, 1);
    const char* body = addBody(p.world);
    const char* tool = addTool(p.world, mass);
    p.world.pointers.back().coupling.mode = pick(2) == 0 ? PointerCoupling::Mode::kDirect : PointerCoupling::Mode::kVirtual;
    p.settings.workspace.X_WB.p = home_;
    p.settings.workspace.scale = logUniform(0.1, 20);
    way(p);
    char text[256];
    std::snprintf(text, sizeof text,
                  "%s %.1f mm %.3g kg on %s %.2f mm, %s, %g Hz, k %.1e, scale %.2g, %s, g %g, %.2g m/s, %.0f mm, %s", tool, 1e3 * size_,
                  mass, body, 1e3 * thickness_, p.device.c_str(), rate, material.stiffness, p.settings.workspace.scale,
                  p.isVirtual() ? "virtual" : "direct", -p.world.settings.gravity.z(), p.way.speed, 1e3 * p.way.depth,
                  p.way.jig ? "jig" : "hand");
    p.text = text;
    return p;
  }

 private:
  double uniform(double low, double high) { return low + (high - low) * (random_() / 4294967296.0); }
  double logUniform(double low, double high) { return low * elementary::exp(elementary::log(high / low) * uniform(0, 1)); }
  int pick(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }

  /// Through the plate, or as far as the workspace goes; half of them rest within as well.
  void way(ThinPress& p) {
    const DeviceDef device = loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/" + p.device + ".yaml");
    const double tilt = uniform(0, 0.5), around = uniform(0, 6.28), scale = p.settings.workspace.scale;
    const double aside = elementary::sin(tilt);
    p.way.direction = Vector3(aside * elementary::cos(around), aside * elementary::sin(around), -elementary::cos(tilt));
    p.way.speed = logUniform(0.02, 1);
    const double through = (kGap + thickness_ + 2 * size_) / scale;  // [m] of the grip
    p.way.depth = std::min(uniform(1.2, 3) * through + 0.01, workspaceEnd(device, p.way.direction));
    p.way.rest = 1;
    const double within = (kGap + uniform(0, 1) * (thickness_ + size_)) / scale / p.way.depth;
    if (pick(2) == 0 && within < 0.95) p.way.rests = {within, 1};
    p.way.jig = pick(4) == 0;
  }

  /// A body whose top is at z = 0: a plate or a peg, fixed, with a belt, led, or free on two posts.
  const char* addBody(WorldDef& world) {
    const bool peg = pick(5) == 0;
    const double side = peg ? 0.01 : logUniform(0.03, 0.3);
    const Vector3 size(side, peg ? 0.01 : side, thickness_);
    const Pose X(Vector3(0, 0, -0.5 * thickness_));
    const int kind = pick(6);
    ArticulationDef plate = kind < 4 ? staticBox("plate", size, X) : freeBox("plate", size, 1000 * size.prod(), X);
    if (kind == 3) plate.links[0].collisions[0].belt.V_L.linear = Vector3(uniform(-0.3, 0.3), uniform(-0.3, 0.3), 0);
    world.articulations.push_back(plate);
    if (kind == 4) lead(world, X);
    if (kind == 5) {
      for (const double s : {-1.0, 1.0}) {
        const Vector3 middle(s * 0.4 * side, 0, -thickness_ - 0.05);
        world.articulations.push_back(staticBox("post", Vector3(0.3 * side, side, 0.1), Pose(middle)));
      }
    }
    const char* const names[2][6] = {{"plate", "plate", "plate", "belt", "led plate", "free plate"},
                                     {"peg", "peg", "peg", "belted peg", "led peg", "free peg"}};
    return names[peg][kind];
  }

  /// To and fro by 10 mm along x and 2 mm along z, a period of two seconds.
  void lead(WorldDef& world, const Pose& X) {
    MotionDef motion;
    motion.name = "led";
    motion.articulation = 0;
    motion.link = 0;
    motion.repeat = true;
    for (int i = 0; i <= 40; ++i) {
      const double phase = 2 * M_PI * i / 40;
      motion.time.push_back(0.05 * i);
      motion.pose.push_back(Pose(X.p + Vector3(0.01 * elementary::sin(phase), 0, 0.001 * (elementary::cos(phase) - 1))));
    }
    world.motions.push_back(motion);
  }

  /// A tool of `size_` above the body, its pointer.
  const char* addTool(WorldDef& world, double mass) {
    const char* name = "";
    std::vector<std::pair<std::shared_ptr<const ConvexShape>, Pose>> pieces;
    switch (pick(10)) {
      case 0:
      case 1:
      case 2:
        name = "ball";
        pieces = {{std::make_shared<Ball>(size_), Pose()}};
        break;
      case 3:
      case 4:
      case 5:
        name = "box";
        pieces = {{box(size_ * Vector3(uniform(0.5, 2), uniform(0.5, 2), uniform(0.5, 2))), Pose()}};
        break;
      case 6: {
        name = "ring";
        constexpr int kSides = 8;
        for (int i = 0; i < kSides; ++i) {
          const Matrix3 R = rotationFromVector(2 * M_PI * i / kSides * Vector3::UnitZ()).toRotationMatrix();
          pieces.push_back({box(size_ * Vector3(0.3, 0.83, 0.4)), Pose(R, R * Vector3(size_, 0, 0))});
        }
        break;
      }
      default:
        name = "L";
        pieces = {{box(size_ * Vector3(0.5, 0.5, 2)), Pose()}, {box(size_ * Vector3(1.5, 0.5, 0.5)), Pose(size_ * Vector3(1, 0, -0.75))}};
    }
    const bool upright = pick(2) == 0;
    const Quaternion turned = upright ? Quaternion::Identity()
                                      : Quaternion(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)).normalized();
    double lowest = 0;
    const Matrix3 R = turned.toRotationMatrix();
    for (const auto& piece : pieces) {
      lowest = std::max(lowest, supportHeight(*piece.first, Pose(R, Vector3::Zero()) * piece.second, -Vector3::UnitZ()));
    }
    home_ = Vector3(0, 0, lowest + kGap);
    const double moment = 0.4 * mass * size_ * size_;
    ArticulationDef tool = freeBody("tool", pieces[0].first, mass, moment * Matrix3::Identity(), Pose(R, home_));
    tool.links[0].collisions.clear();
    for (const auto& piece : pieces) {
      CollisionDef collision;
      collision.name = "tool";
      collision.shape = piece.first;
      collision.X_LS = piece.second;
      tool.links[0].collisions.push_back(collision);
    }
    world.articulations.push_back(tool);
    addPointer(world, static_cast<int>(world.articulations.size()) - 1, "spidar");
    return name;
  }

  static constexpr double kGap = 1e-3;  ///< between tool and body at the start [m]
  std::mt19937 random_;
  double size_ = 0, thickness_ = 0;
  Vector3 home_ = Vector3::Zero();
};

}  // namespace haptic::scenes
