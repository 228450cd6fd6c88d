#include "spidar_driver/authority/addresses.h"

#include <arpa/inet.h>
#include <dirent.h>
#include <ifaddrs.h>
#include <netdb.h>

#include <cstdlib>

namespace haptic {
namespace {

/// Port of an internet address; 0: of another family.
std::uint32_t portOf(const sockaddr_storage& address) {
  if (address.ss_family == AF_INET) return ntohs(reinterpret_cast<const sockaddr_in&>(address).sin_port);
  if (address.ss_family == AF_INET6) return ntohs(reinterpret_cast<const sockaddr_in6&>(address).sin6_port);
  return 0;
}

}  // namespace

std::string addressText(const sockaddr* address) {
  char text[INET6_ADDRSTRLEN] = "";
  if (address->sa_family == AF_INET) {
    ::inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(address)->sin_addr, text, sizeof text);
  } else if (address->sa_family == AF_INET6) {
    const in6_addr& six = reinterpret_cast<const sockaddr_in6*>(address)->sin6_addr;
    if (IN6_IS_ADDR_V4MAPPED(&six)) {
      ::inet_ntop(AF_INET, six.s6_addr + 12, text, sizeof text);
    } else {
      ::inet_ntop(AF_INET6, &six, text, sizeof text);
    }
  }
  return text;
}

bool isAddress(const std::string& text) {
  in6_addr any;
  return ::inet_pton(AF_INET, text.c_str(), &any) == 1 || ::inet_pton(AF_INET6, text.c_str(), &any) == 1;
}

bool isOwnAddress(const std::string& address) {
  if (!isAddress(address)) return false;
  if (address.rfind("127.", 0) == 0 || address == "::1") return true;
  ifaddrs* interfaces = nullptr;
  if (::getifaddrs(&interfaces) != 0) return false;
  bool own = false;
  for (const ifaddrs* i = interfaces; i && !own; i = i->ifa_next) own = i->ifa_addr && addressText(i->ifa_addr) == address;
  ::freeifaddrs(interfaces);
  return own;
}

std::vector<std::string> addressesOf(const std::string& host) {
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  std::vector<std::string> addresses;
  if (::getaddrinfo(host.c_str(), nullptr, &hints, &found) != 0) return addresses;
  for (const addrinfo* a = found; a; a = a->ai_next) addresses.push_back(addressText(a->ai_addr));
  ::freeaddrinfo(found);
  return addresses;
}

std::string peerAddress(int socket) {
  sockaddr_storage peer{};
  socklen_t size = sizeof peer;
  if (::getpeername(socket, reinterpret_cast<sockaddr*>(&peer), &size) != 0) return {};
  return addressText(reinterpret_cast<const sockaddr*>(&peer));
}

std::vector<int> socketsAt(std::uint32_t port, bool listening) {
  std::vector<int> found;
  DIR* open = ::opendir("/proc/self/fd");
  if (!open) return found;
  while (const dirent* entry = ::readdir(open)) {
    const int descriptor = std::atoi(entry->d_name);
    int listens = 0;
    sockaddr_storage local{};
    socklen_t size = sizeof listens, length = sizeof local;
    if (::getsockopt(descriptor, SOL_SOCKET, SO_ACCEPTCONN, &listens, &size) != 0) continue;
    if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&local), &length) != 0) continue;
    if (portOf(local) == port && (listens != 0) == listening) found.push_back(descriptor);
  }
  ::closedir(open);
  return found;
}

}  // namespace haptic
