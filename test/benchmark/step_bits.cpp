/// On what the bits of a step depend: not on its number, and not on the units of length.
#include <cmath>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "../scenes/heap.h"
#include "../scenes/motions.h"
#include "../scenes/shipped_scenes.h"
#include "figure.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/world/state.h"
#include "step_figures.h"

namespace haptic::bench {
namespace {

using namespace scenes;

const std::string kScenes = std::string(HAPTIC_SOURCE_DIR) + "/urdf/scenes/";
constexpr int kSteps = 1000;

/// A world and its hand.
struct Case {
  std::string name;
  WorldDef def;
  /// Moves the hands to where they are at a time [s], with lengths times a factor.
  std::function<void(World&, double t, double scale)> aim = [](World&, double, double) {};
  int steps = kSteps;
};

void pullStickSlip(World& world, double t, double scale) {
  CubeParameters c;
  c.mass = StickSlip::kMass;
  c.stiffness = StickSlip::kStiffness;
  Twist V;
  V.linear.x() = scale * StickSlip::kSpeed;
  world.setPointerTarget(0, Pose(scale * Vector3(StickSlip::kSpeed * t, 0, c.size / 2 - c.restDepth())), V);
}

/// Blocks, stick-slip, and a heap of ten.
std::vector<Case> cases() {
  std::vector<Case> all;
  all.push_back({"blocks", loadScene(kScenes + "blocks.urdf").world});
  all.push_back({"stick_slip", StickSlip::scene(stepSettings()), pullStickSlip});
  all.push_back({"heap10", heap({}, stepSettings())});
  return all;
}

/// Whether anything of the state but its number and time depends on the number of the first step.
bool dependsOnIndex(const Case& c) {
  std::uint64_t hash[2];
  for (const int first : {0, 7}) {
    World world(c.def);
    State state = world.state();
    state.step = static_cast<std::uint64_t>(first);
    world.restore(state.pack());
    for (int i = 1; i <= c.steps; ++i) {
      c.aim(world, i * c.def.settings.step, 1);
      world.step();
    }
    state = world.state();
    state.step = 0;
    state.time = 0;
    hash[first == 0 ? 0 : 1] = state.hash();
  }
  return hash[0] != hash[1];
}

std::shared_ptr<const ConvexShape> scaled(const ConvexShape& shape, double s) {
  if (const Ball* ball = shape.ball()) return std::make_shared<Ball>(s * ball->radius());
  const ConvexPolyhedron* polyhedron = shape.polyhedron();
  if (!polyhedron || !polyhedron->isBox()) throw std::runtime_error("only boxes and balls are scaled");
  return std::make_shared<ConvexPolyhedron>(makeBox(2 * s * polyhedron->halfSize()));
}

/// The same world with all lengths times `s`, a power of two, and all masses times s³; its times stay. Boxes and balls only.
WorldDef scaled(WorldDef def, double s) {
  const double mass = s * s * s;
  const auto scaleMaterial = [&](ContactMaterial& m) {
    for (double* pressure_per_way : {&m.stiffness, &m.damping, &m.tangential_stiffness, &m.tangential_damping, &m.rest_stiffness,
                                     &m.touch_stiffness}) {
      *pressure_per_way *= mass / (s * s);
    }
    m.dissipation /= s;
  };
  def.settings.gravity *= s;
  ContactMaterial& usual = def.settings.default_material;  // what nothing says has a unit as well
  if (!(usual.stiffness > 0)) usual.stiffness = DefaultMaterial::kStiffness;
  if (!(usual.dissipation >= 0)) usual.dissipation = DefaultMaterial::kDissipation;
  scaleMaterial(usual);
  for (ArticulationDef& articulation : def.articulations) {
    articulation.X_WA.p *= s;
    articulation.V_WA.linear *= s;
    for (LinkDef& link : articulation.links) {
      link.joint.X_PJ.p *= s;
      link.inertia.mass *= mass;
      link.inertia.p_LC *= s;
      link.inertia.I_C *= mass * s * s;
      for (CollisionDef& collision : link.collisions) {
        collision.shape = scaled(*collision.shape, s);
        collision.X_LS.p *= s;
        scaleMaterial(collision.material);
      }
    }
  }
  for (PointerDef& pointer : def.pointers) {
    for (double* c : {&pointer.coupling.stiffness, &pointer.coupling.damping}) *c *= *c > 0 ? mass : 1;
    for (double* c : {&pointer.coupling.rotational_stiffness, &pointer.coupling.rotational_damping}) *c *= *c > 0 ? mass * s * s : 1;
  }
  return def;
}

/// Whether poses and twists of the scaled world, in scaled units, differ from the world's own in any bit of any step.
bool dependsOnScale(const Case& c, double s) {
  World one(c.def), other(scaled(c.def, s));
  for (int i = 1; i <= c.steps; ++i) {
    c.aim(one, i * c.def.settings.step, 1);
    c.aim(other, i * c.def.settings.step, s);
    one.step();
    other.step();
    for (int l = 0; l < one.linkCount(); ++l) {
      const Pose X = one.linkPose(l), Y = other.linkPose(l);
      const Twist V = one.linkTwist(l), U = other.linkTwist(l);
      const bool same = X.R == Y.R && s * X.p == Y.p && V.angular == U.angular && s * V.linear == U.linear;
      if (!same) {
        std::printf("%s times %g differs from step %d on, link %d: %.3g m of its own\n", c.name.c_str(), s, i, l,
                    (Y.p / s - X.p).norm());
        return true;
      }
    }
  }
  return false;
}

}  // namespace

void runBits() {
  int index = 0, scale = 0;
  for (const Case& c : cases()) {
    const bool differs = dependsOnIndex(c);
    if (differs) std::printf("%s depends on the number of its first step\n", c.name.c_str());
    index += differs;
    for (const double s : {1024.0, 1.0 / 1024}) scale += dependsOnScale(c, s);
  }
  for (const ShippedScene& scene : shippedScenes(kScenes)) {
    if (!scene.def.world.joint_paths.empty()) continue;  // drives that follow the clock
    Case c{scene.name, scene.def.world};
    c.aim = [&scene](World& world, double t, double) {
      for (const HandDef& hand : scene.def.hands) {
        const WorkspaceMap map = mapOnPath(hand, t);
        world.setPointerTarget(hand.pointer, map.X_WP(), map.V_WP());
      }
    };
    const bool differs = dependsOnIndex(c);
    if (differs) std::printf("%s depends on the number of its first step\n", c.name.c_str());
    index += differs;
  }
  figure("index.bits_differ", index, "1");
  figure("scale.bits_differ", scale, "1");
}

}  // namespace haptic::bench
