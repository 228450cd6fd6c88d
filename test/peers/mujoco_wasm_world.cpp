// MuJoCo 3 in WebAssembly, from npm (wasm/mujoco.mjs). Numbers go to it and come back: there the factor on friction, the controls and the
// forces of a step, back q and v.
#include <algorithm>
#include <cmath>
#include <string>

#include "mujoco_model.h"
#include "node_process.h"

namespace haptic::peers {
namespace {

class MujocoWasmWorld : public MujocoTreeWorld {
 public:
  MujocoWasmWorld(const WorldDef& def, const PeerSettings& settings)
      : MujocoTreeWorld(def, settings),
        state_(layout().nq + layout().nv),
        told_(1 + driveCount() + 6 * bodies().size(), 0),
        node_(nodeOf("MuJoCo 3", "mujoco.mjs")) {
    layout().start(bodies(), state_.data(), state_.data() + layout().nq);
    told_[0] = 1;
    const std::string xml = mujocoModel(def, bodies(), settings);
    const double sizes[] = {static_cast<double>(xml.size()), static_cast<double>(bodies().size()), static_cast<double>(layout().nq),
                            static_cast<double>(layout().nv), static_cast<double>(driveCount())};
    node_->send(sizes, sizeof sizes);
    node_->send(xml.data(), xml.size());
    node_->send(state_.data(), state_.size() * sizeof(double));
    receive();
  }
  ~MujocoWasmWorld() override {
    told_[0] = std::nan("");
    try {
      node_->send(told_.data(), told_.size() * sizeof(double));
    } catch (const std::exception&) {  // it has ended before
    }
  }

  void step() override {
    control(told_.data() + 1);
    node_->send(told_.data(), told_.size() * sizeof(double));
    std::fill(told_.end() - 6 * bodies().size(), told_.end(), 0.0);
    receive();
  }
  void applyForce(int i, const Vector3& f, const Vector3& p) override {
    const Vector3 com = linkPose(i) * bodies()[i].link->inertia.p_LC;
    double* target = told_.data() + 1 + driveCount() + 6 * (layout().body[i] - 1);
    Eigen::Map<Vector3>(target) += f;
    Eigen::Map<Vector3>(target + 3) += (p - com).cross(f);
  }
  void scaleFriction(double factor) override { told_[0] = factor; }

 private:
  const double* positions() const override { return state_.data(); }
  const double* rates() const override { return state_.data() + layout().nq; }
  void receive() { node_->receive(state_.data(), state_.size() * sizeof(double)); }

  std::vector<double> state_, told_;  ///< q and v; the factor on friction, controls, forces and torques about each C
  std::shared_ptr<NodeProcess> node_;
};

}  // namespace

std::unique_ptr<PeerWorld> makeMujocoWasm(const WorldDef& def, const PeerSettings& settings) {
  return std::make_unique<MujocoWasmWorld>(def, settings);
}

}  // namespace haptic::peers
