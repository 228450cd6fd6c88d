// MuJoCo 2.2 in this process.
#include <mujoco/mujoco.h>

#include <cstring>

#include "haptic_core/base/error.h"
#include "mujoco_model.h"

namespace haptic::peers {
namespace {

class MujocoWorld : public PeerWorld {
 public:
  MujocoWorld(const WorldDef& def, const PeerSettings& settings)
      : settings_(settings), bodies_(peerBodies(def, settings_)) {
    mju_user_warning = [](const char*) {};  // else it writes a file into the folder where it was started
    const std::string xml = mujocoModel(def, bodies_, settings);
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
  void scaleFriction(double factor) override {
    for (int g = 0; g < model_->ngeom; ++g) model_->geom_friction[3 * g] *= factor / friction_scale_;
    friction_scale_ = factor;
  }

 private:
  PeerSettings settings_;
  double friction_scale_ = 1;
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
