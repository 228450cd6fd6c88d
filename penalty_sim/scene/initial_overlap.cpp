#include "scene/initial_overlap.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <tuple>

#include "haptic_core/geometry/pairs/shape_distance.h"

namespace haptic {
namespace {

/// A resting contact is some micrometres deep; overlap beyond this share of the smaller shape is a mistake in
/// a pose.
constexpr double kDeepShare = 0.1;

struct PlacedLink {
  int articulation, link;
  const LinkDef* def;
  Pose X_WL;
  ConvexShape::Box box;  ///< around all shapes, in W
  bool is_static;
};

std::vector<PlacedLink> placeLinks(const WorldDef& world) {
  std::vector<PlacedLink> placed;
  for (std::size_t a = 0; a < world.articulations.size(); ++a) {
    const ArticulationDef& articulation = world.articulations[a];
    const std::vector<Pose> X_WL = initialPoses(articulation);
    for (std::size_t i = 0; i < articulation.links.size(); ++i) {
      const LinkDef& link = articulation.links[i];
      if (link.collisions.empty()) continue;
      PlacedLink entry{static_cast<int>(a),
                       static_cast<int>(i),
                       &link,
                       X_WL[i],
                       {Vector3::Constant(INFINITY), Vector3::Constant(-INFINITY)},
                       link.parent < 0 && link.joint.type == JointType::kFixed};
      for (const CollisionDef& collision : link.collisions) {
        const auto box = collision.shape->aabb(X_WL[i] * collision.X_LS);
        entry.box.lower = entry.box.lower.cwiseMin(box.lower);
        entry.box.upper = entry.box.upper.cwiseMax(box.upper);
      }
      placed.push_back(entry);
    }
  }
  return placed;
}

using LinkPair = std::tuple<int, int, int, int>;

LinkPair ordered(int articulation_a, int link_a, int articulation_b, int link_b) {
  if (std::make_pair(articulation_b, link_b) < std::make_pair(articulation_a, link_a)) {
    std::swap(articulation_a, articulation_b);
    std::swap(link_a, link_b);
  }
  return {articulation_a, link_a, articulation_b, link_b};
}

/// Deepest overlap of two links' shapes, and the same as a share of the smaller one's radius.
void deepest(const PlacedLink& a, const PlacedLink& b, double& depth, double& share) {
  depth = share = 0;
  for (const CollisionDef& ca : a.def->collisions) {
    for (const CollisionDef& cb : b.def->collisions) {
      const Pose X_AB = relativePose(a.X_WL * ca.X_LS, b.X_WL * cb.X_LS);
      const double d = overlapDepth(*ca.shape, *cb.shape, X_AB);
      depth = std::max(depth, d);
      share = std::max(share, d / std::min(ca.shape->boundingRadius(), cb.shape->boundingRadius()));
    }
  }
}

/// Along unit `n` [A's frame].
double overlapAlong(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, const Vector3& n) {
  return supportHeight(A, Pose(), n) + supportHeight(B, X_AB, -n);
}

double leastOverlapAlongSides(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB) {
  double least = INFINITY;
  for (const Vector3& n : A.sides()) least = std::min(least, overlapAlong(A, B, X_AB, n));
  return least;
}

}  // namespace

double overlapDepth(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB) {
  const double reach = A.boundingRadius() + B.boundingRadius();
  const Vector3 between = X_AB * B.centre() - A.centre();
  if (between.squaredNorm() > reach * reach) return 0;
  ClosestPoints closest;
  closestPoints(A, B, X_AB, between.norm() > 0 ? between : Vector3(Vector3::UnitX()), closest);
  if (closest.separated) return 0;
  double depth = std::min(leastOverlapAlongSides(A, B, X_AB), leastOverlapAlongSides(B, A, X_AB.inverse()));
  if (!A.flat() || !B.flat()) depth = std::min(depth, overlapAlong(A, B, X_AB, closest.direction));
  return std::max(0.0, depth);
}

void filterInitialOverlaps(LoadContext& context) {
  WorldDef& world = context.scene.world;
  std::set<LinkPair> filtered;
  for (const CollisionFilter& f : world.filters) {
    filtered.insert(ordered(f.articulation_a, f.link_a, f.articulation_b, f.link_b));
  }
  const std::vector<PlacedLink> links = placeLinks(world);
  for (std::size_t i = 0; i < links.size(); ++i) {
    for (std::size_t j = i + 1; j < links.size(); ++j) {
      const PlacedLink &a = links[i], &b = links[j];
      if (a.is_static && b.is_static) continue;
      if ((a.box.lower.array() > b.box.upper.array()).any() ||
          (b.box.lower.array() > a.box.upper.array()).any())
        continue;
      if (filtered.count(ordered(a.articulation, a.link, b.articulation, b.link))) continue;
      double depth, share;
      deepest(a, b, depth, share);
      const bool same_robot = a.articulation == b.articulation;
      if (depth > kTouches) context.scene.start_contacts.push_back({a.def->name, b.def->name, depth, same_robot});
      if (depth <= 0 || (!same_robot && share < kDeepShare)) continue;
      std::ostringstream text;
      text << "'" << a.def->name << "' and '" << b.def->name << "' overlap by " << depth * 1e3
           << " mm at the start";
      if (same_robot) {
        world.filters.push_back({a.articulation, a.link, b.articulation, b.link});
        text << ": they do not collide with each other; give a <haptic:collision_filter> or an SRDF to say "
                "so yourself";
      } else {
        text << ": they will be pushed apart; move one of them";
      }
      context.scene.warnings.push_back(context.places[b.articulation][b.link] + ": " + text.str());
    }
  }
}

}  // namespace haptic
