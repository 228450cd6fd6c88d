// Bullet 3.24, double precision, for scenes with joints: btMultiBodyDynamicsWorld; every tree and free body a btMultiBody.
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletDynamics/Featherstone/btMultiBodyMLCPConstraintSolver.h>
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>

#include <cmath>

#include "bullet_shapes.h"
#include "peer_trees.h"

namespace haptic::peers {
namespace {

/// Drives are forces of the joints, taken once a step at its start: Bullet's motors are constraints with gains of another meaning.
class BulletTreeWorld : public PeerTreeWorld {
 public:
  BulletTreeWorld(const WorldDef& def, const PeerSettings& settings)
      : PeerTreeWorld(peerBodies(def, settings, true)),
        settings_(settings),
        drives_(def, bodies()),
        dispatcher_(&configuration_),
        solver_(settings.tuning == Tuning::kDantzig ? std::make_unique<btMultiBodyMLCPConstraintSolver>(&dantzig_)
                                                    : std::make_unique<btMultiBodyConstraintSolver>()),
        world_(&dispatcher_, &broadphase_, solver_.get(), &configuration_),
        place_(bodies().size()) {
    world_.setGravity(toBullet(def.settings.gravity));
    tune(world_.getSolverInfo(), settings);
    for (int i = 0; i < static_cast<int>(bodies().size()); ++i) {
      if (bodies()[i].parent >= 0) continue;
      bodies()[i].fixed && !hasChild(i) ? addStatic(i) : addTree(i);
    }
  }
  ~BulletTreeWorld() override {
    for (auto& body : statics_) world_.removeRigidBody(body.get());
    for (auto& tree : trees_) world_.removeMultiBody(tree.get());
    for (auto& collider : colliders_) world_.removeCollisionObject(collider.get());
  }

  void step() override {
    const double time = settings_.step * static_cast<double>(++steps_);
    for (int i = 0; i < static_cast<int>(bodies().size()); ++i) {
      if (bodies()[i].jointed() && bodies()[i].link->joint.damping != 0) push(i, -bodies()[i].link->joint.damping * jointMotion(i).v);
    }
    for (std::size_t i = 0; i < drives_.all().size(); ++i) {
      const PeerDrives::Wanted wanted = drives_.at(i, time);
      const PeerDrives::Drive& drive = drives_.all()[i];
      const TreeMotion now = jointMotion(drive.link);
      push(drive.link, drive.joint->drive_stiffness * (wanted.motion.q - now.q) + drive.joint->drive_damping * (wanted.motion.v - now.v) +
                           wanted.effort);
    }
    world_.stepSimulation(settings_.step, 0);
    world_.clearForces();
  }
  void applyForce(int i, const Vector3& f, const Vector3& p) override {
    const Place& place = place_[i];
    if (!place.tree) return;
    const Vector3 torque = (p - linkPose(i) * bodies()[i].link->inertia.p_LC).cross(f);
    if (place.link < 0) {
      place.tree->addBaseForce(toBullet(f));
      place.tree->addBaseTorque(toBullet(torque));
    } else {
      place.tree->addLinkForce(place.link, toBullet(f));
      place.tree->addLinkTorque(place.link, toBullet(torque));
    }
  }
  void scaleFriction(double factor) override {
    if (factor == friction_scale_) return;
    for (auto& body : statics_) body->setFriction(body->getFriction() * std::sqrt(factor / friction_scale_));
    for (auto& collider : colliders_) collider->setFriction(collider->getFriction() * std::sqrt(factor / friction_scale_));
    friction_scale_ = factor;
  }

 protected:
  Pose rootPose(int i) const override { return fromBullet(place_[i].tree->getBaseWorldTransform()) * place_[i].X_LC.inverse(); }
  Twist rootTwist(int i) const override {
    const btMultiBody& tree = *place_[i].tree;
    const Twist at_com{fromBullet(tree.getBaseOmega()), fromBullet(tree.getBaseVel())};
    return at_com.shifted(rootPose(i).p - fromBullet(tree.getBaseWorldTransform().getOrigin()));
  }
  TreeMotion jointMotion(int i) const override {
    return {place_[i].tree->getJointPos(place_[i].link), place_[i].tree->getJointVel(place_[i].link)};
  }

 private:
  struct Place {
    btMultiBody* tree = nullptr;  ///< null: static
    int link = -1;                ///< of the tree; -1: its base
    Pose X_LC;                    ///< Bullet's frame of the link
  };

  bool hasChild(int i) const {
    for (const PeerBody& b : bodies()) {
      if (b.parent == i) return true;
    }
    return false;
  }
  void push(int i, double effort) { place_[i].tree->addJointTorque(place_[i].link, effort); }
  static btVector3 moments(const LinkInertia& inertia, const Matrix3& R_LC) {
    return toBullet(Vector3((R_LC.transpose() * inertia.I_C * R_LC).diagonal()));
  }
  void setSurface(btCollisionObject& object, const PeerBody& b) {
    object.setFriction(std::sqrt(b.mu));  // a pair's friction is the product
    object.setRestitution(std::sqrt(settings_.restitution));  // likewise
  }

  void addStatic(int i) {
    const PeerBody& b = bodies()[i];
    btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, shapes_.add(b, Pose()));
    info.m_startWorldTransform = toBullet(b.X_WL);
    statics_.push_back(std::make_unique<btRigidBody>(info));
    setSurface(*statics_.back(), b);
    world_.addRigidBody(statics_.back().get());
  }

