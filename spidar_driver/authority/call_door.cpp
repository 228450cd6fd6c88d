#include "spidar_driver/authority/call_door.h"

#include <fcntl.h>
#include <ros/console.h>
#include <strings.h>
#include <sys/socket.h>
#include <unistd.h>
#include <xmlrpcpp/XmlRpcServerConnection.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <sstream>

#include "spidar_driver/authority/addresses.h"
#include "spidar_driver/authority/commanders.h"

namespace haptic {
namespace {

using XmlRpc::XmlRpcDispatch;

/// Longest request of a machine that may command, with its header [byte]. The longest that a master sends names the publishers of a topic:
/// 1 MB has room for ten thousand. More: one caller may take as much memory as it likes.
constexpr std::size_t kLongest = 1 << 20;
/// Longest request of another machine [byte]: who looks at a topic names itself, the topic and a way.
constexpr std::size_t kLongestOfStrangers = 16 << 10;
/// Connections of other machines at once; another one ends the oldest. Each has room for a request: together half a megabyte.
constexpr std::size_t kStrangers = 32;
/// What has come of all requests together [byte]: four of the longest. Beyond it one that is longer than a stranger's may be ends.
/// Without a bound two hundred connections of one caller took 190 MB.
constexpr std::size_t kMostHeld = 4 * kLongest;
/// Arrays and structures within one another in a request. The library reads them by recursion: 1 MB of opening tags takes all of the stack.
constexpr int kDeepest = 32;

/// What a header says behind `name`, without spaces before it; empty: nothing.
std::string fieldOf(const std::string& header, const std::string& name) {
  std::istringstream lines(header);
  for (std::string line; std::getline(lines, line);) {
    if (::strncasecmp(line.c_str(), name.c_str(), name.size()) != 0) continue;
    const std::size_t begin = line.find_first_not_of(' ', name.size());
    return begin == std::string::npos ? std::string() : line.substr(begin);
  }
  return {};
}

int depthOf(const std::string& text) {
  int depth = 0, deepest = 0;
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
    const bool ends = text[at + 1] == '/';
    const char* tag = text.c_str() + at + (ends ? 2 : 1);
    if (::strncasecmp(tag, "array", 5) != 0 && ::strncasecmp(tag, "struct", 6) != 0) continue;
    depth += ends ? -1 : 1;
    deepest = std::max(deepest, depth);
  }
  return deepest;
}

/// The library keeps it for those who derive from its class.
struct Sources : XmlRpcDispatch {
  static const SourceList& of(const XmlRpcDispatch& dispatch) { return dispatch.*(&Sources::_sources); }
};

}  // namespace

std::vector<XmlRpc::XmlRpcSource*> sourcesOf(const XmlRpcDispatch& dispatch) {
  std::vector<XmlRpc::XmlRpcSource*> sources;
  for (const auto& monitored : Sources::of(dispatch)) sources.push_back(monitored._src);
  return sources;
}

/// Reads for itself, as much as its address may send, and leaves the rest to the library.
class CallDoor::Connection : public XmlRpc::XmlRpcServerConnection {
 public:
  Connection(CallDoor& door, int socket, const std::string& address, bool commands)
      : XmlRpcServerConnection(socket, &door.server_, true),
        door_(door),
        address_(address),
        longest_(commands ? kLongest : kLongestOfStrangers) {}
  ~Connection() override {
    door_.strangers_.remove(this);
    door_.held_ -= counted_;
  }

  unsigned handleEvent(unsigned event) override {
    if (_connectionState != WRITE_RESPONSE) {
      if (!read()) return 0;
      if (_connectionState != WRITE_RESPONSE) return XmlRpcDispatch::ReadableEvent;
    }
    door_.caller_ = address_;
    const unsigned next = XmlRpcServerConnection::handleEvent(event);
    door_.caller_.clear();
    count();
    return next;
  }

