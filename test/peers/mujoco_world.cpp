// MuJoCo 2.2: the model is written as MJCF.
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "peer_world.h"

namespace haptic::peers {
namespace {

std::string text(const Vector3& v) {
  std::ostringstream s;
  s.precision(17);
  s << v.x() << ' ' << v.y() << ' ' << v.z();
  return s.str();
}
std::string text(const Matrix3& R) {
  const Quaternion q(R);
  std::ostringstream s;
  s.precision(17);
  s << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z();
  return s.str();
}

/// Contact of two geoms has the larger friction of both, or that of the higher priority: fixed bodies get the latter, with
/// the geometric mean that the other simulators take.
std::string frictionOf(const PeerBody& b, double mu_moving) {
  std::ostringstream s;
  s.precision(17);
  s << "' friction='" << (b.fixed ? std::sqrt(b.mu * mu_moving) : b.mu) << " 0.005 0.0001' priority='" << b.fixed << "'/>";
  return s.str();
}

/// Friction of the bodies that move; NaN when none does.
double movingFriction(const std::vector<PeerBody>& bodies) {
  double mu = std::nan("");
  for (const PeerBody& b : bodies) {
    if (b.fixed) continue;
    if (!std::isnan(mu) && mu != b.mu) {
      throw SetupError("MuJoCo", "takes the larger friction of two bodies", "give all moving bodies the same");
    }
    mu = b.mu;
  }
  return mu;
}

/// `type` and `size` of a geom, and where it lies.
std::string geomText(const PeerBody& b, const CollisionDef& collision, int& mesh, std::ostringstream& assets) {
  std::ostringstream s;
  s.precision(17);
  Vector3 p = collision.X_LS.p;
  const auto round = roundShape(b, *collision.shape);
  if (round && round->kind != PeerShape::Kind::kCone) {
    const PeerShape& r = *round;
    switch (r.kind) {
      case PeerShape::Kind::kSphere:
        s << "<geom type='sphere' size='" << r.radius;
        break;
      case PeerShape::Kind::kCapsule:
        s << "<geom type='capsule' size='" << r.radius << ' ' << 0.5 * r.length;
        break;
      case PeerShape::Kind::kPlane:
        s << "<geom type='plane' size='0 0 1";
        p = upperFace(collision).p_L;
        break;
      default:
        s << "<geom type='cylinder' size='" << r.radius << ' ' << 0.5 * r.length;
    }
  } else if (const ConvexPolyhedron* hull = collision.shape->polyhedron(); hull->isBox()) {
    s << "<geom type='box' size='" << text(hull->halfSize());
  } else {
    assets << "<mesh name='m" << mesh << "' vertex='";
    for (const Vector3& v : hull->vertices()) assets << text(v) << ' ';
    assets << "'/>";
    s << "<geom type='mesh' mesh='m" << mesh++;
  }
  s << "' pos='" << text(p) << "' quat='" << text(collision.X_LS.R);
  return s.str();
}

/// Solver, cone, softness. MuJoCo has no restitution: springs without damping, in the direct form of solref, give back
/// what they take; a period of 4π steps is as stiff as its Euler steps resolve.
std::string optionText(const PeerSettings& s) {
  std::ostringstream option;
  option.precision(17);
  const bool accurate = s.tuning == Tuning::kAccurate, fast = s.tuning == Tuning::kFast;
  if (accurate) {
    option << "integrator='implicit' cone='elliptic' impratio='10' noslip_iterations='10'";
  } else {
    option << "integrator='" << (s.peer == Peer::kMujocoRk4 ? "RK4" : "Euler") << "'";
    if (fast) option << " solver='CG' iterations='10'";
  }
  std::ostringstream contact;
  contact.precision(17);
  if (s.restitution > 0) {
    contact << "solref='" << -0.25 / (s.step * s.step) << " 0' ";
  } else if (accurate || fast) {
    contact << "solref='" << 2 * s.step << " 1' ";
  }
  if (accurate) contact << "solimp='0.99 0.999 0.001'";
  return option.str() + "/><default><geom " + contact.str() + "/></default>";
}

std::string modelText(const WorldDef& def, const std::vector<PeerBody>& bodies, const PeerSettings& settings) {
  std::ostringstream assets, tree;
  tree.precision(17);
  const double mu_moving = movingFriction(bodies);
  int mesh = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const PeerBody& b = bodies[i];
    const LinkInertia& inertia = b.link->inertia;
    tree << "<body name='b" << i << "' pos='" << text(b.X_WL.p) << "' quat='" << text(b.X_WL.R) << "'>";
    if (!b.fixed) {
      const Matrix3& I = inertia.I_C;
      tree << "<freejoint/><inertial pos='" << text(inertia.p_LC) << "' mass='" << inertia.mass << "' fullinertia='"
           << I(0, 0) << ' ' << I(1, 1) << ' ' << I(2, 2) << ' ' << I(0, 1) << ' ' << I(0, 2) << ' ' << I(1, 2)
           << "'/>";
    }
    for (const CollisionDef& collision : b.link->collisions) {
      tree << geomText(b, collision, mesh, assets) << frictionOf(b, mu_moving);
    }
    tree << "</body>";
  }
  std::ostringstream model;
  model.precision(17);
  // Contacts of boxes have up to eight points, bodies in heaps half a dozen contacts; what does not fit is dropped by MuJoCo.
  const int contacts = std::min<int>(1500, 50 + 20 * static_cast<int>(bodies.size()));
  model << "<mujoco><compiler inertiafromgeom='false' balanceinertia='false'/><size njmax='" << 4 * contacts
        << "' nconmax='" << contacts << "'/><option timestep='" << settings.step << "' gravity='"
        << text(def.settings.gravity) << "' " << optionText(settings) << "<asset>" << assets.str() << "</asset><worldbody>" << tree.str()
        << "</worldbody></mujoco>";
  return model.str();
}

class MujocoWorld : public PeerWorld {
 public:
  MujocoWorld(const WorldDef& def, const PeerSettings& settings)
      : settings_(settings), bodies_(peerBodies(def, settings_)) {
    mju_user_warning = [](const char*) {};  // else it writes a file into the folder where it was started
    const std::string xml = modelText(def, bodies_, settings);
    mjVFS files;
    mj_defaultVFS(&files);
    mj_makeEmptyFileVFS(&files, "scene.xml", static_cast<int>(xml.size()));
    std::memcpy(files.filedata[mj_findFileVFS(&files, "scene.xml")], xml.data(), xml.size());
    char error[500] = "";
    model_ = mj_loadXML("scene.xml", &files, error, sizeof(error));
    mj_deleteVFS(&files);
    if (!model_) throw SetupError("MuJoCo", error, "the scene is left out for this peer");
    data_ = mj_makeData(model_);
    for (int i = 0, joint = 0; i < static_cast<int>(bodies_.size()); ++i) {
      first_velocity_.push_back(bodies_[i].fixed ? -1 : 6 * joint);
      if (bodies_[i].fixed) continue;
      const Twist& V = bodies_[i].V_WL;
      Eigen::Map<Vector3>(data_->qvel + 6 * joint) = V.linear;  // linear in W, angular in the body's axes
      Eigen::Map<Vector3>(data_->qvel + 6 * joint + 3) = bodies_[i].X_WL.R.transpose() * V.angular;
      ++joint;
    }
    mj_forward(model_, data_);
  }
  ~MujocoWorld() override {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }
  MujocoWorld(const MujocoWorld&) = delete;
  MujocoWorld& operator=(const MujocoWorld&) = delete;

