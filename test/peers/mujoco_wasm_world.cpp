// MuJoCo 3 in WebAssembly, from npm: a process of node that steps when it is told (mujoco_wasm.mjs). Through a pipe each way go numbers:
// there the factor on friction and the forces of a step, back q and v.
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

#include "haptic_core/base/error.h"
#include "mujoco_model.h"

namespace haptic::peers {
namespace {

/// A process of node with this program, its standard input and output.
class NodeProcess {
 public:
  NodeProcess(const std::string& program, const std::string& folder) {
    int there[2], back[2];
    if (pipe2(there, O_CLOEXEC) != 0 || pipe2(back, O_CLOEXEC) != 0) throw SetupError("MuJoCo 3", "no pipe is left", "end other programs");
    signal(SIGPIPE, SIG_IGN);  // a process that ended is told by write
    child_ = fork();
    if (child_ == 0) {
      dup2(there[0], 0);
      dup2(back[1], 1);
      execlp("node", "node", program.c_str(), folder.c_str(), static_cast<char*>(nullptr));
      _exit(127);
    }
    close(there[0]), close(back[1]);
    to_ = there[1], from_ = back[0];
  }
  ~NodeProcess() {
    close(to_), close(from_);  // it ends when nothing comes any more
    if (child_ > 0) waitpid(child_, nullptr, 0);
  }
  NodeProcess(const NodeProcess&) = delete;
  NodeProcess& operator=(const NodeProcess&) = delete;

  void send(const void* data, std::size_t bytes) {
    const char* next = static_cast<const char*>(data);
    while (bytes > 0) {
      const ssize_t sent = write(to_, next, bytes);
      if (sent <= 0) throw ended();
      next += sent, bytes -= static_cast<std::size_t>(sent);
    }
  }
  void receive(void* data, std::size_t bytes) {
    char* next = static_cast<char*>(data);
    while (bytes > 0) {
      const ssize_t got = read(from_, next, bytes);
      if (got <= 0) throw ended();
      next += got, bytes -= static_cast<std::size_t>(got);
    }
  }

 private:
  static SetupError ended() {
    return {"MuJoCo 3", "its process of node ended", "see its words on standard error; HAPTIC_MUJOCO_WASM names its folder"};
  }

  pid_t child_ = -1;
  int to_ = -1, from_ = -1;
};

std::string folderOfModules() {
  const char* folder = std::getenv("HAPTIC_MUJOCO_WASM");
  if (!folder || !*folder) {
    throw SetupError("MuJoCo 3", "is not installed",
                     "set HAPTIC_MUJOCO_WASM to a folder with node_modules/@mujoco/mujoco, as ./run report does");
  }
  return folder;
}

class MujocoWasmWorld : public PeerWorld {
 public:
  MujocoWasmWorld(const WorldDef& def, const PeerSettings& settings)
      : bodies_(peerBodies(def, settings)), node_(HAPTIC_PEERS_FOLDER "/mujoco_wasm.mjs", folderOfModules()) {
    for (const PeerBody& body : bodies_) {
      row_.push_back(body.fixed ? -1 : free_);
      free_ += !body.fixed;
    }
    q_.resize(7 * static_cast<std::size_t>(free_)), v_.resize(6 * static_cast<std::size_t>(free_));
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (row_[i] < 0) continue;
      const Twist& V = bodies_[i].V_WL;
      Eigen::Map<Vector3>(v_.data() + 6 * row_[i]) = V.linear;  // linear in W, angular in the body's axes
      Eigen::Map<Vector3>(v_.data() + 6 * row_[i] + 3) = bodies_[i].X_WL.R.transpose() * V.angular;
    }
    const std::string xml = mujocoModel(def, bodies_, settings);
    const double sizes[] = {static_cast<double>(xml.size()), static_cast<double>(bodies_.size()), static_cast<double>(free_)};
    node_.send(sizes, sizeof sizes);
    node_.send(xml.data(), xml.size());
    node_.send(v_.data(), v_.size() * sizeof(double));
    receive();
    force_.assign(6 * bodies_.size(), 0);
  }

  void step() override {
    node_.send(&friction_scale_, sizeof friction_scale_);
    node_.send(force_.data(), force_.size() * sizeof(double));
    force_.assign(force_.size(), 0);
    receive();
  }
  Pose linkPose(int i) const override {
    if (row_[i] < 0) return bodies_[i].X_WL;
    const double* q = q_.data() + 7 * row_[i];
    return {Quaternion(q[3], q[4], q[5], q[6]).normalized(), Vector3(q[0], q[1], q[2])};
  }
  Twist linkTwist(int i) const override {
    if (row_[i] < 0) return {};
    const double* v = v_.data() + 6 * row_[i];
    return {linkPose(i).R * Vector3(v[3], v[4], v[5]), Vector3(v[0], v[1], v[2])};
  }
  void applyForce(int i, const Vector3& f, const Vector3& p) override {
    const Vector3 com = linkPose(i) * bodies_[i].link->inertia.p_LC;
    Eigen::Map<Vector3>(force_.data() + 6 * i) += f;
    Eigen::Map<Vector3>(force_.data() + 6 * i + 3) += (p - com).cross(f);
  }
  void scaleFriction(double factor) override { friction_scale_ = factor; }

 private:
  void receive() {
    node_.receive(q_.data(), q_.size() * sizeof(double));
    node_.receive(v_.data(), v_.size() * sizeof(double));
  }

  std::vector<PeerBody> bodies_;
  std::vector<int> row_;  ///< among free bodies; -1: fixed
  int free_ = 0;
  double friction_scale_ = 1;
  std::vector<double> q_, v_, force_;
  NodeProcess node_;
};

}  // namespace

std::unique_ptr<PeerWorld> makeMujocoWasm(const WorldDef& def, const PeerSettings& settings) {
  return std::make_unique<MujocoWasmWorld>(def, settings);
}

}  // namespace haptic::peers
