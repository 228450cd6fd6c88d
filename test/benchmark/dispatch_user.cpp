// A user's own source, which `./run bench dispatch` compiles for several processors, with and without fused
// multiplications, and links with the core as it is. It prints hashes of worlds that it defines and steps.
// Its own numbers are exact in binary: an inexact sum of products would depend on the compiler's flags for
// this file.
#include <cinttypes>
#include <cstdio>
#include <memory>
#include <string>

#include "haptic_core/base/build_info.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/world/world.h"

namespace {

using namespace haptic;

ArticulationDef box(const std::string& name, const Vector3& size, JointType joint, const Pose& X_WL,
                    const Vector3& moments = Vector3::Ones()) {
  LinkDef link;
  link.name = name;
  link.joint.name = name + "_joint";
  link.joint.type = joint;
  link.inertia.mass = 0.5;
  link.inertia.I_C = moments.asDiagonal();
  CollisionDef collision;
  collision.name = name;
  collision.shape = std::make_shared<ConvexPolyhedron>(makeBox(size));
  link.collisions.push_back(collision);
  ArticulationDef def;
  def.name = name;
  def.links.push_back(link);
  def.X_WA = X_WL;
  return def;
}

/// `count` cubes of an eighth of a metre, turned at random, one above the other over a floor whose top is z =
/// 0.
WorldDef falling(int count, Attempts attempts) {
  static const Vector3 kTurns[] = {{0, 0, 0.3},      {0.7, -0.2, 1.1},  {-1.9, 0.4, 2.6},
                                   {2.2, 1.3, -0.8}, {-0.4, -1.2, 0.9}, {1.6, 0.8, 3.0}};
  WorldDef def;
  def.settings.attempts = attempts;
  def.articulations.push_back(
      box("floor", Vector3(4, 4, 0.5), JointType::kFixed, Pose(Vector3(0, 0, -0.25))));
  for (int i = 0; i < count; ++i) {
    const Pose X_WL(rotationFromRpy(kTurns[i]),
                    Vector3(0.015625 * i, -0.03125 * (i % 3), 0.0703125 + 0.1875 * i));
    def.articulations.push_back(box("cube" + std::to_string(i), Vector3::Constant(0.125),
                                    JointType::kFloating, X_WL, Vector3::Constant(0x1p-10)));
  }
  return def;
}

void run(const char* name, WorldDef def, int steps) {
  def.articulations[1].V_WA = {Vector3(0, 0, 20), Vector3(0.5, 0.25, 0)};
  World world(def);
  for (int i = 0; i < steps; ++i) world.step();
  std::printf("%s %016" PRIx64 "\n", name, world.hash());
}

}  // namespace

int main() {
  std::fprintf(stderr, "%s\n", buildFlags().c_str());
  run("spin", falling(1, Attempts::kAll), 600);
  run("spin_euler", falling(1, Attempts::kImplicitEuler), 600);
  run("heap", falling(6, Attempts::kAll), 800);
}
