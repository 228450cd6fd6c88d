#include "scene/scene_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "haptic_core/base/elementary.h"
#include "haptic_core/dynamics/articulation_def.h"
#include "haptic_core/geometry/shapes/convex_shape.h"

namespace haptic {
namespace {

constexpr double kReach = 0.05;     // from a pointer, in metres of the grip: the workspace of a small device [m]
constexpr double kGripRadius = 0.02;  // about that of the grips [m]
constexpr double kInHand = 0.005;   // a shape nearer to a pointer than this distance does not hide it [m]
constexpr double kFarLarger = 4;    // bodies larger than the view by this factor are ground, not content [1]
constexpr double kOverGround = 3e-4;  // what is drawn nearer to a face flickers [m]
// Beside the diagonals: no edge of a device's frame stands before the grip.
constexpr std::array<double, 8> kYaws{3.85, 4.3, 5.1, 3.5, 5.9, 2.7, 0.5, 1.2};

using Box = ConvexShape::Box;

Vector3 corner(const Box& box, int i) {
  return Vector3((i & 1) ? box.upper.x() : box.lower.x(), (i & 2) ? box.upper.y() : box.lower.y(), (i & 4) ? box.upper.z() : box.lower.z());
}

struct PlacedShape {
  Box box;    // in its own frame
  Pose X_WS;
};

/// The box around the collision shapes of a link at the start.
struct Body {
  int articulation = 0, link = 0;
  bool moves = false;
  Box box{Vector3::Constant(std::numeric_limits<double>::infinity()), Vector3::Constant(-std::numeric_limits<double>::infinity())};  // in W

