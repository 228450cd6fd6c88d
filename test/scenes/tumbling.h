/// A hand at 10 kHz that rubs one stack of two cubes, beside others whose upper cubes fall and tumble: near, far and all between.
#pragma once
#include <algorithm>

#include "haptic_core/world/world.h"
#include "stacks.h"

namespace haptic::scenes {

inline StackParameters stacksOfTwo(int count = 16) {
  StackParameters p;
  p.count = count, p.height = 2, p.hand = true;
  return p;
}

inline CubeParameters stiffCube(double stiffness = 1e8) {
  CubeParameters c;
  c.stiffness = stiffness;
  return c;
}

/// Links as of `stacks`: the upper cube of stack i is 2 + 2 i. The first stack stands.
inline WorldDef tumbling(double far_step, double stiffness = 1e8, int count = 16) {
  WorldSettings settings;
  settings.step = 1e-4, settings.far_step = far_step, settings.history_steps = 10;
  WorldDef def = stacks(stacksOfTwo(count), stiffCube(stiffness), settings);
  tumble(stacksOfTwo(count), def);
  return def;
}

/// The hand's next target: down on the first stack within 1000 steps, then along it.
inline void rubNext(World& world) {
  const double k = static_cast<double>(world.report().step);
  const Vector3 way(1e-6 * k, 0, -std::min(0.0205, 2e-5 * k));
  world.setPointerTarget(0, Pose(Vector3(handStart(stacksOfTwo(), stiffCube()) + way)), Twist{});
}

inline void rub(World& world) {
  rubNext(world);
  world.step();
}

}  // namespace haptic::scenes
