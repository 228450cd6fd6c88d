// Scenes that move: heaps, dominoes, crosses, a carrier, an inner corner. Where no motion is the right one,
// conserved quantities and what may not overlap are the reference.
#include "../scenes/carriers.h"
#include "../scenes/heap.h"
#include "../scenes/inner_corner.h"
#include "../scenes/moving.h"
#include "own_measures.h"

namespace haptic::report {
namespace {

/// Deepest corner of a body below the floor z = 0 or beyond walls at |x|, |y| = half [m]; half ≤ 0: no walls.
double deepestCorner(const BodyState& b, const Vector3& size, double half) {
  double depth = 0;
  for (int i = 0; i < 8; ++i) {
    const Vector3 corner_L = 0.5 * size.cwiseProduct(Vector3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
    const Vector3 p = b.X_WL * corner_L;
    depth = std::max(depth, -p.z());
    if (half > 0) depth = std::max({depth, std::abs(p.x()) - half, std::abs(p.y()) - half});
  }
  return depth;
}

Measure penetration(const Vector3& size, double half) {
  return worst("penetration", [size, half](const Sample& s) {
    double depth = 0;
    for (const BodyState& b : s.bodies) depth = std::max(depth, deepestCorner(b, size, half));
    return depth;
  });
}

Scene heapOf(int count) {
  constexpr double kSize = 0.05;
  const int side = count <= 10 ? 2 : 4;
  const double half = 0.5 * (side * 0.075 + 0.02);  // of the bin, as scenes/heap.h builds it
  Scene s;
  s.name = "heap" + std::to_string(count);
  s.title = std::to_string(count) + " cubes that fall into a bin";
  s.parameters =
      "5 cm, 0.1 kg, random orientations, mu 0.5, five boxes that touch; lost: a cube beyond a wall or the "
      "floor";
  s.seconds = 2;
  s.samples = 40;
  s.stiffness = 1e8;
  s.size = kSize;
  s.chaotic = true;
  s.smallest_step = count > 50 ? 1e-3 : 0;
  for (int i = 0; i < count; ++i) s.bodies.push_back(5 + i);
  s.make = [count](const Choice& choice) {
    scenes::HeapParameters p;
    p.count = count;
    if (choice.stiffness > 0) p.stiffness = choice.stiffness;
    return scenes::heap(p, settingsOf(choice));
  };
  s.measures = {penetration(Vector3::Constant(kSize), half), energyGain()};
  s.escaped = [half](const Sample& sample) -> std::string {
    for (const BodyState& b : sample.bodies) {
      const Vector3& p = b.X_WL.p;
      if (p.z() < 0 || std::abs(p.x()) > half || std::abs(p.y()) > half)
        return "a cube went through the floor or a wall";
      if (p.z() > 2) return "a cube was launched above the walls";
    }
    return "";
  };
  return s;
}

Scene dominoRow() {
  Scene s;
  s.name = "dominoes";
  s.title = "Twelve dominoes that fall";
  s.parameters =
      "48 x 24 x 7.5 mm, 5 g, pitch 24 mm, mu 0.3, the first at 1.05 of its tip angle; lost: a stone still "
      "up after 1.5 s";
  s.seconds = 1.5;
  s.samples = 60;
  s.stiffness = 1e7;
  s.size = 0.048;
  s.chaotic = true;
  for (int i = 0; i < 12; ++i) s.bodies.push_back(1 + i);
  s.make = [](const Choice& choice) {
    WorldDef def = scenes::dominoes(settingsOf(choice), 1.05);
    if (choice.stiffness > 0) def.settings.default_material.stiffness = choice.stiffness;
    return def;
  };
  s.measures = {penetration(Vector3(0.0075, 0.024, 0.048), 0), energyGain()};
  s.escaped = [](const Sample& sample) -> std::string {
    for (const BodyState& b : sample.bodies) {
      if (b.X_WL.p.z() < 0) return "a stone went through the floor";
      if (b.X_WL.p.z() > 0.048) return "a stone was launched";
      if (sample.time > 1.49 && b.X_WL.R(2, 2) > 0.9) return "a stone did not fall";
    }
    return "";
  };
  return s;
}

Scene twoCrosses() {
  Scene s;
  s.name = "crosses";
  s.title = "Two tumbling crosses that meet in free space";
  s.parameters = "three bars 10 x 1 x 1 cm of 0.1 kg each, mu 0.5, no gravity";
  s.seconds = 0.6;
  s.samples = 60;
  s.stiffness = 1e9;
  s.bodies = {0, 1};
  s.chaotic = true;
  s.make = [](const Choice& choice) {
    WorldDef def = scenes::crosses(settingsOf(choice));
    if (choice.stiffness > 0) def.settings.default_material.stiffness = choice.stiffness;
    return def;
  };
  s.measures = {drift("angular_momentum_drift", &Sample::angular_momentum),
                drift("momentum_drift", &Sample::momentum), energyGain()};
  return s;
}

Scene turntable() {
  const scenes::CarriedCube cube;
  Scene s;
  s.name = "carrier";
  s.title = "Cube that friction carries on a turntable that spins up";
  s.parameters = "1 cm, 0.2 kg, mu 0.45, 0.2 m off the axis, 0.2 rad/s^2";
  s.reference = "rigid: it stays on its place of the disc (until 23.5 s)";
  s.seconds = 5;
  s.samples = 20;
  s.stiffness = cube.stiffness;
  s.size = cube.size;
  s.bodies = {1};
  s.not_for_peers = "the disc hangs on a joint; peers here run free and fixed bodies";
  s.make = [cube](const Choice& choice) {
    scenes::CarriedCube c = cube;
    if (choice.stiffness > 0) c.stiffness = choice.stiffness;
    return scenes::carried(scenes::Carrier::kTurntable, c, settingsOf(choice));
  };
  s.exact = [cube](double t) {
    const double angle = 0.5 * scenes::kSpinUp * t * t;
    const Matrix3 R = Eigen::AngleAxisd(angle, Vector3::UnitZ()).toRotationMatrix();
    const Vector3 p = R * Vector3(cube.radius, 0, 0.5 * cube.size), omega(0, 0, scenes::kSpinUp * t);
    return std::vector<BodyState>{{Pose(R, p), Twist{omega, omega.cross(p)}}};
  };
  return s;
}

Scene corner() {
  const scenes::CornerParameters corner;
  Scene s;
  s.name = "corner";
  s.title = "Cube in the corner of a floor and a wall, gravity turned towards the wall";
  s.parameters = "0.1 m, 0.5 kg, mu 0, gravity turned by 25 degrees, wall and floor touch";
  s.reference = "rigid: it stays";
  s.seconds = 1;
  s.stiffness = corner.stiffness;
  s.bodies = {2};
  s.make = [corner](const Choice& choice) {
    scenes::CornerParameters p = corner;
    if (choice.stiffness > 0) p.stiffness = choice.stiffness;
    return scenes::innerCorner(p, settingsOf(choice));
  };
  s.exact = [](double) { return std::vector<BodyState>{{Pose(Vector3(0.05, 0, 0.05)), Twist{}}}; };
  return s;
}

}  // namespace

std::vector<Scene> movingScenes() {
  return {heapOf(10), heapOf(100), dominoRow(), twoCrosses(), turntable(), corner()};
}

}  // namespace haptic::report