  Vector3 size() const { return box.upper - box.lower; }
  double gap(const Body& other) const {
    return (box.lower - other.box.upper).cwiseMax(other.box.lower - box.upper).cwiseMax(0).norm();
  }
  void append(std::vector<Vector3>& corners) const {
    for (int i = 0; i < 8; ++i) corners.push_back(corner(box, i));
  }
};

struct Start {
  std::vector<Body> bodies;
  std::vector<PlacedShape> shapes;
};

Start startOf(const WorldDef& world) {
  Start start;
  for (std::size_t a = 0; a < world.articulations.size(); ++a) {
    const ArticulationDef& articulation = world.articulations[a];
    const std::vector<Pose> X_WL = initialPoses(articulation);
    std::vector<char> moves(articulation.links.size(), 0);
    for (std::size_t l = 0; l < articulation.links.size(); ++l) {
      const LinkDef& link = articulation.links[l];
      moves[l] = link.joint.type != JointType::kFixed || (link.parent >= 0 && moves[static_cast<std::size_t>(link.parent)]);
      Body body;
      body.articulation = static_cast<int>(a), body.link = static_cast<int>(l), body.moves = moves[l] != 0;
      for (const CollisionDef& collision : link.collisions) {
        if (!collision.shape->bounded()) continue;
        start.shapes.push_back({collision.shape->aabb(), X_WL[l] * collision.X_LS});
        for (int i = 0; i < 8; ++i) {
          const Vector3 at = start.shapes.back().X_WS * corner(start.shapes.back().box, i);
          body.box.lower = body.box.lower.cwiseMin(at);
          body.box.upper = body.box.upper.cwiseMax(at);
        }
      }
      if (body.box.lower.allFinite()) start.bodies.push_back(body);
    }
  }
  return start;
}

/// A ray from `from` along `to` meets the shape beyond the hand.
bool hides(const PlacedShape& shape, const Vector3& from, const Vector3& to) {
  const Vector3 p = shape.X_WS.R.transpose() * (from - shape.X_WS.p), d = shape.X_WS.R.transpose() * to;
  double enters = -std::numeric_limits<double>::infinity(), leaves = -enters;
  for (int i = 0; i < 3; ++i) {
    if (d[i] == 0) {
      if (p[i] < shape.box.lower[i] || p[i] > shape.box.upper[i]) return false;
      continue;
    }
    const double one = (shape.box.lower[i] - p[i]) / d[i], other = (shape.box.upper[i] - p[i]) / d[i];
    enters = std::max(enters, std::min(one, other));
    leaves = std::min(leaves, std::max(one, other));
  }
  return enters < leaves && enters > kInHand;
}

/// The first of kYaws from which fewest shapes hide what the hands hold.
double bestYaw(const std::vector<Vector3>& hands, const std::vector<PlacedShape>& shapes) {
  double best = kYaws[0];
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (const double yaw : kYaws) {
    const auto [sine, cosine] = elementary::sinCos(yaw);
    const auto [rise, level] = elementary::sinCos(kViewPitch);
    const Vector3 back(level * cosine, level * sine, rise);
    std::size_t count = 0;
    for (const Vector3& hand : hands) {
      const auto hidden = std::count_if(shapes.begin(), shapes.end(), [&](const PlacedShape& s) { return hides(s, hand, back); });
      count += static_cast<std::size_t>(hidden);
    }
    if (count < least) least = count, best = yaw;
  }
  return best;
}

/// What a pointer of this scale reaches: the moving bodies within its workspace; where there is none, the nearest body, of a fixed one the
/// part that lies within it.
std::vector<Body> inReach(const Body& pointer, double scale, const std::vector<Body>& bodies) {
  const double reach = kReach * scale;
  std::vector<Body> found;
  Body nearest;
  double least = std::numeric_limits<double>::infinity();
  for (const Body& body : bodies) {
    if (body.articulation == pointer.articulation) continue;
    const double gap = pointer.gap(body);
    if (body.moves && gap <= reach) found.push_back(body);
    if (gap < least) least = gap, nearest = body;
  }
  if (!found.empty() || !std::isfinite(least)) return found;
  if (!nearest.moves) {
    const Vector3 around = Vector3::Constant(reach + least);
    nearest.box = {nearest.box.lower.cwiseMax(pointer.box.lower - around), nearest.box.upper.cwiseMin(pointer.box.upper + around)};
  }
  return {nearest};
}

double lowestOf(const std::vector<Body>& bodies, const std::vector<Vector3>& content) {
  Vector3 low = Vector3::Zero(), high = low;
  if (!content.empty()) low = high = content[0];
  for (const Vector3& p : content) low = low.cwiseMin(p), high = high.cwiseMax(p);
  double lowest = low.z();
  for (const Body& body : bodies) {
    if (body.size().norm() <= kFarLarger * (high - low).norm()) lowest = std::min(lowest, body.box.lower.z());
  }
  return lowest + kOverGround;
}

}  // namespace

SceneView viewOf(const SceneDef& scene) {
  SceneView view;
  const Start start = startOf(scene.world);
  std::vector<Vector3> hands;
  double most = 0;
  for (const Body& body : start.bodies) {
    if (body.moves) body.append(view.scene);
  }
  for (const HandDef& hand : scene.hands) {
    const PointerDef& pointer = scene.world.pointers[static_cast<std::size_t>(hand.pointer)];
    const ArticulationDef& tree = scene.world.articulations[static_cast<std::size_t>(pointer.articulation)];
    Body held;
    held.articulation = pointer.articulation;
    const Vector3 at = (initialPoses(tree)[static_cast<std::size_t>(pointer.link)] * pointer.X_LP).p;
    held.box = {at - Vector3::Constant(kGripRadius), at + Vector3::Constant(kGripRadius)};
    held.append(view.hand);
    hands.push_back(at);
    for (const Body& body : inReach(held, hand.workspace.scale, start.bodies)) {
      body.append(view.hand);
      if (body.size().norm() <= most) continue;
      most = body.size().norm();
      view.largest.clear();
      body.append(view.largest);
    }
  }
  view.yaw = bestYaw(hands, start.shapes);
  view.ground = lowestOf(start.bodies, view.hand.empty() ? view.scene : view.hand);
  return view;
}

}  // namespace haptic
