#include "spidar_driver/command_gate.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <netdb.h>
#include <ros/connection_manager.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <ros/xmlrpc_manager.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

#include "haptic_core/base/error.h"
#include "haptic_core/loop/realtime.h"

namespace haptic {
namespace {

constexpr double kFreshSeconds = 0.05;

/// Numeric text of an address; an IPv4 one inside IPv6 as IPv4. Empty: of no internet family.
std::string textOf(const sockaddr* address) {
  char text[INET6_ADDRSTRLEN] = "";
  if (address->sa_family == AF_INET) {
    ::inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(address)->sin_addr, text, sizeof text);
  } else if (address->sa_family == AF_INET6) {
    const in6_addr& six = reinterpret_cast<const sockaddr_in6*>(address)->sin6_addr;
    if (IN6_IS_ADDR_V4MAPPED(&six))
      ::inet_ntop(AF_INET, six.s6_addr + 12, text, sizeof text);
    else
      ::inet_ntop(AF_INET6, &six, text, sizeof text);
  }
  return text;
}

bool isNumeric(const std::string& address) {
  in6_addr any;
  return ::inet_pton(AF_INET, address.c_str(), &any) == 1 ||
         ::inet_pton(AF_INET6, address.c_str(), &any) == 1;
}

bool isOwn(const std::string& address) {
  if (address.rfind("127.", 0) == 0 || address == "::1") return true;
  ifaddrs* interfaces = nullptr;
  if (::getifaddrs(&interfaces) != 0) return false;
  bool own = false;
  for (const ifaddrs* i = interfaces; i && !own; i = i->ifa_next)
    own = i->ifa_addr && textOf(i->ifa_addr) == address;
  ::freeifaddrs(interfaces);
  return own;
}

/// Every address that a host's name or number stands for.
std::vector<std::string> addressesOf(const std::string& host) {
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  std::vector<std::string> addresses;
  if (::getaddrinfo(host.c_str(), nullptr, &hints, &found) != 0) return addresses;
  for (const addrinfo* a = found; a; a = a->ai_next) addresses.push_back(textOf(a->ai_addr));
  ::freeaddrinfo(found);
  return addresses;
}

/// The far end of a connection, by what roscpp says of it: "... [host:port on socket 17]". Empty: in this
/// process.
std::string peerOf(const std::string& transport) {
  const std::size_t at = transport.find("on socket ");
  if (at == std::string::npos) return transport.find("TCPROS") == std::string::npos ? "" : "unknown";
  sockaddr_storage peer{};
  socklen_t size = sizeof peer;
  const int descriptor = std::atoi(transport.c_str() + at + 10);
  if (::getpeername(descriptor, reinterpret_cast<sockaddr*>(&peer), &size) != 0) return "unknown";
  return textOf(reinterpret_cast<const sockaddr*>(&peer));
}

/// Address of /proc/net/tcp and tcp6: 32-bit words in the machine's byte order, as hexadecimal digits.
std::string addressOfHex(const std::string& digits) {
  const std::size_t words = digits.size() / 8;
  std::uint32_t word[4] = {};
  for (std::size_t i = 0; i < words && i < 4; ++i)
    word[i] = static_cast<std::uint32_t>(std::strtoul(digits.substr(8 * i, 8).c_str(), nullptr, 16));
  sockaddr_in four{};
  sockaddr_in6 six{};
  four.sin_family = AF_INET;
  six.sin6_family = AF_INET6;
  std::memcpy(&four.sin_addr, word, 4);
  std::memcpy(&six.sin6_addr, word, 16);
  return words == 1 ? textOf(reinterpret_cast<sockaddr*>(&four)) : textOf(reinterpret_cast<sockaddr*>(&six));
}

/// Far ends of the machine's established connections; `port`: of those that were made to it, 0: of all.
std::vector<std::string> peers(std::uint32_t port) {
  constexpr char kEstablished[] = "01";
  std::vector<std::string> found;
  for (const char* table : {"/proc/self/net/tcp", "/proc/self/net/tcp6"}) {
    std::ifstream lines(table);
    std::string line, number, local, remote, state;
    std::getline(lines, line);  // headings
    while (std::getline(lines, line)) {
      std::istringstream(line) >> number >> local >> remote >> state;
      const std::size_t colon = local.find(':'), far = remote.find(':');
      if (state != kEstablished || colon == std::string::npos || far == std::string::npos) continue;
      if (port == 0 || std::strtoul(local.c_str() + colon + 1, nullptr, 16) == port)
        found.push_back(addressOfHex(remote.substr(0, far)));
    }
  }
  return found;
}

/// What this node says of its connections, by the call that rosnode info makes.
XmlRpc::XmlRpcValue busInfo() {
  XmlRpc::XmlRpcValue request, response;
  std::string host;
  std::uint32_t port = 0;
  const ros::XMLRPCManagerPtr& server = ros::XMLRPCManager::instance();
  if (!ros::network::splitURI(server->getServerURI(), host, port)) return {};
  request[0] = ros::this_node::getName();
  XmlRpc::XmlRpcClient* client = server->getXMLRPCClient(host, static_cast<int>(port), "/");
  const bool told = client->execute("getBusInfo", request, response);
  server->releaseXMLRPCClient(client);
  if (!told || response.getType() != XmlRpc::XmlRpcValue::TypeArray || response.size() < 3) return {};
  return response[2];
}

std::string elsewhere(const std::string& who, const std::string& address) {
  return who + " is at " + address +
         ", another machine: name its address in ~allowed_addresses if it may move motors";
}

}  // namespace

