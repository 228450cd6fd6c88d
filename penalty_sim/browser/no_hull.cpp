// In place of geometry/hulls/convex_hull.cpp, whose Qhull is not in the browser: of the shapes that a packed scene makes again none needs
// it. Support shapes of other classes (geometry/shapes/support_shape.h) would, and cannot be packed.
#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic {

ConvexPolyhedron ConvexPolyhedron::hull(const std::vector<Vector3>&, const std::string& name) {
  throw SetupError(name, "needs the hull of points, which the browser does not make", "pack the scene anew");
}

}  // namespace haptic
