/// Many stacks of cubes on one floor, and a hand among them: worlds in which nearly everything stands.
#pragma once
#include <string>

#include "blocks.h"
#include "haptic_core/base/elementary.h"

namespace haptic::scenes {

struct StackParameters {
  int count = 200, height = 5;  ///< stacks; cubes of each
  double pitch = 0.25;          ///< of their square grid [m]
  double rocks = 0;             ///< speed of every cube at the start, in all axes [m/s]
  bool hand = false;            ///< a pointer, a cube of 2 cm that its hand holds, 2 cm above the first stack
};

/// Where the axis of stack i stands [m].
inline Vector3 stackAt(const StackParameters& p, int i) {
  int side = 1;
  while (side * side < p.count) ++side;
  return {p.pitch * (i % side), p.pitch * (i / side), 0};
}

inline Vector3 handStart(const StackParameters& p, const CubeParameters& c) {
  return stackAt(p, 0) + Vector3(0, 0, p.height * c.size + 0.03);
}

/// Links: 0 is the floor, then the cubes, stack by stack and from below; the hand's last.
inline WorldDef stacks(const StackParameters& p, const CubeParameters& c, const WorldSettings& settings) {
  WorldDef def;
  def.name = std::to_string(p.count) + " stacks of " + std::to_string(p.height);
  def.settings = settings;
  def.settings.default_material = c.material();
  const Vector3 far = stackAt(p, p.count - 1);
  def.articulations.push_back(staticBox("floor", Vector3(2 * far.y() + 4, 2 * far.y() + 4, 0.5), Pose(Vector3(0, 0, -0.25))));
  Twist V;
  V.linear = Vector3::Constant(p.rocks);
  V.angular = Vector3::Constant(p.rocks / c.size);
  for (int i = 0; i < p.count; ++i) {
    double top = 0;
    for (int k = 0; k < p.height; ++k) {
      top -= (p.height - k) * c.restDepth();
      def.articulations.push_back(cube("c" + std::to_string(i) + "_" + std::to_string(k), c,
                                       Pose(Vector3(stackAt(p, i) + Vector3(0, 0, top + c.size / 2))), V));
      top += c.size;
    }
  }
  if (!p.hand) return def;
  CubeParameters tool = c;
  tool.size = 0.02;
  def.articulations.push_back(cube("tool", tool, Pose(handStart(p, c))));
  PointerDef pointer;
  pointer.articulation = static_cast<int>(def.articulations.size()) - 1;
  pointer.link = 0;
  def.pointers.push_back(pointer);
  return def;
}

/// Lifts the upper cubes of stacks of two, but that of the first, so that they fall and tumble beside it.
inline void tumble(const StackParameters& p, WorldDef& def) {
  for (int i = 1; i < p.count; ++i) {
    ArticulationDef& upper = def.articulations[static_cast<std::size_t>(2 * i + 2)];
    upper.X_WA.p += Vector3(0.02 * elementary::sin(i), 0.02 * elementary::cos(2 * i), 0.02 + 0.01 * i);
    upper.X_WA.R = rotationFromRpy(Vector3(i, 2 * i, 3 * i));
    upper.V_WA.angular = Vector3(elementary::sin(i), elementary::cos(i), 1);
  }
}

}  // namespace haptic::scenes