CommandGate::CommandGate(const std::vector<std::string>& allowed) : allowed_(allowed) {
  for (const std::string& address : allowed)
    if (!isNumeric(address))
      throw SetupError("~allowed_addresses", "'" + address + "' is no address",
                       "give numbers, as 192.168.1.20");
}

bool CommandGate::allows(const std::string& address) const {
  return std::find(allowed_.begin(), allowed_.end(), address) != allowed_.end() || isOwn(address);
}

bool CommandGate::allowsAll(const std::vector<std::string>& addresses) const {
  return std::all_of(addresses.begin(), addresses.end(),
                     [this](const std::string& address) { return allows(address); });
}

std::string CommandGate::refuseTopic(const std::string& topic) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double now = 1e-9 * static_cast<double>(steadyNow());
  if (topic == topic_ && now - asked_ < kFreshSeconds) return why_;
  topic_ = topic;
  asked_ = now;
  why_.clear();
  if (allowsAll(peers(0))) return why_;  // nobody from elsewhere is connected to this machine
  XmlRpc::XmlRpcValue connections = busInfo();
  if (connections.getType() != XmlRpc::XmlRpcValue::TypeArray)
    return why_ = "who publishes it cannot be read";
  for (int i = 0; i < connections.size() && why_.empty(); ++i) {
    XmlRpc::XmlRpcValue& c =
        connections[i];  // [id, other end, direction, transport, topic, connected, information]
    if (c.size() < 7 || static_cast<std::string&>(c[2]) != "i" || static_cast<std::string&>(c[4]) != topic)
      continue;
    const std::string peer = peerOf(static_cast<std::string&>(c[6]));
    if (!peer.empty() && !allows(peer)) why_ = elsewhere("a publisher of it", peer);
  }
  return why_;
}

std::string CommandGate::refuseCaller(const std::string& caller) const {
  if (allowsAll(peers(ros::ConnectionManager::instance()->getTCPPort()))) return {};
  XmlRpc::XmlRpcValue request, response, payload;
  request[0] = ros::this_node::getName();
  request[1] = caller;
  if (!ros::master::execute("lookupNode", request, response, payload, false))
    return "the master does not know the caller " + caller;
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(static_cast<std::string&>(payload), host, port))
    return "the caller " + caller + " has no address";
  const std::vector<std::string> addresses = addressesOf(host);
  if (addresses.empty()) return "the caller's host " + host + " is not known";
  for (const std::string& address : addresses)
    if (!allows(address)) return elsewhere("the caller " + caller, address);
  return {};
}

}  // namespace haptic
