#include "spidar_driver/parent_watch.h"

#include <dirent.h>
#include <poll.h>
#include <ros/console.h>
#include <ros/init.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <string>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

constexpr int kLookEveryMs = 500;  // for what else the parent has started

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

}  // namespace

ParentWatch::ParentWatch(std::function<void()> ended) : ended_(std::move(ended)), parent_id_(::getppid()) {
  parent_ = descriptorOf(parent_id_);
  // Its number may have been given to another process between the two lines: then this one has another parent now.
  if (parent_ < 0 || ::getppid() != parent_id_)
    throw SetupError("~end_with_parent", "the process that started this one cannot be watched",
                     "start it anew; Linux 5.3 or later is needed");
  quit_ = ::eventfd(0, EFD_CLOEXEC);
  thread_ = std::thread([this] { run(); });
}

ParentWatch::~ParentWatch() {
  ::eventfd_write(quit_, 1);
  thread_.join();
  for (const int sibling : siblings_) ::close(sibling);
  ::close(parent_);
  ::close(quit_);
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
  pollfd watched[2] = {{parent_, POLLIN, 0}, {quit_, POLLIN, 0}};
  do {
    noteSiblings();
  } while (::poll(watched, 2, kLookEveryMs) <= 0);
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
