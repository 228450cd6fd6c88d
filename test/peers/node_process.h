/// A process of node that steps an engine in WebAssembly when it is told, through a pipe each way.
#pragma once
#include <sys/types.h>

#include <memory>
#include <string>

#include "haptic_core/base/error.h"

namespace haptic::peers {

/// Runs `test/peers/wasm/PROGRAM FOLDER`, FOLDER the one that HAPTIC_WASM_PEERS names, with its node_modules. Ends with this.
class NodeProcess {
 public:
  /// Throws SetupError that names `engine`.
  NodeProcess(std::string engine, const std::string& program);
  ~NodeProcess();
  NodeProcess(const NodeProcess&) = delete;
  NodeProcess& operator=(const NodeProcess&) = delete;

  void send(const void* data, std::size_t bytes);  ///< throws SetupError where the process has ended
  void receive(void* data, std::size_t bytes);     ///< likewise
  bool hasEnded() const { return has_ended_; }

 private:
  SetupError ended();

  std::string engine_;
  pid_t child_ = -1;
  int to_ = -1, from_ = -1;
  bool has_ended_ = false;
};

/// The process that `program` runs in, for one world. Worlds that follow one another share it, for to load an engine takes longer than most
/// runs; one that begins while another lives has its own. A world ends with a message whose first number is NaN.
std::shared_ptr<NodeProcess> nodeOf(const std::string& engine, const std::string& program);

}  // namespace haptic::peers
