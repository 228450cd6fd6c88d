/// Both of Bullet's worlds: numbers, shapes with margins of 1 mm, in a compound only where a body needs one, and settings.
#pragma once
#include <btBulletDynamicsCommon.h>

#include <memory>
#include <vector>

#include "peer_world.h"

namespace haptic::peers {

inline btVector3 toBullet(const Vector3& v) {
  return {v.x(), v.y(), v.z()};
}
inline Vector3 fromBullet(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}
inline btTransform toBullet(const Pose& X) {
  btMatrix3x3 R;
  for (int i = 0; i < 3; ++i) R[i].setValue(X.R(i, 0), X.R(i, 1), X.R(i, 2));
  return btTransform(R, toBullet(X.p));
}
inline Pose fromBullet(const btTransform& X) {
  Matrix3 R;
  for (int i = 0; i < 3; ++i) R.row(i) = fromBullet(X.getBasis()[i]);
  return {R, fromBullet(X.getOrigin())};
}

/// X_LC of the frame at the centre of mass along the principal axes, which Bullet wants; the link's own axes where they are those.
Pose principalAxes(const LinkInertia& inertia);

void tune(btContactSolverInfo& info, const PeerSettings& settings);

/// The shapes of a world, kept while it lives.
class BulletShapes {
 public:
  btCollisionShape* add(const PeerBody& body, const Pose& X_CL);  ///< of all collisions of a link, in its frame C

 private:
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
};

/// A world of btMultiBody, for scenes with joints.
std::unique_ptr<PeerWorld> makeBulletTrees(const WorldDef& def, const PeerSettings& settings);

}  // namespace haptic::peers
