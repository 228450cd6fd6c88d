/// What services ask of a running world, of any size.
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <string>

#include "figure.h"
#include "haptic_core/base/error.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/world.h"
#include "robots_actors.h"
#include "scene/scene_file.h"

namespace haptic::bench {
namespace {

/// Log-uniform in 1e-12…1e12 of either sign; one in twenty is 0, nan or infinite.
class AnyNumbers {
 public:
  double one() {
    const unsigned kind = random_() % 60;
    if (kind < 3) return kind == 0 ? 0 : kind == 1 ? NAN : INFINITY;
    const double size = std::pow(10.0, std::uniform_real_distribution<double>(-12, 12)(random_));
    return random_() % 2 ? size : -size;
  }
  Vector3 three() { return {one(), one(), one()}; }
  /// Along one axis, two times in three: a call with six numbers of any size is nearly always refused for one of them.
  Vector3 few() {
    if (random_() % 3 == 0) return three();
    Vector3 v = Vector3::Zero();
    v[random_() % 3] = one();
    return v;
  }
  int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }

 private:
  std::mt19937 random_{10};
};

/// Throws SetupError where the world refuses.
std::string call(World& world, AnyNumbers& any) {
  const int link = any.below(world.linkCount());
  switch (any.below(4)) {
    case 0: {
      LinkWrench wrench;
      wrench.F = {any.below(2) ? any.few() : Vector3(Vector3::Zero()), any.few()};
      if (any.below(2)) wrench.p_L = 0.01 * Vector3(any.below(3) - 1, any.below(3) - 1, any.below(3) - 1);
      wrench.in_link = any.below(2) > 0;
      const double seconds = any.below(2) ? any.one() : 0.05;
      world.applyWrench(link, wrench, seconds);
      return "wrench on " + world.linkName(link);
    }
    case 1:
      world.setBodyPose(link, Pose(Vector3(any.few())), Twist{any.few(), any.few()});
      return "pose of " + world.linkName(link);
    case 2:
      world.setJointPositions({{any.below(world.jointCount()), any.one()}});
      return "joint position";
    default: {
      WorldTuning tuning = world.tuning();
      tuning.gravity = any.few();
      world.tune(tuning);
      return "gravity";
    }
  }
}

}  // namespace

void measureServices() {
  constexpr int kCalls = 10000, kFresh = 20, kSteps = 5;
  const SceneDef scene = loadScene(std::string(HAPTIC_SOURCE_DIR) + "/test/ros/actors.urdf");
  auto world = std::make_unique<World>(scene.world);
  const auto fresh = world->save();
  AnyNumbers any;
  int stopped = 0, refused = 0;
  for (int i = 0; i < kCalls; ++i) {
    if (i % kFresh == 0) world->restore(fresh);
    std::string what = "refused";
    try {
      what = call(*world, any);
    } catch (const SetupError&) {
      ++refused;
    }
    for (int s = 0; s < kSteps && world->report().finite; ++s) world->step();
    if (world->report().finite) continue;
    ++stopped;
    std::printf("stopped by call %d: %s\n", i, what.c_str());
    world = std::make_unique<World>(scene.world);
  }
  figure("wrench.world_stopped", stopped, "1");
  figure("wrench.refused", refused, "1");
}

}  // namespace haptic::bench
