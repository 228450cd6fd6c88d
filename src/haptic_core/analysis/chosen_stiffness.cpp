#include "haptic_core/analysis/chosen_stiffness.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "haptic_core/analysis/flat_wall.h"
#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/pairs/shape_distance.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/spidar/wall_bound.h"

namespace haptic {
namespace {

constexpr int kMostHullSides = 64;  ///< of a hull's, evenly chosen: round bodies have many that are alike

/// Corners of all shapes in the link's frame; of a round one those of a fine hull of it.
std::vector<Vector3> cornersOf(const LinkDef& link) {
  std::vector<Vector3> corners;
  for (const CollisionDef& collision : link.collisions) {
    for (const Vector3& v : collision.shape->corners()) corners.push_back(collision.X_LS * v);
  }
  return corners;
}

double leastExtent(const LinkDef& link) {
  Vector3 lower = Vector3::Constant(INFINITY), upper = -lower;
  for (const CollisionDef& collision : link.collisions) {
    const ConvexShape::Box box = collision.shape->aabb(collision.X_LS);
    lower = lower.cwiseMin(box.lower);
    upper = upper.cwiseMax(box.upper);
  }
  return (upper - lower).minCoeff();
}

/// Whether the centre of mass lies over face f of the hull: the body stands on it.
bool standsOn(const ConvexPolyhedron& hull, const ConvexPolyhedron::Face& face, const Vector3& p_LC) {
  const Vector3 n = face.normal;
  for (int i = 0; i < face.count; ++i) {
    const auto corner = [&](int k) { return hull.vertices()[hull.loopVertex(face.first + k % face.count)]; };
    const Vector3 a = corner(i), b = corner(i + 1);
    if (n.cross(b - a).dot(p_LC - a) < 0) return false;
  }
  return true;
}

/// Common volume of a floor and all shapes when the link stands on the side `outward`, its lowest point `sink` deep [m³].
double commonVolume(const LinkDef& link, const Vector3& outward, double sink) {
  double lowest = -INFINITY, volume = 0;
  for (const CollisionDef& c : link.collisions) lowest = std::max(lowest, supportHeight(*c.shape, c.X_LS, outward));
  for (const CollisionDef& c : link.collisions) {
    const double depth = sink - (lowest - supportHeight(*c.shape, c.X_LS, outward));
    if (depth > 0) volume += FlatWall(*c.shape, c.X_LS.R.transpose() * outward).volume(depth);
  }
  return volume;
}

/// Sides on which the link can stand, outward normals; those of a lone ball are alike.
std::vector<Vector3> standingSides(const LinkDef& link) {
  if (link.collisions.size() == 1 && link.collisions[0].shape->sides().size() == 1) return {-Vector3::UnitZ()};
  std::vector<Vector3> sides;
  const ConvexPolyhedron hull = ConvexPolyhedron::hull(cornersOf(link), link.name);
  for (const ConvexPolyhedron::Face& face : hull.faces()) {
    if (standsOn(hull, face, link.inertia.p_LC)) sides.push_back(face.normal);
  }
  std::vector<Vector3> some;
  const std::size_t stride = 1 + sides.size() / kMostHullSides;
  for (std::size_t i = 0; i < sides.size(); i += stride) some.push_back(sides[i]);
  return some;
}

/// It has a surface on which it can lie.
bool lies(const LinkDef& link) {
  const auto bounded = [](const CollisionDef& collision) { return collision.shape->bounded(); };
  return !link.collisions.empty() && std::all_of(link.collisions.begin(), link.collisions.end(), bounded);
}

}  // namespace

RestingStiffness restingStiffness(const LinkDef& link, double weight, double thinnest, double sink) {
  RestingStiffness out;
  if (!lies(link) || !(weight > 0)) return out;
  out.extent = std::min(leastExtent(link), thinnest);
  for (const Vector3& side : standingSides(link)) {
    const double volume = commonVolume(link, side, sink * out.extent);
    if (volume > 0) out.stiffness = std::max(out.stiffness, weight / volume);
  }
  return out;
}

double carriedWeight(const ArticulationDef& articulation, int link, double gravity) {
  if (articulation.links[link].joint.type == JointType::kFixed && articulation.links[link].parent < 0) return 0;
  if (articulation.links[0].joint.type != JointType::kFloating) return gravity * articulation.links[link].inertia.mass;
  double mass = 0;
  for (const LinkDef& each : articulation.links) mass += each.inertia.mass;
  return gravity * mass;
}

double touchStiffness(const WorldDef& def, int pointer, const HandMapping& mapping) {
  const double h = def.settings.step, borne = largestWallStiffness(kRelaxedHandDamping, 0, h, loopDelay(h, kSlowestWire));
  return bearableFoundation(def, pointer, mapping, stiffestWall(borne, kItsCount));
}

}  // namespace haptic
