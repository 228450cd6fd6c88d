/// Who may move motors: commands and services from this machine, and from addresses that ~allowed_addresses
/// names.
///
/// The first wall is the network: nodes listen on loopback unless ROS_IP or ROS_HOSTNAME says otherwise. This
/// is the second, for nodes that are on a network so that others can look. ROS 1 has no identities: the
/// address of a topic's publishers is read from the sockets themselves. While every connection to this node
/// comes from allowed addresses, so does every service call; else a caller's address is the one that its node
/// has registered with the master, which a caller may forge. README.md, section Security, has what follows
/// from it.
#pragma once
#include <ros/service_callback_helper.h>
#include <std_srvs/Trigger.h>

#include <mutex>
#include <string>
#include <vector>

namespace haptic {

class CommandGate {
 public:
  /// `allowed`: numeric addresses of other machines (IPv4 or IPv6). Throws SetupError for anything else.
  explicit CommandGate(const std::vector<std::string>& allowed);

  /// Why a message of `topic` (its full name) must not act; empty: it may. One publisher elsewhere closes the
  /// topic: a message does not say which connection it came by. Looks at the sockets at most every 50 ms.
  std::string refuseTopic(const std::string& topic);
  /// Why a service call of the node `caller` must not act; empty: it may.
  std::string refuseCaller(const std::string& caller) const;
  /// `address` is this machine's, or allowed.
  bool allows(const std::string& address) const;
  bool allowsAll(const std::vector<std::string>& addresses) const;

 private:
  std::vector<std::string> allowed_;
  std::mutex mutex_;
  std::string topic_, why_;  ///< last answer of refuseTopic
  double asked_ = 0;         ///< when [s], steady clock
};

using TriggerEvent = ros::ServiceEvent<std_srvs::Trigger::Request, std_srvs::Trigger::Response>;

}  // namespace haptic
