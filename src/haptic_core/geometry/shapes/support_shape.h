/// A convex solid of which nothing but its support function is known.
#pragma once
#include <memory>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic {

/// Has everything that a shape must answer from its support function (`core` and `rounding`), so that a new kind of solid collides
/// with all others as soon as a class says that. Distance, time of impact and bounds are those of the true solid; contacts, pictures
/// and, unless the class knows better, mass are those of a polyhedron (`tessellation`), off by no more than `tessellationError`.
/// A class of its own ends its constructor with `tessellate`, and states its numbers (`eachNumber`). See cone.h.
class SupportShape : public ConvexShape {
 public:
  using ConvexShape::aabb;
  Box aabb(const Pose& X_WS) const override;
  TriangleMesh triangles() const override { return hull_->triangles(); }
  bool flat() const override { return false; }
  double surface() const override { return hull_->surface(); }
  double leastWidth() const override { return hull_->leastWidth(); }
  int faceCount() const override { return hull_->faceCount(); }
  int edgeCount() const override { return hull_->edgeCount(); }
  std::vector<Vector3> sides() const override;  ///< along the axes of its frame
  std::vector<Vector3> corners() const override { return hull_->vertices(); }
  const ConvexPolyhedron* tessellation() const override { return hull_.get(); }
  double tessellationError() const override { return error_; }

 protected:
  explicit SupportShape(const std::string& name) : ConvexShape(ShapeKind::kSupport, name) {}  ///< `name` for messages

  /// The hull of the support points along 642 directions. Throws SetupError where they span no volume.
  void tessellate();
  /// A polyhedron of the class's own making, with the solid's mass properties at density 1, or the polyhedron's.
  void tessellate(ConvexPolyhedron hull, const MassProperties& properties);

 private:
  std::shared_ptr<const ConvexPolyhedron> hull_;
  double error_ = 0;
};

}  // namespace haptic
