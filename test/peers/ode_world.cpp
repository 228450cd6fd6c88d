// ODE 0.16: dWorldStep (exact LCP) or dWorldQuickStep, contacts from dCollide.
#include <ode/ode.h>

#include <cmath>
#include <stdexcept>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "peer_world.h"

namespace haptic::peers {
namespace {

struct ConvexData {  // ODE keeps pointers to these
  std::vector<dReal> planes, points;
  std::vector<unsigned> polygons;
};

void setPose(dGeomID geom, const Pose& X) {
  const Matrix3& R = X.R;
  const dMatrix3 rotation = {R(0, 0), R(0, 1), R(0, 2), 0,       R(1, 0), R(1, 1),
                             R(1, 2), 0,       R(2, 0), R(2, 1), R(2, 2), 0};
  dGeomSetPosition(geom, X.p.x(), X.p.y(), X.p.z());
  dGeomSetRotation(geom, rotation);
}

class OdeWorld : public PeerWorld {
 public:
  OdeWorld(const WorldDef& def, const PeerSettings& settings) : settings_(settings), bodies_(peerBodies(def, settings_)) {
    dInitODE();
    dRandSetSeed(0);  // ODE shuffles its rows: worlds of one process do so alike
    if (!dCheckConfiguration("ODE_double_precision")) {
      throw SetupError("ODE", "is built in single precision", "install Debian's libode-dev");
    }
    world_ = dWorldCreate();
    space_ = dHashSpaceCreate(nullptr);
    contacts_ = dJointGroupCreate(0);
    const Vector3& g = def.settings.gravity;
    dWorldSetGravity(world_, g.x(), g.y(), g.z());
    dWorldSetQuickStepNumIterations(world_, settings.iterations);
    if (settings.tuning == Tuning::kAccurate) {
      dWorldSetERP(world_, 0.8);
      dWorldSetCFM(world_, 1e-12);
    }
    if (settings.tuning == Tuning::kSleeps) dWorldSetAutoDisableFlag(world_, 1);  // before the bodies, which take it over
    for (int i = 0; i < static_cast<int>(bodies_.size()); ++i) add(i);
  }
  ~OdeWorld() override {
    dJointGroupDestroy(contacts_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
    dCloseODE();
  }
  OdeWorld(const OdeWorld&) = delete;
  OdeWorld& operator=(const OdeWorld&) = delete;

  void step() override {
    dSpaceCollide(space_, this, &OdeWorld::collide);
    settings_.peer == Peer::kOdeExact ? dWorldStep(world_, settings_.step) : dWorldQuickStep(world_, settings_.step);
    dJointGroupEmpty(contacts_);
  }
  Pose linkPose(int i) const override {
    if (!body_[i]) return bodies_[i].X_WL;
    const dReal* p = dBodyGetPosition(body_[i]);
    const dReal* q = dBodyGetQuaternion(body_[i]);
    const Pose X_WC(Quaternion(q[0], q[1], q[2], q[3]), Vector3(p[0], p[1], p[2]));
    return {X_WC.R, X_WC * Vector3(-bodies_[i].link->inertia.p_LC)};
  }
  Twist linkTwist(int i) const override {
    if (!body_[i]) return {};
    const dReal* v = dBodyGetLinearVel(body_[i]);
    const dReal* w = dBodyGetAngularVel(body_[i]);
    const Twist at_com{Vector3(w[0], w[1], w[2]), Vector3(v[0], v[1], v[2])};
    return at_com.shifted(-(linkPose(i).R * bodies_[i].link->inertia.p_LC));
  }
  void applyForce(int i, const Vector3& f, const Vector3& p) override {
    if (body_[i]) dBodyAddForceAtPos(body_[i], f.x(), f.y(), f.z(), p.x(), p.y(), p.z());
  }
  void scaleFriction(double factor) override { friction_scale_ = factor; }

 private:
  void add(int i) {
    const PeerBody& b = bodies_[i];
    dBodyID body = nullptr;
    if (!b.fixed) {
      body = dBodyCreate(world_);
      dMass mass;
      const Matrix3& I = b.link->inertia.I_C;
      dMassSetParameters(&mass, b.link->inertia.mass, 0, 0, 0, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
      dBodySetMass(body, &mass);
      const Vector3 com = b.X_WL * b.link->inertia.p_LC;
      const Quaternion q(b.X_WL.R);
      const dQuaternion rotation = {q.w(), q.x(), q.y(), q.z()};
      dBodySetPosition(body, com.x(), com.y(), com.z());
      dBodySetQuaternion(body, rotation);
      const Twist V = b.V_WL.shifted(com - b.X_WL.p);
      dBodySetLinearVel(body, V.linear.x(), V.linear.y(), V.linear.z());
      dBodySetAngularVel(body, V.angular.x(), V.angular.y(), V.angular.z());
      if (settings_.tuning == Tuning::kAccurate) dBodySetFiniteRotationMode(body, 1);
    }
    body_.push_back(body);
    if (isPlane(b)) {
      const UpperFace face = upperFace(b.link->collisions.at(0));
      const Vector3 n = b.X_WL.R * face.n_L;
      dGeomSetData(dCreatePlane(space_, n.x(), n.y(), n.z(), n.dot(b.X_WL * face.p_L)),
                   reinterpret_cast<void*>(static_cast<std::intptr_t>(i)));
      return;
    }
    for (const CollisionDef& collision : b.link->collisions) {
      dGeomID geom = makeGeom(b, *collision.shape);
      dGeomSetData(geom, reinterpret_cast<void*>(static_cast<std::intptr_t>(i)));
      if (body) {
        dGeomSetBody(geom, body);
        const Matrix3& R = collision.X_LS.R;
        const Vector3 offset = collision.X_LS.p - b.link->inertia.p_LC;
        const dMatrix3 rotation = {R(0, 0), R(0, 1), R(0, 2), 0,       R(1, 0), R(1, 1),
                                   R(1, 2), 0,       R(2, 0), R(2, 1), R(2, 2), 0};
        dGeomSetOffsetPosition(geom, offset.x(), offset.y(), offset.z());
        dGeomSetOffsetRotation(geom, rotation);
      } else {
        setPose(geom, b.X_WL * collision.X_LS);
      }
    }
  }

  dGeomID makeGeom(const PeerBody& b, const ConvexShape& any) {
    if (const auto round = roundShape(b, any)) {
      if (round->kind == PeerShape::Kind::kSphere) return dCreateSphere(space_, round->radius);
      if (round->kind == PeerShape::Kind::kCapsule) return dCreateCapsule(space_, round->radius, round->length);
      if (round->kind == PeerShape::Kind::kCylinder) return dCreateCylinder(space_, round->radius, round->length);
    }
    const ConvexPolyhedron& shape = *any.polyhedron();
    if (shape.isBox()) {
      const Vector3 size = 2 * shape.halfSize();
      return dCreateBox(space_, size.x(), size.y(), size.z());
    }
    convex_.push_back(std::make_unique<ConvexData>());
    ConvexData& data = *convex_.back();
    for (const Vector3& v : shape.vertices()) data.points.insert(data.points.end(), {v.x(), v.y(), v.z()});
    for (const auto& face : shape.faces()) {
      data.planes.insert(data.planes.end(), {face.normal.x(), face.normal.y(), face.normal.z(), face.offset});
      data.polygons.push_back(face.count);
      for (int k = 0; k < face.count; ++k) data.polygons.push_back(shape.loopVertex(face.first + k));
    }
    return dCreateConvex(space_, data.planes.data(), shape.faceCount(), data.points.data(), shape.vertexCount(),
                         data.polygons.data());
  }

  static void collide(void* self, dGeomID a, dGeomID b) {
    auto& world = *static_cast<OdeWorld*>(self);
    const int i = static_cast<int>(reinterpret_cast<std::intptr_t>(dGeomGetData(a)));
    const int j = static_cast<int>(reinterpret_cast<std::intptr_t>(dGeomGetData(b)));
    const auto moves = [&world](int k) { return world.body_[k] && dBodyIsEnabled(world.body_[k]); };
    if (i == j || (!moves(i) && !moves(j))) return;
    constexpr int kMaxContacts = 16;  // a face contact of two boxes has 8
    dContact contact[kMaxContacts] = {};
    const int n = dCollide(a, b, kMaxContacts, &contact[0].geom, sizeof(dContact));
    for (int c = 0; c < n; ++c) {
      contact[c].surface.mode = dContactApprox1 | (world.settings_.restitution > 0 ? dContactBounce : 0);
      contact[c].surface.bounce = world.settings_.restitution;
      contact[c].surface.mu = world.friction_scale_ * std::sqrt(world.bodies_[i].mu * world.bodies_[j].mu);
      if (world.settings_.tuning == Tuning::kAccurate) world.alongSlip(world.body_[i], world.body_[j], contact[c]);
      dJointAttach(dJointCreateContact(world.world_, world.contacts_, &contact[c]), world.body_[i], world.body_[j]);
    }
  }

  /// First friction axis along the slip, as ODE's manual advises where a pyramid is not good enough.
  static void alongSlip(dBodyID a, dBodyID b, dContact& contact) {
    constexpr double kStill = 1e-9;  // [m/s]: no direction to speak of
    const dReal* p = contact.geom.pos;
    const auto at = [p](dBodyID body) {
      dVector3 v = {};
      if (body) dBodyGetPointVel(body, p[0], p[1], p[2], v);
      return Vector3(v[0], v[1], v[2]);
    };
    const Vector3 n(contact.geom.normal[0], contact.geom.normal[1], contact.geom.normal[2]), v = at(a) - at(b);
    const Vector3 slip = v - v.dot(n) * n;
    if (slip.norm() < kStill) return;
    const Vector3 axis = slip.normalized();
    for (int k = 0; k < 3; ++k) contact.fdir1[k] = axis[k];
    contact.surface.mode |= dContactFDir1;
  }

  PeerSettings settings_;
  std::vector<PeerBody> bodies_;
  double friction_scale_ = 1;
  dWorldID world_;
  dSpaceID space_;
  dJointGroupID contacts_;
  std::vector<dBodyID> body_;
  std::vector<std::unique_ptr<ConvexData>> convex_;
};

}  // namespace

std::unique_ptr<PeerWorld> makeOde(const WorldDef& def, const PeerSettings& settings) {
  return std::make_unique<OdeWorld>(def, settings);
}

}  // namespace haptic::peers