  /// The links under root i. A root on a joint of the world hangs on a base without mass there.
  void addTree(int root) {
    const PeerBody& b = bodies()[root];
    std::vector<int> links;  // in the order of Bullet's, after the base
    for (int i = root; i < static_cast<int>(bodies().size()); ++i) {
      int top = i;
      while (bodies()[top].parent >= 0) top = bodies()[top].parent;
      if (top == root && (i != root || !b.floating())) links.push_back(i);
    }
    const Pose X_LC = b.floating() ? principalAxes(b.link->inertia) : Pose();
    trees_.push_back(std::make_unique<btMultiBody>(static_cast<int>(links.size()), b.floating() ? b.link->inertia.mass : 1,
                                                   b.floating() ? moments(b.link->inertia, X_LC.R) : btVector3(1, 1, 1), !b.floating(),
                                                   false));
    btMultiBody& tree = *trees_.back();
    if (b.floating()) place_[root] = {&tree, -1, X_LC};
    for (int n = 0; n < static_cast<int>(links.size()); ++n) addLink(tree, n, links[n]);
    tree.finalizeMultiDof();
    tree.setLinearDamping(0);
    tree.setAngularDamping(0);
    tree.setUseGyroTerm(true);
    tree.setMaxCoordinateVelocity(1e30);
    tree.setHasSelfCollision(false);
    tree.useRK4Integration(settings_.tuning == Tuning::kAccurate);
    if (b.floating()) {
      const Twist V = b.V_WL.shifted(b.X_WL.R * X_LC.p);
      tree.setBaseWorldTransform(toBullet(b.X_WL * X_LC));
      tree.setBaseVel(toBullet(V.linear));
      tree.setBaseOmega(toBullet(V.angular));
      addCollider(tree, -1, root);
    } else {
      tree.setBaseWorldTransform(btTransform::getIdentity());
    }
    for (int n = 0; n < static_cast<int>(links.size()); ++n) {
      const PeerBody& link = bodies()[links[n]];
      if (link.jointed()) {
        tree.setJointPos(n, link.link->joint.position);
        tree.setJointVel(n, link.link->joint.velocity);
      }
      addCollider(tree, n, links[n]);
    }
    btAlignedObjectArray<btQuaternion> turns;
    btAlignedObjectArray<btVector3> origins;
    tree.forwardKinematics(turns, origins);
    tree.updateCollisionObjectWorldTransforms(turns, origins);
    world_.addMultiBody(&tree);
  }

  void addLink(btMultiBody& tree, int n, int i) {
    const PeerBody& b = bodies()[i];
    const Pose X_LC = principalAxes(b.link->inertia);
    const Pose X_PC = b.parent < 0 ? Pose() : place_[b.parent].X_LC;
    const int parent = b.parent < 0 ? -1 : place_[b.parent].link;
    place_[i] = {&tree, n, X_LC};
    const Matrix3 turn = X_LC.R.transpose() * b.X_PJ.R.transpose() * X_PC.R;  // from the parent's axes to those of the link
    const btVector3 pivot = toBullet(X_PC.inverse() * b.X_PJ.p), centre = toBullet(Vector3(X_LC.R.transpose() * X_LC.p));
    const btVector3 axis = toBullet(Vector3(X_LC.R.transpose() * b.link->joint.axis)), inertia = moments(b.link->inertia, X_LC.R);
    const btQuaternion q = toBullet(Pose(turn, Vector3::Zero())).getRotation();
    const double mass = b.link->inertia.mass;
    if (b.link->joint.type == JointType::kRevolute) {
      tree.setupRevolute(n, mass, inertia, parent, q, axis, pivot, centre, true);
    } else if (b.link->joint.type == JointType::kPrismatic) {
      tree.setupPrismatic(n, mass, inertia, parent, q, axis, pivot, centre, true);
    } else {
      tree.setupFixed(n, mass, inertia, parent, q, pivot, centre);
    }
  }

  void addCollider(btMultiBody& tree, int n, int i) {
    if (bodies()[i].link->collisions.empty()) return;
    auto collider = std::make_unique<btMultiBodyLinkCollider>(&tree, n);
    collider->setCollisionShape(shapes_.add(bodies()[i], place_[i].X_LC.inverse()));
    setSurface(*collider, bodies()[i]);
    collider->setActivationState(DISABLE_DEACTIVATION);
    world_.addCollisionObject(collider.get(), btBroadphaseProxy::DefaultFilter, btBroadphaseProxy::AllFilter);
    n < 0 ? tree.setBaseCollider(collider.get()) : void(tree.getLink(n).m_collider = collider.get());
    colliders_.push_back(std::move(collider));
  }

  PeerSettings settings_;
  PeerDrives drives_;
  long steps_ = 0;
  double friction_scale_ = 1;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btDantzigSolver dantzig_;
  std::unique_ptr<btMultiBodyConstraintSolver> solver_;
  btMultiBodyDynamicsWorld world_;
  BulletShapes shapes_;
  std::vector<std::unique_ptr<btRigidBody>> statics_;
  std::vector<std::unique_ptr<btMultiBody>> trees_;
  std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders_;
  std::vector<Place> place_;
};

}  // namespace

std::unique_ptr<PeerWorld> makeBulletTrees(const WorldDef& def, const PeerSettings& settings) {
  return std::make_unique<BulletTreeWorld>(def, settings);
}

}  // namespace haptic::peers