  void step() override {
    mj_step(model_, data_);
    mju_zero(data_->xfrc_applied, 6 * model_->nbody);
  }
  Pose linkPose(int i) const override {
    if (first_velocity_[i] < 0) return bodies_[i].X_WL;
    const double* q = data_->qpos + first_velocity_[i] / 6 * 7;
    return {Quaternion(q[3], q[4], q[5], q[6]).normalized(), Vector3(q[0], q[1], q[2])};
  }
  Twist linkTwist(int i) const override {
    if (first_velocity_[i] < 0) return {};
    const double* v = data_->qvel + first_velocity_[i];
    return {linkPose(i).R * Vector3(v[3], v[4], v[5]), Vector3(v[0], v[1], v[2])};
  }
  void applyForce(int i, const Vector3& f, const Vector3& p) override {
    const Vector3 com = linkPose(i) * bodies_[i].link->inertia.p_LC;
    double* target = data_->xfrc_applied + 6 * (i + 1);  // body 0 is the world
    Eigen::Map<Vector3>(target) += f;
    Eigen::Map<Vector3>(target + 3) += (p - com).cross(f);
  }

 private:
  PeerSettings settings_;
  std::vector<PeerBody> bodies_;
  std::vector<int> first_velocity_;
  mjModel* model_ = nullptr;
  mjData* data_ = nullptr;
};

}  // namespace

std::unique_ptr<PeerWorld> makeMujoco(const WorldDef& def, const PeerSettings& settings) {
  return std::make_unique<MujocoWorld>(def, settings);
}

}  // namespace haptic::peers
