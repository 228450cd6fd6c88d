// MuJoCo 2.2: default solref and solimp, Newton solver, pyramidal cone, Euler or RK4; the model is written as MJCF.
#include <mujoco/mujoco.h>

#include <cmath>
#include <cstring>
#include <sstream>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/convex_polyhedron.h"
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

std::string modelText(const WorldDef& def, const std::vector<PeerBody>& bodies, const PeerSettings& settings) {
  std::ostringstream assets, tree;
  tree.precision(17);
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
      const std::string place = "' pos='" + text(collision.X_LS.p) + "' quat='" + text(collision.X_LS.R) + "'";
      const std::string friction = " friction='" + std::to_string(b.mu) + " 0.005 0.0001'/>";
      const ConvexPolyhedron* hull = collision.shape->polyhedron();
      if (!hull) {
        tree << "<geom type='sphere' size='" << collision.shape->boundingRadius() << place << friction;
      } else if (hull->isBox()) {
        tree << "<geom type='box' size='" << text(hull->halfSize()) << place << friction;
      } else {
        assets << "<mesh name='m" << mesh << "' vertex='";
        for (const Vector3& v : hull->vertices()) assets << text(v) << ' ';
        assets << "'/>";
        tree << "<geom type='mesh' mesh='m" << mesh++ << place << friction;
      }
    }
    tree << "</body>";
  }
  std::ostringstream model;
  model.precision(17);
  model << "<mujoco><compiler inertiafromgeom='false' balanceinertia='false'/><size njmax='3000' nconmax='800'/>"
        << "<option timestep='" << settings.step << "' gravity='" << text(def.settings.gravity) << "' integrator='"
        << (settings.peer == Peer::kMujocoRk4 ? "RK4" : "Euler") << "'/><asset>" << assets.str()
        << "</asset><worldbody>" << tree.str() << "</worldbody></mujoco>";
  return model.str();
}

class MujocoWorld : public PeerWorld {
 public:
  MujocoWorld(const WorldDef& def, const PeerSettings& settings) : bodies_(peerBodies(def)) {
    if (settings.restitution > 0) {
      throw SetupError("MuJoCo", "has no coefficient of restitution", "the scene is left out for this peer");
    }
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
