#include "spidar_driver/parent_watch.h"

#include <dirent.h>
#include <fcntl.h>
#include <poll.h>
#include <ros/console.h>
#include <ros/init.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <sys/inotify.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

constexpr int kLookEveryMs = 500;  // for what else the parent has started
// What roslaunch (1.12 to 1.17) writes into this log, within the handler of SIGHUP, SIGINT and SIGTERM. Its thread that then asks the nodes
// looks every 0.1 s, and a node takes as long again.
constexpr char kLogName[] = "roslaunch-", kLogEnding[] = ".log", kSaysTheEnd[] = "ProcessMonitor.shutdown";

using Clock = std::chrono::steady_clock;

int descriptorOf(long process) { return static_cast<int>(::syscall(SYS_pidfd_open, process, 0)); }

void ask(int process, int signal) { ::syscall(SYS_pidfd_send_signal, process, signal, nullptr, 0); }

/// Of descriptors in ascending order.
void closeAllBut(const std::vector<int>& kept) {
  unsigned first = 0;
  for (const int descriptor : kept) {
    if (first < static_cast<unsigned>(descriptor)) ::syscall(SYS_close_range, first, descriptor - 1, 0);
    first = static_cast<unsigned>(descriptor) + 1;
  }
  ::syscall(SYS_close_range, first, ~0u, 0);
}

/// Children of a process; /proc alone knows them, for they are not ours.
std::vector<long> childrenOf(long parent) {
  std::vector<long> children;
  const std::string folder = "/proc/" + std::to_string(parent) + "/task";
  DIR* dir = ::opendir(folder.c_str());
  while (const dirent* entry = dir ? ::readdir(dir) : nullptr) {
    std::ifstream list(folder + "/" + entry->d_name + "/children");
    for (long child = 0; list >> child;) children.push_back(child);
  }
  if (dir) ::closedir(dir);
  return children;
}

/// The log that roslaunch has open; empty: the parent is another program, or writes none.
std::string logOf(long parent) {
  std::error_code gone;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/" + std::to_string(parent) + "/fd", gone)) {
    const std::filesystem::path target = std::filesystem::read_symlink(entry.path(), gone);
    if (target.extension() == kLogEnding && target.filename().string().rfind(kLogName, 0) == 0) return target;
  }
  return {};
}

}  // namespace

ParentWatch::ParentWatch(std::function<void()> ended) : ended_(std::move(ended)), parent_id_(::getppid()) {
  parent_ = descriptorOf(parent_id_);
  // Its number may have been given to another process between the two lines: then this one has another parent now.
  if (parent_ < 0 || ::getppid() != parent_id_)
    throw SetupError("~end_with_parent", "the process that started this one cannot be watched",
                     "start it anew; Linux 5.3 or later is needed");
  quit_ = ::eventfd(0, EFD_CLOEXEC);
  followLog();
  thread_ = std::thread([this] { run(); });
}

ParentWatch::~ParentWatch() {
  ::eventfd_write(quit_, 1);
  thread_.join();
  for (const int sibling : siblings_) ::close(sibling);
  for (const int descriptor : {parent_, quit_, log_, log_changed_})
    if (descriptor >= 0) ::close(descriptor);
}

/// From its end on.
void ParentWatch::followLog() {
  const std::string path = logOf(parent_id_);
  if (path.empty()) return;
  log_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (log_ >= 0) ::lseek(log_, 0, SEEK_END);
  log_changed_ = log_ < 0 ? -1 : ::inotify_init1(IN_CLOEXEC | IN_NONBLOCK);
  if (log_changed_ >= 0) ::inotify_add_watch(log_changed_, path.c_str(), IN_MODIFY);
}

bool ParentWatch::logSaysTheEnd() {
  char bytes[4096];
  while (::read(log_changed_, bytes, sizeof bytes) > 0) {
  }
  bool ends = false;
  for (ssize_t got = 0; (got = ::read(log_, bytes, sizeof bytes)) > 0;) {
    log_tail_.append(bytes, static_cast<std::size_t>(got));
    ends = ends || log_tail_.find(kSaysTheEnd) != std::string::npos;
    if (log_tail_.size() >= sizeof kSaysTheEnd) log_tail_.erase(0, log_tail_.size() - sizeof kSaysTheEnd + 1);
  }
  return ends;
}

void ParentWatch::noteSiblings() {
  const std::vector<long> now = childrenOf(parent_id_);
  for (std::size_t i = sibling_ids_.size(); i-- > 0;) {
    if (std::find(now.begin(), now.end(), sibling_ids_[i]) != now.end()) continue;
    ::close(siblings_[i]);
    siblings_.erase(siblings_.begin() + static_cast<std::ptrdiff_t>(i));
    sibling_ids_.erase(sibling_ids_.begin() + static_cast<std::ptrdiff_t>(i));
  }
  for (const long process : now) {
    if (process == ::getpid() || std::find(sibling_ids_.begin(), sibling_ids_.end(), process) != sibling_ids_.end()) continue;
    if (const int descriptor = descriptorOf(process); descriptor >= 0) {
      siblings_.push_back(descriptor);
      sibling_ids_.push_back(process);
    }
  }
}

void ParentWatch::run() {
  pollfd watched[3] = {{parent_, POLLIN, 0}, {quit_, POLLIN, 0}, {log_changed_, POLLIN, 0}};
  do {
    noteSiblings();
    const bool changed = ::poll(watched, 3, kLookEveryMs) > 0 && watched[2].revents;
    if (changed && logSaysTheEnd()) ended_();  // the rest is the parent's: it asks its nodes to end
  } while (!watched[0].revents && !watched[1].revents);
  if (watched[1].revents) return;
  ::alarm(kPatienceSeconds);  // its default action ends this process; the motor guard takes the current then
  ended_();
  ROS_ERROR("the process that started this one has ended: so does this one");
  endSiblings();
  ros::requestShutdown();
}

/// In a process of its own, for this one ends sooner. Between fork and _exit it calls only functions that are safe there, and it
/// holds no descriptor but those of the siblings: neither the device's line nor a socket of the nodes.
void ParentWatch::endSiblings() {
  for (const int sibling : siblings_) ask(sibling, SIGINT);
  std::sort(siblings_.begin(), siblings_.end());
  if (siblings_.empty() || ::fork() != 0) return;
  ::setsid();  // a terminal that closes does not end it
  ::signal(SIGINT, SIG_DFL);
  closeAllBut(siblings_);
  const Clock::time_point end = Clock::now() + std::chrono::milliseconds(kSiblingsPatienceMs);
  for (const int sibling : siblings_) {
    pollfd ended{sibling, POLLIN, 0};
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    if (::poll(&ended, 1, std::max(0, static_cast<int>(left))) == 0) ask(sibling, SIGKILL);
  }
  ::_exit(0);
}

}  // namespace haptic
