// MuJoCo 3 in WebAssembly, from npm (wasm/mujoco.mjs). Numbers go to it and come back: there the factor on friction, the controls and the
// forces of a step, back q and v.
#include <string>

#include "mujoco_model.h"
#include "node_process.h"

namespace haptic::peers {
namespace {

class MujocoWasmWorld : public MujocoTreeWorld {
 public:
  MujocoWasmWorld(const WorldDef& def, const PeerSettings& settings)
      : MujocoTreeWorld(def, settings),
        q_(layout().nq),
        v_(layout().nv),
        control_(driveCount()),
        force_(6 * bodies().size(), 0),
        node_("MuJoCo 3", "mujoco.mjs") {
    layout().start(bodies(), q_.data(), v_.data());
    const std::string xml = mujocoModel(def, bodies(), settings);
    const double sizes[] = {static_cast<double>(xml.size()), static_cast<double>(bodies().size()), static_cast<double>(q_.size()),
                            static_cast<double>(v_.size()), static_cast<double>(control_.size())};
    node_.send(sizes, sizeof sizes);
    node_.send(xml.data(), xml.size());
    node_.send(q_.data(), q_.size() * sizeof(double));
    node_.send(v_.data(), v_.size() * sizeof(double));
    receive();
  }

  void step() override {
    control(control_.data());
    node_.send(&friction_scale_, sizeof friction_scale_);
    node_.send(control_.data(), control_.size() * sizeof(double));
    node_.send(force_.data(), force_.size() * sizeof(double));
    force_.assign(force_.size(), 0);
    receive();
  }
  void applyForce(int i, const Vector3& f, const Vector3& p) override {
    const Vector3 com = linkPose(i) * bodies()[i].link->inertia.p_LC;
    double* target = force_.data() + 6 * (layout().body[i] - 1);
    Eigen::Map<Vector3>(target) += f;
    Eigen::Map<Vector3>(target + 3) += (p - com).cross(f);
  }
  void scaleFriction(double factor) override { friction_scale_ = factor; }

 private:
  const double* positions() const override { return q_.data(); }
  const double* rates() const override { return v_.data(); }
  void receive() {
    node_.receive(q_.data(), q_.size() * sizeof(double));
    node_.receive(v_.data(), v_.size() * sizeof(double));
  }

  double friction_scale_ = 1;
  std::vector<double> q_, v_, control_, force_;
  NodeProcess node_;
};

}  // namespace

std::unique_ptr<PeerWorld> makeMujocoWasm(const WorldDef& def, const PeerSettings& settings) {
  return std::make_unique<MujocoWasmWorld>(def, settings);
}

}  // namespace haptic::peers
