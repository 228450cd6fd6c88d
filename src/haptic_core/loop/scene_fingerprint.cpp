#include <memory>

#include "haptic_core/base/fields.h"
#include "haptic_core/geometry/ball.h"
#include "haptic_core/geometry/convex_polyhedron.h"
#include "haptic_core/geometry/half_space.h"
#include "haptic_core/geometry/rod.h"
#include "haptic_core/loop/session.h"

namespace haptic {

/// A shape by its corners and by how its faces are made of them; a ball by its radius, a half-space by its infinite one, a rod by its
/// lengths and ends.
template <class Visit>
void eachNumber(const std::shared_ptr<const ConvexShape>& shape, Visit&& visit) {
  if (!shape) return;
  if (shape->halfSpace()) return visit(shape->boundingRadius());
  if (shape->ball()) return visit(shape->ball()->radius());
  if (const Rod* rod = shape->rod()) {
    visit(rod->radius());
    visit(rod->halfLength());
    return visit(rod->rounding());
  }
  eachNumber(shape->polyhedron()->vertices(), visit);
  for (const ConvexPolyhedron::Face& face : shape->polyhedron()->faces()) visit(face.count);
}

std::uint64_t fingerprint(const WorldDef& def) {
  std::uint64_t hash = hashFields(kHashStart, def);
  // Lengths, which tell lists apart that hold the same numbers one after the other.
  std::vector<std::uint64_t> lengths{def.articulations.size(), def.loops.size(), def.joint_paths.size(),
                                     def.pointers.size(), def.filters.size()};
  for (const ArticulationDef& articulation : def.articulations) {
    lengths.push_back(articulation.links.size());
    for (const LinkDef& link : articulation.links) lengths.push_back(link.collisions.size());
  }
  for (const JointPathDef& path : def.joint_paths) lengths.push_back(path.time.size());
  return hashFields(hash, lengths);
}

}  // namespace haptic
