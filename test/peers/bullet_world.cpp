// Bullet 3.24, double precision: btDiscreteDynamicsWorld with sequential impulses or Dantzig's solver; shapes with margins
// of 1 mm, in a compound only where a body needs one.
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>

#include "bullet_shapes.h"

namespace haptic::peers {
namespace {

class BulletWorld : public PeerWorld {
 public:
  BulletWorld(const WorldDef& def, const PeerSettings& settings)
      : settings_(settings),
        dispatcher_(&configuration_),
        solver_(settings.tuning == Tuning::kDantzig ? std::make_unique<btMLCPSolver>(&dantzig_)
                                                    : std::make_unique<btSequentialImpulseConstraintSolver>()),
        world_(&dispatcher_, &broadphase_, solver_.get(), &configuration_) {
    world_.setGravity(toBullet(def.settings.gravity));
    tune(world_.getSolverInfo(), settings);
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
    const Pose X_LC = b.fixed ? Pose() : principalAxes(b.link->inertia);
    const Matrix3 I = X_LC.R.transpose() * b.link->inertia.I_C * X_LC.R;
    btCollisionShape* shape = shapes_.add(b, X_LC.inverse());
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

  PeerSettings settings_;
  double friction_scale_ = 1;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btDantzigSolver dantzig_;
  std::unique_ptr<btConstraintSolver> solver_;
  btDiscreteDynamicsWorld world_;
  BulletShapes shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<Pose> X_CL_;
};

}  // namespace

std::unique_ptr<PeerWorld> makeBullet(const WorldDef& def, const PeerSettings& settings) {
  if (hasTrees(def)) return makeBulletTrees(def, settings);
  return std::make_unique<BulletWorld>(def, settings);
}

}  // namespace haptic::peers
