// In place of geometry/hulls/convex_hull.cpp, whose Qhull is not in the browser: packed scenes have their hulls already. Of the shapes
// that a packed scene makes again, a capsule alone would need one.
#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic {

ConvexPolyhedron ConvexPolyhedron::hull(const std::vector<Vector3>&, const std::string& name) {
  throw SetupError(name, "needs the hull of points, which the browser does not make", "give a cylinder or a mesh in place of a capsule");
}

}  // namespace haptic
