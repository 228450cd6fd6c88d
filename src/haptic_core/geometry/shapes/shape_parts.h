/// The numbers that define a shape: a file keeps them, and the shape is made again of them with the same bits.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "haptic_core/geometry/shapes/convex_shape.h"

namespace haptic {

class FieldReader;
class FieldWriter;

/// All that a shape's constructor takes. Which lengths there are follows from the kind: of a ball the radius; of a rod the radius and
/// half of its axis; of an ellipsoid three radii; of a cone the radii below and above and the length [m].
struct ShapeParts {
  ShapeKind kind = ShapeKind::kPolyhedron;  ///< which constructor
  bool round_ends = false;                  ///< of a rod: it is a capsule
  std::string name;                         ///< for messages
  std::vector<double> lengths;              ///< [m]
  std::vector<Vector3> vertices;            ///< of a polyhedron [m]
  std::vector<std::vector<int>> loops;      ///< of a polyhedron: its faces' vertices

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.kind), visit(s.round_ends), visit(s.name), visit(s.lengths), visit(s.vertices), visit(s.loops);
  }
};

/// Throws SetupError for a shape of a class that this file does not know.
ShapeParts partsOf(const ConvexShape& shape);
/// The shape again. Throws SetupError as its constructor does, and for parts that are of no shape.
std::shared_ptr<const ConvexShape> makeShape(const ShapeParts& parts);

void pack(FieldWriter& to, const ConvexShape& shape);                             ///< see base/packed_fields.h
void unpack(FieldReader& from, std::shared_ptr<const ConvexShape>& shape);        ///< see base/packed_fields.h

}  // namespace haptic
