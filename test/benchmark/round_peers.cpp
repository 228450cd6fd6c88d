#include "round_peers.h"

#include <vector>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/geometry/shapes/half_space.h"
#include "haptic_core/geometry/shapes/rod.h"

#ifdef HAPTIC_HAVE_ODE
#include <ode/ode.h>
#endif

namespace haptic::bench {

#ifdef HAPTIC_HAVE_ODE
struct OdePair::Data {
  std::vector<double> planes[2], points[2];
  std::vector<unsigned> polygons[2];
  dGeomID geom[2];

  dGeomID make(const ConvexShape& shape, int i) {
    const ConvexPolyhedron* hull = shape.polyhedron();
    if (const Rod* rod = shape.rod()) {
      const double length = 2 * rod->halfLength();
      return rod->isCapsule() ? dCreateCapsule(nullptr, rod->radius(), length) : dCreateCylinder(nullptr, rod->radius(), length);
    }
    if (shape.halfSpace()) return dCreatePlane(nullptr, 0, 0, 1, 0);
    if (!hull) return dCreateSphere(nullptr, shape.boundingRadius());
    if (hull->isBox())
      return dCreateBox(nullptr, 2 * hull->halfSize().x(), 2 * hull->halfSize().y(),
                        2 * hull->halfSize().z());
    for (const Vector3& v : hull->vertices()) points[i].insert(points[i].end(), {v.x(), v.y(), v.z()});
    for (const auto& face : hull->faces()) {
      planes[i].insert(planes[i].end(), {face.normal.x(), face.normal.y(), face.normal.z(), face.offset});
      polygons[i].push_back(static_cast<unsigned>(face.count));
      for (int k = 0; k < face.count; ++k)
        polygons[i].push_back(static_cast<unsigned>(hull->loopVertex(face.first + k)));
    }
    return dCreateConvex(nullptr, planes[i].data(), static_cast<unsigned>(hull->faceCount()),
                         points[i].data(), static_cast<unsigned>(hull->vertexCount()), polygons[i].data());
  }
};

OdePair::OdePair(const ConvexShape& A, const ConvexShape& B) : data_(new Data) {
  dInitODE2(0);
  data_->geom[0] = data_->make(A, 0);
  data_->geom[1] = data_->make(B, 1);
}

OdePair::~OdePair() {
  for (dGeomID geom : data_->geom) dGeomDestroy(geom);
  delete data_;
}

int OdePair::points(const Pose& X_AB) {
  const Matrix3& R = X_AB.R;
  const dMatrix3 rotation = {R(0, 0), R(0, 1), R(0, 2), 0,       R(1, 0), R(1, 1),
                             R(1, 2), 0,       R(2, 0), R(2, 1), R(2, 2), 0};
  dGeomSetPosition(data_->geom[1], X_AB.p.x(), X_AB.p.y(), X_AB.p.z());
  dGeomSetRotation(data_->geom[1], rotation);
  dContactGeom contacts[8];
  return dCollide(data_->geom[0], data_->geom[1], 8, contacts, sizeof(dContactGeom));
}
#else
struct OdePair::Data {};
OdePair::OdePair(const ConvexShape&, const ConvexShape&) : data_(nullptr) {}
OdePair::~OdePair() = default;
int OdePair::points(const Pose&) {
  return -1;
}
#endif

}  // namespace haptic::bench