 private:
  /// One piece; the rest comes with the next event, so that no caller keeps the thread. False: the connection ends.
  bool read() {
    char piece[16384];
    const ssize_t got = ::recv(getfd(), piece, sizeof piece, MSG_DONTWAIT);
    if (got <= 0) return got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR);
    _request.append(piece, static_cast<std::size_t>(got));
    count();
    if (door_.held_ > kMostHeld && _request.size() > kLongestOfStrangers) return refuse("came while others held all room for calls");
    if (_connectionState == READ_HEADER && !readHead()) return false;
    if (_request.size() > longest_) return refuse("is longer than " + std::to_string(longest_) + " bytes");
    if (_connectionState == READ_HEADER || static_cast<int>(_request.size()) < _contentLength) return true;
    if (depthOf(_request) > kDeepest) return refuse("has more than " + std::to_string(kDeepest) + " arrays within one another");
    _connectionState = WRITE_RESPONSE;
    return true;
  }

  /// Looks for the header's end in what has come. False: it is none, or tells a request that is too long.
  bool readHead() {
    std::size_t end = _request.find("\r\n\r\n"), gap = 4;
    if (const std::size_t plain = _request.find("\n\n"); plain < end) end = plain, gap = 2;
    if (end == std::string::npos) return true;
    const std::string header = _request.substr(0, end);
    const std::string length = fieldOf(header, "Content-length:"), keep = fieldOf(header, "Connection:");
    char* after = nullptr;
    const long told = std::strtol(length.c_str(), &after, 10);
    if (after == length.c_str() || told < 0) return refuse("tells no length");
    if (static_cast<unsigned long>(told) > longest_)
      return refuse("has " + std::to_string(told) + " bytes, and " + std::to_string(longest_) + " may come");
    _contentLength = static_cast<int>(told);
    const bool old = header.find("HTTP/1.0") != std::string::npos;
    _keepAlive = old ? ::strncasecmp(keep.c_str(), "keep-alive", 10) == 0 : ::strncasecmp(keep.c_str(), "close", 5) != 0;
    _request.erase(0, end + gap);
    _connectionState = READ_REQUEST;
    return true;
  }

  void count() {
    door_.held_ += _request.size() - counted_;
    counted_ = _request.size();
  }

  bool refuse(const std::string& why) const {
    ROS_WARN_STREAM_THROTTLE(1.0, "refused: a call from " << address_ << " " << why);
    return false;
  }

  CallDoor& door_;
  const std::string address_;
  const std::size_t longest_;
  std::size_t counted_ = 0;  ///< of this one in `held_` [byte]
};

CallDoor::CallDoor(XmlRpc::XmlRpcServer& server, XmlRpcDispatch& dispatch, const Commanders& commanders)
    : XmlRpcSource(::fcntl(server.getfd(), F_DUPFD_CLOEXEC, 0)), server_(server), dispatch_(dispatch), commanders_(commanders) {
  for (XmlRpc::XmlRpcSource* source : sourcesOf(dispatch)) {
    if (!dynamic_cast<XmlRpc::XmlRpcServerConnection*>(source)) continue;
    dispatch.removeSource(source);
    source->close();  // and is deleted
  }
  dispatch.removeSource(&server);
  dispatch.addSource(this, XmlRpcDispatch::ReadableEvent);
}

unsigned CallDoor::handleEvent(unsigned) {
  const int socket = ::accept4(getfd(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (socket < 0) {
    if (errno == EMFILE || errno == ENFILE) ::usleep(10'000);  // nobody else can be answered either; no spinning meanwhile
    return XmlRpcDispatch::ReadableEvent;
  }
  const std::string address = peerAddress(socket);
  const bool commands = commanders_.allows(address);
  if (!commands && strangers_.size() >= kStrangers) {
    ::shutdown(strangers_.front()->getfd(), SHUT_RDWR);  // it ends by its own next event, which may be under way
    strangers_.pop_front();
  }
  auto* connection = new Connection(*this, socket, address, commands);
  if (!commands) strangers_.push_back(connection);
  dispatch_.addSource(connection, XmlRpcDispatch::ReadableEvent);
  return XmlRpcDispatch::ReadableEvent;
}

}  // namespace haptic
