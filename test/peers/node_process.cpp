#include "node_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <map>

namespace haptic::peers {

NodeProcess::NodeProcess(std::string engine, const std::string& program) : engine_(std::move(engine)) {
  const char* folder = std::getenv("HAPTIC_WASM_PEERS");
  if (!folder || !*folder) {
    throw SetupError(engine_, "is not installed",
                     "set HAPTIC_WASM_PEERS to a folder with the node_modules of test/peers/wasm, as ./run report does");
  }
  const std::string path = HAPTIC_PEERS_FOLDER "/wasm/" + program;
  int there[2], back[2];
  if (pipe2(there, O_CLOEXEC) != 0 || pipe2(back, O_CLOEXEC) != 0) throw SetupError(engine_, "has no pipe", "end other programs");
  signal(SIGPIPE, SIG_IGN);  // a process that ended is told by write
  child_ = fork();
  if (child_ == 0) {
    dup2(there[0], 0);
    dup2(back[1], 1);
    // It serves several runs, so the bound of the first is not its own.
    rlimit cpu;
    if (getrlimit(RLIMIT_CPU, &cpu) == 0) cpu.rlim_cur = cpu.rlim_max, setrlimit(RLIMIT_CPU, &cpu);
    // Compiling to fast code and looking at functions that are never called take longer than most runs, whose time counts for nothing.
    execlp("node", "node", "--liftoff-only", "--wasm-lazy-validation", path.c_str(), folder,
           static_cast<char*>(nullptr));
    _exit(127);
  }
  close(there[0]), close(back[1]);
  to_ = there[1], from_ = back[0];
}

NodeProcess::~NodeProcess() {
  close(to_), close(from_);  // it ends when nothing comes any more
  if (child_ > 0) waitpid(child_, nullptr, 0);
}

void NodeProcess::send(const void* data, std::size_t bytes) {
  const char* next = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t sent = write(to_, next, bytes);
    if (sent <= 0) throw ended();
    next += sent, bytes -= static_cast<std::size_t>(sent);
  }
}

void NodeProcess::receive(void* data, std::size_t bytes) {
  char* next = static_cast<char*>(data);
  while (bytes > 0) {
    const ssize_t got = read(from_, next, bytes);
    if (got <= 0) throw ended();
    next += got, bytes -= static_cast<std::size_t>(got);
  }
}

SetupError NodeProcess::ended() {
  has_ended_ = true;
  return {engine_, "its process of node ended", "see its words on standard error; HAPTIC_WASM_PEERS names its folder"};
}

std::shared_ptr<NodeProcess> nodeOf(const std::string& engine, const std::string& program) {
  static std::map<std::string, std::shared_ptr<NodeProcess>> kept;
  std::shared_ptr<NodeProcess>& node = kept[program];
  if (node && node.use_count() > 1) return std::make_shared<NodeProcess>(engine, program);
  if (!node || node->hasEnded()) node = std::make_shared<NodeProcess>(engine, program);
  return node;
}

}  // namespace haptic::peers
