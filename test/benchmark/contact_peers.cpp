#include "contact_peers.h"

#ifdef HAPTIC_HAVE_BULLET
#include <BulletCollision/CollisionDispatch/btBoxBoxDetector.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#endif
#ifdef HAPTIC_HAVE_ODE
#include <ode/ode.h>
#endif

namespace haptic::bench {

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

struct BulletBoxes::Shapes {
  btBoxShape a, b;
  btBoxBoxDetector detector{&a, &b};
};

BulletBoxes::BulletBoxes(const Vector3& a, const Vector3& b)
    : shapes_(new Shapes{btBoxShape(btVector3(a.x(), a.y(), a.z())), btBoxShape(btVector3(b.x(), b.y(), b.z()))}) {}

int BulletBoxes::points(const Pose& X_AB) const {
  btDiscreteCollisionDetectorInterface::ClosestPointInput input;
  input.m_transformA = btTransform::getIdentity();
  input.m_transformB = bulletTransform(X_AB);
  CountPoints points;
  shapes_->detector.getClosestPoints(input, points, nullptr);
  return points.count;
}
#else
struct BulletBoxes::Shapes {};
BulletBoxes::BulletBoxes(const Vector3&, const Vector3&) {}
int BulletBoxes::points(const Pose&) const {
  return -1;
}
#endif
BulletBoxes::~BulletBoxes() = default;

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
