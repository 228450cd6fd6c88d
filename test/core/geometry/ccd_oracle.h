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

/// Any convex shape, by its support function alone.
struct CcdShape {
  const ConvexShape* shape;
  Pose X;
};

inline void ccdShapeSupport(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* result) {
  const CcdShape& body = *static_cast<const CcdShape*>(object);
  const Vector3 d = Vector3(direction->v[0], direction->v[1], direction->v[2]).normalized();
  const Vector3 x = body.X * body.shape->core(body.X.R.transpose() * d) + body.shape->rounding() * d;
  ccdVec3Set(result, x.x(), x.y(), x.z());
}

inline void ccdShapeCentre(const void* object, ccd_vec3_t* result) {
  const CcdShape& body = *static_cast<const CcdShape*>(object);
  const Vector3 x = body.X * body.shape->centre();
  ccdVec3Set(result, x.x(), x.y(), x.z());
}

/// By libccd's MPR: do they intersect, and then along which unit direction from A to B, and how deep?
inline bool ccdPenetration(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, Vector3& direction, double& depth) {
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = ccd.support2 = ccdShapeSupport;
  ccd.center1 = ccd.center2 = ccdShapeCentre;
  ccd.max_iterations = 200;
  ccd.mpr_tolerance = 1e-9;
  const CcdShape a{&A, Pose()}, b{&B, X_AB};
  ccd_vec3_t way, point;
  if (ccdMPRPenetration(&a, &b, &ccd, &depth, &way, &point) != 0) return false;
  direction = Vector3(way.v[0], way.v[1], way.v[2]);
  return true;
}

}  // namespace haptic::oracle
