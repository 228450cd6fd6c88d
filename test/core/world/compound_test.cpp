/// A body of several convex pieces is one body: each contact counts once, as on the undivided shape.
#include <gtest/gtest.h>

#include <random>

#include "../../scenes/blocks.h"

namespace haptic {
namespace compound_test {

using namespace scenes;

/// Boxes that fill a box of `size` about `centre`, cut at the middle of x and of y.
std::vector<CollisionDef> quarters(const Vector3& size, const Vector3& centre) {
  std::vector<CollisionDef> pieces;
  for (int i = 0; i < 4; ++i) {
    CollisionDef piece;
    piece.name = "piece" + std::to_string(i);
    piece.shape = box(Vector3(size.x() / 2, size.y() / 2, size.z()));
    piece.X_LS =
        Pose(centre + Vector3((i & 1 ? 0.25 : -0.25) * size.x(), (i & 2 ? 0.25 : -0.25) * size.y(), 0));
    pieces.push_back(piece);
  }
  return pieces;
}

/// A cube that a hand holds over a floor.
WorldDef heldCube(bool divided_cube, bool divided_floor) {
  CubeParameters c;
  WorldDef def = cubeOnFloor(c, WorldSettings{});
  if (divided_cube)
    def.articulations[1].links[0].collisions = quarters(Vector3::Constant(c.size), Vector3::Zero());
  if (divided_floor) def.articulations[0].links[0].collisions = quarters(Vector3(4, 4, 0.5), Vector3::Zero());
  PointerDef pointer;
  pointer.articulation = 1;
  pointer.link = 0;
  def.pointers.push_back(pointer);
  return def;
}

/// The wrench on the held cube along a path that presses it, tilts it and slides it over the middle of the
/// floor.
std::vector<Wrench> wrenchesOf(const WorldDef& def) {
  World world(def);
  std::vector<Wrench> wrenches;
  const Vector3 velocity(0.3, 0.05, 0);
  const double h = def.settings.step;
  for (int i = 0; i < 400; ++i) {
    const double t = i * h;
    const Pose X(rotationFromVector(Vector3(0.02 * std::sin(9 * t), 0.015 * std::cos(7 * t), 0)),
                 Vector3(-0.06, -0.01, 0.05 - 2e-3) + t * velocity);
    world.setPointerTarget(0, X, Twist{Vector3::Zero(), velocity});
    world.step();
    wrenches.push_back(world.pointerWrench(0));
  }
  return wrenches;
}

TEST(Compound, CountsEachContactOnce) {
  const std::vector<Wrench> whole = wrenchesOf(heldCube(false, false));
  double weight = 0;
  for (const Wrench& F : whole) weight = std::max(weight, F.force.norm());
  ASSERT_GT(weight, 1);
  for (const auto& [cube, floor] : {std::pair{true, false}, {false, true}, {true, true}}) {
    const std::vector<Wrench> divided = wrenchesOf(heldCube(cube, floor));
    double normal = 0, friction = 0, torque = 0;
    for (std::size_t i = 20; i < whole.size(); ++i) {  // from when it slides
      normal = std::max(normal, std::abs(divided[i].force.z() - whole[i].force.z()));
      friction = std::max(friction, (divided[i].force - whole[i].force).head<2>().norm());
      torque = std::max(torque, (divided[i].torque - whole[i].torque).norm());
    }
    // Normal forces are sums of the same volumes. Friction of pieces is that of the whole up to the sliders'
    // elastic slip on area that has just joined: a step's way over the patch, 0.3 mm of 0.1 m, times μ.
    EXPECT_LT(normal, 1e-9 * weight) << cube << floor;
    EXPECT_LT(friction, 0.5 * 3e-3 * weight) << cube << floor;
    EXPECT_LT(torque, 0.05 * 3e-3 * weight) << cube << floor;
  }
}

}  // namespace compound_test
}  // namespace haptic
