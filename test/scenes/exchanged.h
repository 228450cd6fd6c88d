/// Two bodies of any kinds that start inside one another or apart, and heaps of ten: a scene that is written in another order must move
/// alike.
#pragma once
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "heap.h"
#include "haptic_core/geometry/pairs/shape_distance.h"
#include "haptic_core/geometry/shapes/cone.h"
#include "haptic_core/geometry/shapes/ellipsoid.h"

namespace haptic::scenes {

enum class BodyKind { kBox, kHull, kBall, kCapsule, kCylinder, kEllipsoid, kCone };
constexpr int kBodyKinds = 7;

inline std::shared_ptr<const ConvexShape> bodyOf(BodyKind kind, Dice& dice) {
  const auto size = [&] { return dice.uniform(0.01, 0.03); };
  switch (kind) {
    case BodyKind::kBox: return box(2 * Vector3(size(), size(), size()));
    case BodyKind::kHull: return sphereHull(20, size(), dice);
    case BodyKind::kBall: return std::make_shared<Ball>(size());
    case BodyKind::kCapsule: return std::make_shared<Rod>(size(), dice.uniform(0.02, 0.08), Rod::Ends::kRound);
    case BodyKind::kCylinder: return std::make_shared<Rod>(size(), dice.uniform(0.02, 0.08), Rod::Ends::kFlat);
    case BodyKind::kEllipsoid: return std::make_shared<Ellipsoid>(Vector3(size(), size(), size()));
    default: return std::make_shared<Cone>(size(), 0, dice.uniform(0.02, 0.06));
  }
}

inline Matrix3 turnOf(Dice& dice) {
  Quaternion q;
  do q = Quaternion(dice.uniform(-1, 1), dice.uniform(-1, 1), dice.uniform(-1, 1), dice.uniform(-1, 1));
  while (q.squaredNorm() > 1 || q.squaredNorm() < 0.01);
  return q.normalized().toRotationMatrix();
}

inline Vector3 vectorOf(Dice& dice, double most) {
  return most * Vector3(dice.uniform(-1, 1), dice.uniform(-1, 1), dice.uniform(-1, 1));
}

/// How far B lies from A along `way` where they begin to touch, both at their turns [m].
inline double touchingDistance(const ConvexShape& A, const Matrix3& R_A, const ConvexShape& B, const Matrix3& R_B, const Vector3& way) {
  double low = 0, high = A.boundingRadius() + B.boundingRadius();
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    ClosestPoints near;
    closestPoints(A, B, Pose(R_A.transpose() * R_B, R_A.transpose() * (middle * way)), R_A.transpose() * way, near);
    (near.separated ? high : low) = middle;
  }
  return high;
}

/// Two free bodies without gravity, of kinds, sizes, poses, speeds and a stiffness (1e6 … 1e10 N/m³) that `seed` gives. Of 98 in turn 49
/// overlap by up to a quarter of the lesser one's width, and 49 close in from up to 1 cm.
inline WorldDef twoBodies(int seed) {
  constexpr double kDensity = 1000;
  Dice dice(static_cast<std::uint64_t>(seed));
  const BodyKind kinds[2] = {static_cast<BodyKind>(seed % kBodyKinds), static_cast<BodyKind>(seed / kBodyKinds % kBodyKinds)};
  const bool apart = seed / (kBodyKinds * kBodyKinds) % 2 == 1;
  WorldDef def;
  def.settings.gravity.setZero();
  def.settings.default_material.stiffness = elementary::exp(dice.uniform(elementary::log(1e6), elementary::log(1e10)));
  std::shared_ptr<const ConvexShape> shapes[2] = {bodyOf(kinds[0], dice), bodyOf(kinds[1], dice)};
  if (kinds[0] == kinds[1] && dice.uniform(0, 1) < 0.3) shapes[1] = shapes[0];
  const Matrix3 turns[2] = {turnOf(dice), turnOf(dice)};
  const Vector3 way = turnOf(dice).col(0);
  const double touching = touchingDistance(*shapes[0], turns[0], *shapes[1], turns[1], way);
  const double inside = 0.25 * std::min(shapes[0]->leastWidth(), shapes[1]->leastWidth()) * dice.uniform(0, 1);
  const double distance = touching + (apart ? dice.uniform(0, 0.01) : -inside);
  for (int i = 0; i < 2; ++i) {
    const double mass = kDensity * shapes[i]->volume(), side = i ? 1 : -1;
    const Twist V{vectorOf(dice, 5), vectorOf(dice, 0.2) - (apart ? 0.3 * side : 0) * way};
    def.articulations.push_back(freeBody(i ? "b" : "a", shapes[i], mass, shapes[i]->massProperties(kDensity).I_com,
                                         Pose(turns[i], 0.5 * side * distance * way), V));
  }
  return def;
}

/// Ten bodies of a kind, or of all in turn, that fall into a bin.
inline WorldDef tenBodies(int kind) {
  constexpr double kDensity = 1000, kPitch = 0.075, kLayer = 0.08;
  Dice dice(static_cast<std::uint64_t>(1000 + kind));
  WorldDef def;
  def.settings.default_material.stiffness = 1e8;
  addBin(2 * kPitch + 0.02, def);
  for (int i = 0; i < 10; ++i) {
    const auto shape = bodyOf(static_cast<BodyKind>(kind < kBodyKinds ? kind : i % kBodyKinds), dice);
    def.articulations.push_back(freeBody("c" + std::to_string(i), shape, kDensity * shape->volume(),
                                         shape->massProperties(kDensity).I_com, heapPose(i, 2, kPitch, 0.03, kLayer),
                                         {Vector3::Zero(), Vector3(0, 0, -1)}));
  }
  return def;
}

/// Largest difference of any body's place, or of its turn times its radius, of two worlds whose links have the same names [m].
inline double differenceOf(const World& a, const World& b) {
  double most = 0;
  for (int l = 0; l < a.linkCount(); ++l) {
    const Pose &X = a.linkPose(l), &Y = b.linkPose(b.linkIndex(a.linkName(l)));
    const double turned = std::sqrt(0.5) * (X.R - Y.R).norm();  // 2 sin(half of the angle) … 2
    most = std::max({most, (X.p - Y.p).norm(), 0.03 * turned});
  }
  return most;
}

/// The largest way of any body, or of a point 3 cm from its middle as it turns, since it was at the poses `start` [m].
inline double wayOf(const World& world, const std::vector<Pose>& start) {
  double most = 0;
  for (int l = 0; l < world.linkCount(); ++l) {
    const Pose &X = world.linkPose(l), &Y = start[static_cast<std::size_t>(l)];
    most = std::max({most, (X.p - Y.p).norm(), 0.03 * std::sqrt(0.5) * (X.R - Y.R).norm()});
  }
  return most;
}

inline std::vector<Pose> posesOf(const World& world) {
  std::vector<Pose> poses;
  for (int l = 0; l < world.linkCount(); ++l) poses.push_back(world.linkPose(l));
  return poses;
}

/// The same scene with its bodies the other way round.
inline WorldDef reversed(WorldDef def) {
  std::reverse(def.articulations.begin(), def.articulations.end());
  return def;
}

}  // namespace haptic::scenes
