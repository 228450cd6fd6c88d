/// Ground of many pieces, bodies that a hand leads over it, and how its inner edges are felt.
#pragma once
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "blocks.h"
#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/hulls/ground.h"
#include "haptic_core/geometry/shapes/half_space.h"

namespace haptic::scenes {

using GroundShapes = std::vector<std::shared_ptr<const ConvexShape>>;

/// A static body of several shapes, all in its own frame.
inline ArticulationDef staticPieces(const std::string& name, const GroundShapes& pieces, const Pose& X_WL = Pose()) {
  ArticulationDef def = freeBody(name, nullptr, 1, Matrix3::Identity(), X_WL);
  def.links[0].joint.type = JointType::kFixed;
  for (const auto& piece : pieces) {
    CollisionDef collision;
    collision.name = name + "/" + std::to_string(def.links[0].collisions.size());
    collision.shape = piece;
    def.links[0].collisions.push_back(collision);
  }
  return def;
}

/// A grid of `cells` × `cells` over a square of `size` [m], by a height of x and y [m].
template <class Height>
HeightGrid heightGrid(int cells, double size, Height height) {
  HeightGrid grid{cells + 1, cells + 1, Vector2(size, size), {}};
  for (int r = 0; r <= cells; ++r) {
    for (int c = 0; c <= cells; ++c) {
      grid.heights.push_back(height(size * (static_cast<double>(c) / cells - 0.5), size * (0.5 - static_cast<double>(r) / cells)));
    }
  }
  return grid;
}

inline GroundShapes groundOf(const HeightGrid& grid, double thickness = 0.2) {
  GroundReport report;
  return groundPieces(surfaceOf(grid, "field"), thickness, "field", report);
}

/// A prism under each triangle of level ground, none joined with its neighbours.
inline GroundShapes flatPrisms(int cells, double size, double thickness = 0.2) {
  const TriangleMesh mesh = surfaceOf(heightGrid(cells, size, [](double, double) { return 0.0; }), "field");
  GroundShapes pieces;
  for (const auto& t : mesh.triangles) {
    GroundReport report;
    const TriangleMesh one{{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}, {{0, 1, 2}}};
    pieces.push_back(groundPieces(one, thickness, "field", report)[0]);
  }
  return pieces;
}

/// A level square with rough ground round about it, so that its pieces cannot be one: |x|, |y| ≤ 0.3 of `size` is level.
inline HeightGrid plateau(int cells, double size) {
  return heightGrid(cells, size, [&](double x, double y) {
    const double out = std::max(0.0, std::max(std::abs(x), std::abs(y)) / size - 0.301);
    return size * out * (0.3 + 0.2 * elementary::sin(40 * x / size) * elementary::cos(30 * y / size)) * (out > 0 ? -1.0 : 0.0);
  });
}

/// Boxes side by side, `cells` × `cells` of them, their upper sides at z = 0.
inline std::vector<ArticulationDef> tiles(int cells, double size, double thickness = 0.2) {
  std::vector<ArticulationDef> out;
  const double edge = size / cells;
  for (int i = 0; i < cells * cells; ++i) {
    const Vector3 middle(edge * (i % cells + 0.5) - size / 2, edge * (i / cells + 0.5) - size / 2, -thickness / 2);
    out.push_back(staticBox("tile" + std::to_string(i), Vector3(edge, edge, thickness), Pose(middle)));
  }
  return out;
}

/// A body that a hand leads over the ground, at a constant depth.
struct LedBody {
  std::shared_ptr<const ConvexShape> shape;
  double height = 0;  ///< of its frame over the ground [m]
  double mass = 0.5;  ///< [kg]
};

/// Steps after which a body that is led stands where its hand is: it comes from above, stops short of the ground and enters it by shares.
constexpr int kEntered = 10;

/// World of one ground and a led body.
inline WorldDef ledOver(const std::vector<ArticulationDef>& ground, const LedBody& body, const Matrix3& R_WG = Matrix3::Identity()) {
  WorldDef def;
  def.settings.gravity = Vector3(0, 0, -kGravity);
  CubeParameters c;
  c.mass = body.mass;
  c.mu_static = c.mu_dynamic = 0.3;
  def.settings.default_material = c.material();
  for (ArticulationDef each : ground) {
    each.X_WA = Pose(R_WG, Vector3::Zero()) * each.X_WA;
    def.articulations.push_back(std::move(each));
  }
  const Matrix3 inertia = boxInertia(Vector3::Constant(0.1), body.mass);
  def.articulations.push_back(freeBody("body", body.shape, body.mass, inertia, Pose(Vector3(0, 0, 1))));
  PointerDef pointer;
  pointer.articulation = static_cast<int>(ground.size());
  pointer.link = 0;
  def.pointers.push_back(pointer);
  return def;
}

/// How a body is led: a straight line, turning about its z, or rolling.
struct LedMotion {
  Vector3 from = Vector3::Zero(), velocity = Vector3::Zero();  ///< over the ground [m], [m/s]
  double yaw = 0, spin = 0, rolls_on = 0;  ///< [rad], [rad/s]; radius on which it rolls [m], 0: it does not

  Twist twist() const {
    const Vector3 rolling = rolls_on > 0 ? Vector3(-velocity.y(), velocity.x(), 0) / rolls_on : Vector3(0, 0, 0);
    return {rolling + Vector3(0, 0, spin), velocity};
  }
  Pose at(double t, double height) const {
    const Vector3 w = twist().angular;
    const Matrix3 start = rotationAbout(Vector3::UnitZ(), yaw);
    const Matrix3 R = w.norm() > 0 ? Matrix3(rotationAbout(w.normalized(), w.norm() * t) * start) : start;
    return {R, from + velocity * t + Vector3(0, 0, height)};
  }
};

/// Largest difference between the wrenches on a body that is led over two grounds, their lever the body's radius, over its weight.
inline double edgeJump(const std::vector<ArticulationDef>& ground, const std::vector<ArticulationDef>& plane, const LedBody& body,
                       const LedMotion& motion, int steps, const Matrix3& R_WG = Matrix3::Identity()) {
  World over(ledOver(ground, body, R_WG)), on(ledOver(plane, body, R_WG));
  const Pose X_WG(R_WG, Vector3::Zero());
  double worst = 0;
  for (int k = 0; k < steps; ++k) {
    const Twist V = motion.twist();
    for (World* world : {&over, &on}) {
      world->setPointerTarget(0, X_WG * motion.at(k * world->settings().step, body.height), {R_WG * V.angular, R_WG * V.linear});
      world->step();
    }
    const Wrench difference = over.pointerWrench(0) - on.pointerWrench(0);
    const double error = std::max(difference.force.norm(), difference.torque.norm() / body.shape->boundingRadius());
    if (k > kEntered) worst = std::max(worst, error / (body.mass * kGravity));
    if (!(on.pointerWrench(0).force.norm() > 0) && k > kEntered) return std::nan("");  // it never touched
  }
  return worst;
}

}  // namespace haptic::scenes
