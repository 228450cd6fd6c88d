// MuJoCo 2.2 in this process.
#include <mujoco/mujoco.h>

#include <cstring>

#include "haptic_core/base/error.h"
#include "mujoco_model.h"

namespace haptic::peers {
namespace {

class MujocoWorld : public MujocoTreeWorld {
 public:
  MujocoWorld(const WorldDef& def, const PeerSettings& settings) : MujocoTreeWorld(def, settings) {
    mju_user_warning = [](const char*) {};  // else it writes a file into the folder where it was started
    const std::string xml = mujocoModel(def, bodies(), settings);
    mjVFS files;
    mj_defaultVFS(&files);
    mj_makeEmptyFileVFS(&files, "scene.xml", static_cast<int>(xml.size()));
    std::memcpy(files.filedata[mj_findFileVFS(&files, "scene.xml")], xml.data(), xml.size());
    char error[500] = "";
    model_ = mj_loadXML("scene.xml", &files, error, sizeof(error));
    mj_deleteVFS(&files);
    if (!model_) throw SetupError("MuJoCo", error, "the scene is left out for this peer");
    data_ = mj_makeData(model_);
    layout().start(bodies(), data_->qpos, data_->qvel);
    mj_forward(model_, data_);
  }
  ~MujocoWorld() override {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }
  MujocoWorld(const MujocoWorld&) = delete;
  MujocoWorld& operator=(const MujocoWorld&) = delete;

  void step() override {
    control(data_->ctrl);
    mj_step(model_, data_);
    mju_zero(data_->xfrc_applied, 6 * model_->nbody);
  }
  void applyForce(int i, const Vector3& f, const Vector3& p) override {
    const Vector3 com = linkPose(i) * bodies()[i].link->inertia.p_LC;
    double* target = data_->xfrc_applied + 6 * layout().body[i];
    Eigen::Map<Vector3>(target) += f;
    Eigen::Map<Vector3>(target + 3) += (p - com).cross(f);
  }
  void scaleFriction(double factor) override {
    for (int g = 0; g < model_->ngeom; ++g) model_->geom_friction[3 * g] *= factor / friction_scale_;
    friction_scale_ = factor;
  }

 private:
  const double* positions() const override { return data_->qpos; }
  const double* rates() const override { return data_->qvel; }

  double friction_scale_ = 1;
  mjModel* model_ = nullptr;
  mjData* data_ = nullptr;
};

}  // namespace

std::unique_ptr<PeerWorld> makeMujoco(const WorldDef& def, const PeerSettings& settings) {
  return std::make_unique<MujocoWorld>(def, settings);
}

}  // namespace haptic::peers
