/// The door of a process that moves motors: every call from another machine is judged before anything in the process sees it.
///
/// ROS 1 has no identities, and roscpp tells a callback no address. So this stands before roscpp's two ports:
/// - calls of the node's own interface (XML-RPC): `shutdown`, `publisherUpdate`, `paramUpdate` and all that do more than tell
///   about the node are carried out for machines that may command only (Commanders), and little is read for others (CallDoor);
/// - connections (TCPROS): a service call of whichever nodelet of the process (the manager's load and unload included) is
///   answered with a reason and no more, unless its machine may command or the service is open to all. Who subscribes, looks:
///   that is open. A connection that announces a header of more than 256 kB is cut.
/// An address is the one that the kernel knows of the connection. Where it knows none, the answer is no.
/// Topics that command are heard through JudgedSubscription.
#pragma once
#include <ros/datatypes.h>

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "spidar_driver/authority/commanders.h"
#include "spidar_driver/authority/host_names.h"

namespace haptic {

class JudgedSubscription;

class ProcessDoor {
 public:
  /// Stands before roscpp's ports from the first call on until the process ends. Needs a started node; not from a thread of
  /// roscpp. Throws SetupError when it cannot, or when the machine's file is wrong.
  static ProcessDoor& ofProcess();

  const Commanders& commanders() const { return commanders_; }
  /// Calls of this service (full name) reach its callback from everywhere; it judges for itself by refuse().
  void openToAll(const std::string& service);
  /// Why a service call with this connection header must not act; empty: it may.
  std::string refuse(const ros::M_string& connection_header) const;

  /// Publishers of a topic are told to `subscription` until it is removed.
  void add(JudgedSubscription& subscription);
  void remove(JudgedSubscription& subscription);

  // For the two ports.
  bool isOpen(const std::string& service) const;
  bool mayAnnounce(const std::string& address) const;  ///< publishers and parameters: the master's machine as well
  /// These publish the topic now, by URI of their nodes: told at one of the next turns of roscpp's thread of calls.
  void announce(const std::string& topic, const std::vector<std::string>& publishers);
  using RoscppUpdate = std::function<void(const std::string& topic, const std::vector<std::string>& publishers)>;
  /// Tells what was announced and has publishers whose hosts' names are known by now: roscpp's subscriptions by `update`, and judged ones.
  void tellAnnounced(const RoscppUpdate& update);
  HostNames& names() { return names_; }

 private:
  ProcessDoor();
  std::optional<std::vector<std::string>> withKnownHosts(const std::string& topic, const std::vector<std::string>& publishers);

  const Commanders commanders_;
  std::vector<std::string> master_;
  mutable std::mutex mutex_;
  std::set<std::string> open_;
  HostNames names_;
  std::mutex subscriptions_mutex_;
  std::map<std::string, std::vector<std::string>> announced_;  ///< by topic, not told yet
  std::set<JudgedSubscription*> subscriptions_;
};

}  // namespace haptic
