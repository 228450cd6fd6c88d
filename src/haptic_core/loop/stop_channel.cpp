#include "haptic_core/loop/stop_channel.h"

#include <dirent.h>
#include <poll.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <mutex>

#include "haptic_core/base/error.h"
#include "haptic_core/loop/realtime.h"

namespace haptic {
namespace {

constexpr char kEnding[] = ".stop", kFolderName[] = "HAPTIC_STOP_FOLDER";
constexpr std::size_t kLongestAnswer = 400;  // [bytes]
constexpr std::uint64_t kEnd = 1u << 16;     // more than signals that wait
constexpr int kBacklog = 16;
// Above the loop's 60, so that a loop that spins does not keep STOP from its core. It sleeps but for a STOP.
const RealtimeSettings kPrompt{61, false, -1};

// Eventfds of this process's listeners, for the signal's handler.
constexpr std::size_t kListeners = 64;
std::array<std::atomic<int>, kListeners> g_wake{};  // descriptor + 1; 0: none
std::mutex g_mutex;
int g_listeners = 0;
struct sigaction g_before {};

void onSignal(int) {
  const int error = errno;
  const std::uint64_t one = 1;
  for (std::atomic<int>& wake : g_wake)
    if (const int fd = wake.load(); fd > 0 && ::write(fd - 1, &one, sizeof one) < 0) continue;
  errno = error;
}

/// The handler goes with the last listener: its code may be unloaded.
void hearSignal(int wake) {
  std::lock_guard<std::mutex> lock(g_mutex);
  for (std::atomic<int>& slot : g_wake)
    if (int none = 0; slot.compare_exchange_strong(none, wake + 1)) break;
  if (g_listeners++ > 0) return;
  struct sigaction action {};
  action.sa_handler = onSignal;
  action.sa_flags = SA_RESTART;
  ::sigaction(SIGUSR1, &action, &g_before);
}

void forgetSignal(int wake) {
  std::lock_guard<std::mutex> lock(g_mutex);
  for (std::atomic<int>& slot : g_wake)
    if (int mine = wake + 1; slot.compare_exchange_strong(mine, 0)) break;
  if (--g_listeners == 0) ::sigaction(SIGUSR1, &g_before, nullptr);
}

std::string folderOf(uid_t user) {
  const std::string run = "/run/user/" + std::to_string(user);
  struct stat s {};
  if (::stat(run.c_str(), &s) == 0 && s.st_uid == user) return run + "/haptics";
  return "/tmp/haptics-" + std::to_string(user);
}

/// The folder, made when it is not there. Another user's, or one that others may write, is refused.
std::string ownFolder() {
  const std::string folder = stopFolder();
  if (::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST)
    throw SetupError(folder, std::string("cannot be made: ") + std::strerror(errno), "make it, mode 0700: STOP without ROS needs it");
  struct stat s {};
  if (::lstat(folder.c_str(), &s) != 0 || !S_ISDIR(s.st_mode) || s.st_uid != ::geteuid() || (s.st_mode & 077) != 0)
    throw SetupError(folder, "is no folder of yours alone", "remove it, or: chmod 0700 " + folder);
  return folder;
}

sockaddr_un addressOf(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
  return address;
}

bool isOff(const std::string& answer) { return answer.rfind("off ", 0) == 0; }

/// Paths of a folder's entries that begin and end so.
void addEntries(const std::string& folder, const std::string& start, const std::string& end, const std::string& tail,
                std::vector<std::string>& paths) {
  DIR* dir = ::opendir(folder.c_str());
  while (const dirent* entry = dir ? ::readdir(dir) : nullptr) {
    const std::string name = entry->d_name;
    const bool fits = name[0] != '.' && name.size() >= start.size() + end.size() && name.rfind(start, 0) == 0 &&
                      name.compare(name.size() - end.size(), end.size(), end) == 0;
    if (fits) paths.push_back(folder + "/" + name + tail);
  }
  if (dir) ::closedir(dir);
}

std::vector<std::string> foldersToAsk() {
  std::vector<std::string> folders = {stopFolder()};
  if (std::getenv(kFolderName)) return folders;
  // A driver that was started without a session listens in the other place.
  folders.push_back("/tmp/haptics-" + std::to_string(::geteuid()));
  if (::geteuid() == 0) {
    addEntries("/run/user", "", "", "/haptics", folders);
    addEntries("/tmp", "haptics-", "", "", folders);
  }
  std::sort(folders.begin(), folders.end());
  folders.erase(std::unique(folders.begin(), folders.end()), folders.end());
  return folders;
}

/// A connection is a STOP. -1: no listener.
int connectTo(const std::string& path) {
  const int connection = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const sockaddr_un address = addressOf(path);
  if (connection >= 0 && ::connect(connection, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return connection;
  if (errno == ECONNREFUSED) ::unlink(path.c_str());  // its process was killed
  if (connection >= 0) ::close(connection);
  return -1;
}

struct Call {
  Stopped stopped;
  int connection;
  std::string text;
};

/// Reads the bytes that have come; true: the answer is complete.
bool readAnswer(Call& call) {
  char bytes[kLongestAnswer];
  const ssize_t got = ::read(call.connection, bytes, sizeof bytes);
  if (got > 0) call.text.append(bytes, static_cast<std::size_t>(got));
  return got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR) || call.text.size() > kLongestAnswer;
}

}  // namespace

std::string stopFolder() {
  const char* given = std::getenv(kFolderName);
  return given && *given ? given : folderOf(::geteuid());
}

std::vector<std::string> stopSockets(const std::string& device) {
  std::vector<std::string> sockets;
  for (const std::string& folder : foldersToAsk()) {
    struct stat s {};  // another user's folder may hold sockets that answer falsely
    if (::stat(folder.c_str(), &s) == 0 && (s.st_uid == ::geteuid() || ::geteuid() == 0))
      addEntries(folder, device.empty() ? "" : device + ".", kEnding, "", sockets);
  }
  return sockets;
}

StopListener::StopListener(const std::string& device, std::function<StopAnswer()> stop) : stop_(std::move(stop)) {
  std::string name = device;
  std::replace(name.begin(), name.end(), '/', '_');
  path_ = ownFolder() + "/" + name + "." + std::to_string(::getpid()) + kEnding;
  if (path_.size() >= sizeof sockaddr_un{}.sun_path) throw SetupError(path_, "is too long for a socket", "shorten the device's name");
  const sockaddr_un address = addressOf(path_);
  ::unlink(path_.c_str());  // of a process that had this number before
  socket_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  wake_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (socket_ < 0 || wake_ < 0 || ::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(socket_, kBacklog) != 0) {
    const int error = errno;
    if (socket_ >= 0) ::close(socket_);
    if (wake_ >= 0) ::close(wake_);
    throw SetupError(path_, std::string("no socket: ") + std::strerror(error), "make room in its folder: STOP without ROS needs it");
  }
  hearSignal(wake_);
  thread_ = std::thread([this] { run(); });
}

StopListener::~StopListener() {
  forgetSignal(wake_);
  while (::write(wake_, &kEnd, sizeof kEnd) < 0 && errno == EINTR) {
  }
  thread_.join();
  ::unlink(path_.c_str());
  ::close(socket_);
  ::close(wake_);
}

void StopListener::run() {
  enterRealtime(kPrompt);
  for (;;) {
    pollfd ears[2] = {{socket_, POLLIN, 0}, {wake_, POLLIN, 0}};
    if (::poll(ears, 2, -1) < 0) continue;
    std::uint64_t said = 0;
    if (ears[1].revents && ::read(wake_, &said, sizeof said) == sizeof said) {
      if (said % kEnd > 0) stop_();
      if (said >= kEnd) return;
    }
    if (!ears[0].revents) continue;
    if (const int connection = ::accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK); connection >= 0) answer(connection);
  }
}

void StopListener::answer(int connection) const {
  const StopAnswer made = stop_();
  const std::string line = ((made.off ? "off " : "on ") + made.message).substr(0, kLongestAnswer) + "\n";
  // A few hundred bytes always fit into a fresh socket; a caller that has gone wants no answer.
  if (::send(connection, line.data(), line.size(), MSG_NOSIGNAL) < 0) errno = 0;
  ::close(connection);
}

std::vector<Stopped> sayStop(const std::vector<std::string>& sockets, std::chrono::milliseconds patience) {
  std::vector<Call> calls;
  for (const std::string& socket : sockets)
    if (const int connection = connectTo(socket); connection >= 0) calls.push_back({{socket, {}}, connection, {}});
  const std::int64_t deadline = steadyNow() + std::chrono::nanoseconds(patience).count();
  std::vector<Stopped> stopped;
  while (!calls.empty()) {
    std::vector<pollfd> ears;
    for (const Call& call : calls) ears.push_back({call.connection, POLLIN, 0});
    const std::int64_t left_ms = std::max<std::int64_t>(0, (deadline - steadyNow()) / 1000000);
    const int ready = ::poll(ears.data(), ears.size(), static_cast<int>(left_ms));
    if (ready < 0 && errno == EINTR) continue;
    for (std::size_t i = calls.size(); i-- > 0;) {
      Call& call = calls[i];
      const bool done = ears[i].revents && readAnswer(call);
      if (!done && ready > 0) continue;
      ::close(call.connection);
      const std::size_t word = call.text.find(' '), end = call.text.find('\n');
      call.stopped.answer = {isOff(call.text), end == std::string::npos || word == std::string::npos
                                                   ? "it does not answer"
                                                   : call.text.substr(word + 1, end - word - 1)};
      stopped.push_back(std::move(call.stopped));
      calls.erase(calls.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
  return stopped;
}

}  // namespace haptic
