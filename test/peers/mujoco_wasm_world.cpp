// MuJoCo 3 in WebAssembly, from npm: a process of node that steps when it is told (mujoco_wasm.mjs). Through a pipe each way go numbers:
// there the factor on friction, the controls and the forces of a step, back q and v.
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

class MujocoWasmWorld : public MujocoTreeWorld {
 public:
  MujocoWasmWorld(const WorldDef& def, const PeerSettings& settings)
      : MujocoTreeWorld(def, settings),
        q_(layout().nq),
        v_(layout().nv),
        control_(driveCount()),
        force_(6 * bodies().size(), 0),
        node_(HAPTIC_PEERS_FOLDER "/mujoco_wasm.mjs", folderOfModules()) {
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
