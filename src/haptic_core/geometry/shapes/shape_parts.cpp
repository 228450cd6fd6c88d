#include "haptic_core/geometry/shapes/shape_parts.h"

#include "haptic_core/base/packed_fields.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/cone.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/geometry/shapes/ellipsoid.h"
#include "haptic_core/geometry/shapes/half_space.h"
#include "haptic_core/geometry/shapes/rod.h"

namespace haptic {
namespace {

/// The lengths of a rod's, an ellipsoid's or a cone's constructor are exact: half of a length doubled, or the length itself.
double lengthAt(const ShapeParts& parts, std::size_t index) {
  if (index >= parts.lengths.size()) throw SetupError(parts.name, "lacks a length", "write its file again");
  return parts.lengths[index];
}

}  // namespace

ShapeParts partsOf(const ConvexShape& shape) {
  ShapeParts parts;
  parts.kind = shape.kind();
  parts.name = shape.name();
  switch (shape.kind()) {
    case ShapeKind::kHalfSpace:
      return parts;
    case ShapeKind::kBall:
      parts.lengths = {shape.ball()->radius()};
      return parts;
    case ShapeKind::kRod:
      parts.lengths = {shape.rod()->radius(), shape.rod()->halfLength()};
      parts.round_ends = shape.rod()->isCapsule();
      return parts;
    case ShapeKind::kEllipsoid:
      for (const double radius : shape.ellipsoid()->radii()) parts.lengths.push_back(radius);
      return parts;
    case ShapeKind::kPolyhedron: {
      const ConvexPolyhedron& solid = *shape.polyhedron();
      parts.vertices = solid.vertices();
      parts.loops.resize(static_cast<std::size_t>(solid.faceCount()));
      for (int f = 0; f < solid.faceCount(); ++f) {
        for (int i = 0; i < solid.cornerCount(f); ++i) parts.loops[static_cast<std::size_t>(f)].push_back(solid.key(f, i));
      }
      return parts;
    }
    case ShapeKind::kSupport:
      if (const auto* cone = dynamic_cast<const Cone*>(&shape)) {
        parts.lengths = {cone->radius(), cone->topRadius(), 2 * cone->halfLength()};
        return parts;
      }
  }
  throw SetupError(shape.name(), "is of a class without parts", "add it to geometry/shapes/shape_parts.cpp");
}

std::shared_ptr<const ConvexShape> makeShape(const ShapeParts& parts) {
  switch (parts.kind) {
    case ShapeKind::kHalfSpace:
      return std::make_shared<const HalfSpace>(parts.name);
    case ShapeKind::kBall:
      return std::make_shared<const Ball>(lengthAt(parts, 0), parts.name);
    case ShapeKind::kRod:
      return std::make_shared<const Rod>(lengthAt(parts, 0), 2 * lengthAt(parts, 1),
                                         parts.round_ends ? Rod::Ends::kRound : Rod::Ends::kFlat, parts.name);
    case ShapeKind::kEllipsoid:
      return std::make_shared<const Ellipsoid>(Vector3(lengthAt(parts, 0), lengthAt(parts, 1), lengthAt(parts, 2)), parts.name);
    case ShapeKind::kPolyhedron:
      return std::make_shared<const ConvexPolyhedron>(parts.vertices, parts.loops, parts.name);
    case ShapeKind::kSupport:
      return std::make_shared<const Cone>(lengthAt(parts, 0), lengthAt(parts, 1), lengthAt(parts, 2), parts.name);
  }
  throw SetupError(parts.name, "is of no known kind", "write its file again");
}

void pack(FieldWriter& to, const ConvexShape& shape) { to(partsOf(shape)); }

void unpack(FieldReader& from, std::shared_ptr<const ConvexShape>& shape) {
  ShapeParts parts;
  from(parts);
  shape = makeShape(parts);
}

}  // namespace haptic
