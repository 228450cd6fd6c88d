/// libccd's GJK as an oracle and a peer: do two bodies intersect?
#pragma once
#include <ccd/ccd.h>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic::oracle {

struct CcdBody {
  const ConvexPolyhedron* shape;
  Pose X;
};

inline void ccdSupport(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* result) {
  const CcdBody& body = *static_cast<const CcdBody*>(object);
  const Vector3 d = body.X.R.transpose() * Vector3(direction->v[0], direction->v[1], direction->v[2]);
  const Vector3 x = body.X * body.shape->vertices()[body.shape->support(d)];
  ccdVec3Set(result, x.x(), x.y(), x.z());
}

inline bool ccdIntersects(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB) {
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = ccd.support2 = ccdSupport;
  ccd.max_iterations = 100;
  const CcdBody a{&A, Pose()}, b{&B, X_AB};
  return ccdGJKIntersect(&a, &b, &ccd) != 0;
}

}  // namespace haptic::oracle
