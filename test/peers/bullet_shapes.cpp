#include "bullet_shapes.h"

#include <Eigen/Eigenvalues>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic::peers {
namespace {

/// A cone of ours stands on its tip, with its centre of mass at the origin; Bullet's has its tip up and its middle there.
Pose turned(const PeerBody& b, const CollisionDef& c) {
  if (!b.round || b.round->kind != PeerShape::Kind::kCone) return c.X_LS;
  Matrix3 R = Matrix3::Identity();
  R(1, 1) = R(2, 2) = -1;
  return c.X_LS * Pose(R, Vector3(0, 0, -0.25 * b.round->length));
}

std::unique_ptr<btCollisionShape> makeRound(const PeerShape& s, double margin) {
  std::unique_ptr<btCollisionShape> shape;
  switch (s.kind) {
    case PeerShape::Kind::kSphere:
      return std::make_unique<btSphereShape>(s.radius);
    case PeerShape::Kind::kCapsule:
      return std::make_unique<btCapsuleShapeZ>(s.radius, s.length);
    case PeerShape::Kind::kCone:
      shape = std::make_unique<btConeShapeZ>(s.radius, s.length);
      break;
    default:
      shape = std::make_unique<btCylinderShapeZ>(btVector3(s.radius, s.radius, 0.5 * s.length));
  }
  shape->setMargin(margin);
  return shape;
}

std::unique_ptr<btCollisionShape> makeShape(const PeerBody& b, const ConvexShape& any) {
  constexpr double kMargin = 1e-3;  // [m], of 40 by default: deeper contacts go the slow way, through GJK and EPA
  if (const auto round = roundShape(b, any)) return makeRound(*round, kMargin);
  const ConvexPolyhedron& shape = *any.polyhedron();
  if (shape.isBox()) {
    auto box = std::make_unique<btBoxShape>(toBullet(shape.halfSize()));
    box->setMargin(kMargin);
    return box;
  }
  auto hull = std::make_unique<btConvexHullShape>();
  for (const Vector3& v : shape.vertices()) hull->addPoint(toBullet(v), false);
  hull->setMargin(kMargin);
  hull->recalcLocalAabb();
  return hull;
}

}  // namespace

Pose principalAxes(const LinkInertia& inertia) {
  if (inertia.I_C.isDiagonal(1e-12)) return {Matrix3::Identity(), inertia.p_LC};
  Matrix3 R_LC = Eigen::SelfAdjointEigenSolver<Matrix3>(inertia.I_C).eigenvectors();
  if (R_LC.determinant() < 0) R_LC.col(2) = -R_LC.col(2);
  return {R_LC, inertia.p_LC};
}

void tune(btContactSolverInfo& info, const PeerSettings& settings) {
  info.m_numIterations = settings.iterations;
  if (settings.tuning == Tuning::kDantzig) info.m_minimumSolverBatchSize = 1;  // an island a problem, as its examples say
  if (settings.tuning == Tuning::kAccurate) {
    info.m_erp2 = 0.8;
    info.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
    info.m_restitutionVelocityThreshold = 0;
  }
}

btCollisionShape* BulletShapes::add(const PeerBody& b, const Pose& X_CL) {
  const auto& collisions = b.link->collisions;
  const auto place = [&](const CollisionDef& c) { return X_CL * turned(b, c); };
  if (isPlane(b)) {
    const UpperFace face = upperFace(collisions.at(0));
    shapes_.push_back(std::make_unique<btStaticPlaneShape>(toBullet(face.n_L), face.n_L.dot(face.p_L)));
    return shapes_.back().get();
  }
  if (collisions.size() == 1 && place(collisions[0]).R.isIdentity(0) && place(collisions[0]).p.isZero(0)) {
    shapes_.push_back(makeShape(b, *collisions[0].shape));
    return shapes_.back().get();
  }
  auto compound = std::make_unique<btCompoundShape>();
  for (const CollisionDef& collision : collisions) {
    shapes_.push_back(makeShape(b, *collision.shape));
    compound->addChildShape(toBullet(place(collision)), shapes_.back().get());
  }
  shapes_.push_back(std::move(compound));
  return shapes_.back().get();
}

}  // namespace haptic::peers
