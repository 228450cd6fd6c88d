/// Internet addresses as numeric text, and the far ends of sockets.
#pragma once
#include <sys/socket.h>

#include <cstdint>
#include <string>
#include <vector>

namespace haptic {

/// Numeric text of an address; an IPv4 address inside IPv6 as IPv4. Empty: of no internet family.
std::string addressText(const sockaddr* address);
/// `text` is a numeric IPv4 or IPv6 address.
bool isAddress(const std::string& text);
/// `address` belongs to this machine (or network namespace). The kernel drops packets from elsewhere that bear it.
bool isOwnAddress(const std::string& address);
/// Every address that a host's name or number stands for; may ask a name server.
std::vector<std::string> addressesOf(const std::string& host);
/// Address of the far end of a connected socket; empty: it is gone, or was never known.
std::string peerAddress(int socket);
/// Sockets of this process with this local TCP port: those that listen, or those that are connected.
std::vector<int> socketsAt(std::uint32_t port, bool listening);

}  // namespace haptic
