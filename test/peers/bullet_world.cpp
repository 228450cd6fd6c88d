// Bullet 3.24, double precision: btDiscreteDynamicsWorld with sequential impulses or Dantzig's solver; shapes with margins
// of 1 mm, in a compound only where a body needs one.
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <btBulletDynamicsCommon.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "peer_world.h"

namespace haptic::peers {
namespace {

btVector3 toBullet(const Vector3& v) {
  return {v.x(), v.y(), v.z()};
}
Vector3 fromBullet(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}
btTransform toBullet(const Pose& X) {
  btMatrix3x3 R;
  for (int i = 0; i < 3; ++i) R[i].setValue(X.R(i, 0), X.R(i, 1), X.R(i, 2));
  return btTransform(R, toBullet(X.p));
}
Pose fromBullet(const btTransform& X) {
  Matrix3 R;
  for (int i = 0; i < 3; ++i) R.row(i) = fromBullet(X.getBasis()[i]);
  return {R, fromBullet(X.getOrigin())};
}

class BulletWorld : public PeerWorld {
 public:
  BulletWorld(const WorldDef& def, const PeerSettings& settings)
      : settings_(settings),
        dispatcher_(&configuration_),
        solver_(settings.tuning == Tuning::kDantzig ? std::make_unique<btMLCPSolver>(&dantzig_)
                                                    : std::make_unique<btSequentialImpulseConstraintSolver>()),
        world_(&dispatcher_, &broadphase_, solver_.get(), &configuration_) {
    world_.setGravity(toBullet(def.settings.gravity));
    btContactSolverInfo& info = world_.getSolverInfo();
    info.m_numIterations = settings.iterations;
    if (settings.tuning == Tuning::kDantzig) info.m_minimumSolverBatchSize = 1;  // an island a problem, as its examples say
    if (settings.tuning == Tuning::kAccurate) {
      info.m_erp2 = 0.8;
      info.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
      info.m_restitutionVelocityThreshold = 0;
    }
    for (const PeerBody& body : peerBodies(def, settings_)) add(body);
  }
  ~BulletWorld() override {
    for (auto& body : bodies_) world_.removeRigidBody(body.get());
  }

  void step() override {
    world_.stepSimulation(settings_.step, 0);
    world_.clearForces();
  }
  Pose linkPose(int i) const override { return fromBullet(bodies_[i]->getWorldTransform()) * X_CL_[i]; }
  Twist linkTwist(int i) const override {
    const Twist at_com{fromBullet(bodies_[i]->getAngularVelocity()), fromBullet(bodies_[i]->getLinearVelocity())};
    return at_com.shifted(linkPose(i).p - fromBullet(bodies_[i]->getWorldTransform().getOrigin()));
  }
  void applyForce(int i, const Vector3& f, const Vector3& p) override {
    bodies_[i]->applyForce(toBullet(f), toBullet(p) - bodies_[i]->getWorldTransform().getOrigin());
  }

  void scaleFriction(double factor) override {
    if (factor == friction_scale_) return;
    for (auto& body : bodies_) body->setFriction(body->getFriction() * std::sqrt(factor / friction_scale_));
    friction_scale_ = factor;
  }

 private:
  void add(const PeerBody& b) {
    // Bullet wants the principal axes: the body frame C lies at the centre of mass, along them.
    Eigen::SelfAdjointEigenSolver<Matrix3> axes(b.link->inertia.I_C);
    Matrix3 R_LC = b.fixed ? Matrix3::Identity() : Matrix3(axes.eigenvectors());
    if (R_LC.determinant() < 0) R_LC.col(2) = -R_LC.col(2);
    if (!b.fixed && b.link->inertia.I_C.isDiagonal(1e-12)) R_LC.setIdentity();
    const Matrix3 I = R_LC.transpose() * b.link->inertia.I_C * R_LC;
    const Pose X_LC(R_LC, b.fixed ? Vector3(Vector3::Zero()) : b.link->inertia.p_LC);
    btCollisionShape* shape = addShape(b, X_LC.inverse());
    const double mass = b.fixed ? 0 : b.link->inertia.mass;
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape,
                                                  b.fixed ? btVector3(0, 0, 0) : toBullet(Vector3(I.diagonal())));
    info.m_startWorldTransform = toBullet(b.X_WL * X_LC);
    info.m_friction = std::sqrt(b.mu);  // a pair's friction is the product
    info.m_restitution = std::sqrt(settings_.restitution);  // likewise
    auto body = std::make_unique<btRigidBody>(info);
    if (settings_.tuning != Tuning::kSleeps) body->setActivationState(DISABLE_DEACTIVATION);
    const Twist V = b.V_WL.shifted(b.X_WL.R * X_LC.p);
    body->setLinearVelocity(toBullet(V.linear));
    body->setAngularVelocity(toBullet(V.angular));
    world_.addRigidBody(body.get());
    X_CL_.push_back(X_LC.inverse());
    bodies_.push_back(std::move(body));
  }

  btCollisionShape* addShape(const PeerBody& b, const Pose& X_CL) {
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

  /// A cone of ours stands on its tip, with its centre of mass at the origin; Bullet's has its tip up and its middle there.
  static Pose turned(const PeerBody& b, const CollisionDef& c) {
    if (!b.round || b.round->kind != PeerShape::Kind::kCone) return c.X_LS;
    Matrix3 R = Matrix3::Identity();
    R(1, 1) = R(2, 2) = -1;
    return c.X_LS * Pose(R, Vector3(0, 0, -0.25 * b.round->length));
  }

  static std::unique_ptr<btCollisionShape> makeShape(const PeerBody& b, const ConvexShape& any) {
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

  static std::unique_ptr<btCollisionShape> makeRound(const PeerShape& s, double margin) {
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

  PeerSettings settings_;
  double friction_scale_ = 1;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btDantzigSolver dantzig_;
  std::unique_ptr<btConstraintSolver> solver_;
  btDiscreteDynamicsWorld world_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<Pose> X_CL_;
};

}  // namespace

std::unique_ptr<PeerWorld> makeBullet(const WorldDef& def, const PeerSettings& settings) {
  return std::make_unique<BulletWorld>(def, settings);
}

}  // namespace haptic::peers
