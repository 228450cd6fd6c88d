#include "contact_peers.h"

#include <ccd/ccd.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#ifdef HAPTIC_HAVE_BULLET
#include <BulletCollision/CollisionDispatch/btBoxBoxDetector.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#endif
#ifdef HAPTIC_HAVE_ODE
#include <ode/ode.h>
#endif

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace haptic::bench {

double qhullDualVolume(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB,
                       const Vector3& interior) {
  std::vector<double> dual;
  std::vector<Vector3> normals;
  const auto add = [&](const Vector3& n, double offset) {
    const double distance = offset - n.dot(interior);
    normals.push_back(n);
    for (int i = 0; i < 3; ++i) dual.push_back(n[i] / distance);
  };
  for (const auto& f : A.faces()) add(f.normal, f.offset);
  for (const auto& f : B.faces()) {
    const Vector3 n = X_AB.R * f.normal;
    add(n, f.offset + n.dot(X_AB.p));
  }
  qhT context;
  qhT* qh = &context;
  qh_zero(qh, nullptr);
  char options[] = "qhull Qt";
  double volume = 0;
  if (qh_new_qhull(qh, 3, static_cast<int>(normals.size()), dual.data(), 0, options, nullptr, nullptr) == 0) {
    // A dual facet is a vertex of V, a dual vertex a face: sum the faces as fans over their neighbouring
    // facets.
    qh_vertexneighbors(qh);
    vertexT* vertex;
    FORALLvertices {
      std::vector<Vector3> corners;
      facetT *neighbor, **neighborp;
      FOREACHneighbor_(vertex) {
        if (neighbor->offset < 0)
          corners.push_back(Vector3(neighbor->normal[0], neighbor->normal[1], neighbor->normal[2]) /
                            -neighbor->offset);
      }
      const Vector3& n = normals[qh_pointid(qh, vertex->point)];
      if (corners.size() < 3) continue;
      Vector3 middle = Vector3::Zero();
      for (const Vector3& c : corners) middle += c / static_cast<double>(corners.size());
      const Vector3 x = (corners[0] - middle).normalized(), y = n.cross(x);
      std::vector<std::pair<double, int>> order;
      for (std::size_t i = 0; i < corners.size(); ++i)
        order.push_back(
            {std::atan2(y.dot(corners[i] - middle), x.dot(corners[i] - middle)), static_cast<int>(i)});
      std::sort(order.begin(), order.end());
      for (std::size_t i = 0; i < order.size(); ++i)
        volume +=
            middle.dot(corners[order[i].second].cross(corners[order[(i + 1) % order.size()].second])) / 6;
    }
  }
  qh->NOerrexit = True;
  qh_freeqhull(qh, !qh_ALL);
  int remaining = 0, blocks = 0;
  qh_memfreeshort(qh, &remaining, &blocks);
  return volume;
}

namespace {

struct CcdBody {
  const ConvexPolyhedron* shape;
  Pose X;
};

void ccdSupport(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* result) {
  const CcdBody& body = *static_cast<const CcdBody*>(object);
  const Vector3 d = body.X.R.transpose() * Vector3(direction->v[0], direction->v[1], direction->v[2]);
  const Vector3 x = body.X * body.shape->vertices()[body.shape->support(d)];
  ccdVec3Set(result, x.x(), x.y(), x.z());
}

}  // namespace

bool ccdIntersects(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB) {
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = ccd.support2 = ccdSupport;
  ccd.max_iterations = 100;
  const CcdBody a{&A, Pose()}, b{&B, X_AB};
  return ccdGJKIntersect(&a, &b, &ccd) != 0;
}

#ifdef HAPTIC_HAVE_BULLET
namespace {

struct CountPoints : btDiscreteCollisionDetectorInterface::Result {
  int count = 0;
  void setShapeIdentifiersA(int, int) override {}
  void setShapeIdentifiersB(int, int) override {}
  void addContactPoint(const btVector3&, const btVector3&, btScalar) override { ++count; }
};

btTransform bulletTransform(const Pose& X) {
  return btTransform(btMatrix3x3(X.R(0, 0), X.R(0, 1), X.R(0, 2), X.R(1, 0), X.R(1, 1), X.R(1, 2), X.R(2, 0),
                                 X.R(2, 1), X.R(2, 2)),
                     btVector3(X.p.x(), X.p.y(), X.p.z()));
}

}  // namespace

int bulletBoxPoints(const Vector3& half_a, const Vector3& half_b, const Pose& X_AB) {
  const btBoxShape a(btVector3(half_a.x(), half_a.y(), half_a.z())),
      b(btVector3(half_b.x(), half_b.y(), half_b.z()));
  btBoxBoxDetector detector(&a, &b);
  btDiscreteCollisionDetectorInterface::ClosestPointInput input;
  input.m_transformA = btTransform::getIdentity();
  input.m_transformB = bulletTransform(X_AB);
  CountPoints points;
  detector.getClosestPoints(input, points, nullptr);
  return points.count;
}
#else
int bulletBoxPoints(const Vector3&, const Vector3&, const Pose&) {
  return -1;
}
#endif

#ifdef HAPTIC_HAVE_ODE
int odeBoxPoints(const Vector3& half_a, const Vector3& half_b, const Pose& X_AB) {
  dVector3 pa = {0, 0, 0, 0}, pb = {X_AB.p.x(), X_AB.p.y(), X_AB.p.z(), 0}, normal;
  const dVector3 la = {2 * half_a.x(), 2 * half_a.y(), 2 * half_a.z(), 0};
  const dVector3 lb = {2 * half_b.x(), 2 * half_b.y(), 2 * half_b.z(), 0};
  dMatrix3 Ra = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, Rb;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 4; ++j) Rb[4 * i + j] = j < 3 ? X_AB.R(i, j) : 0;
  dReal depth;
  int code;
  dContactGeom contacts[8];
  return dBoxBox(pa, Ra, la, pb, Rb, lb, normal, &depth, &code, 8, contacts, sizeof(dContactGeom));
}
#else
int odeBoxPoints(const Vector3&, const Vector3&, const Pose&) {
  return -1;
}
#endif

}  // namespace haptic::bench
