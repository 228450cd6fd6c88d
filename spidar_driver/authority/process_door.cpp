#include "spidar_driver/authority/process_door.h"

#include <fcntl.h>
#include <poll.h>
#include <ros/connection.h>
#include <ros/connection_manager.h>
#include <ros/console.h>
#include <ros/init.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/poll_manager.h>
#include <ros/service_client_link.h>
#include <ros/transport/transport_tcp.h>
#include <ros/transport_subscriber_link.h>
#include <ros/xmlrpc_manager.h>

#include <algorithm>
#include <cerrno>
#include <boost/make_shared.hpp>
#include <chrono>
#include <cstdlib>
#include <future>

#include "haptic_core/base/error.h"
#include "spidar_driver/authority/addresses.h"
#include "spidar_driver/authority/judged_subscription.h"
#include "spidar_driver/authority/node_calls.h"

namespace haptic {
namespace {

/// Key of a connection header under which the door writes the address that it has seen; what a caller wrote there is lost.
constexpr char kSeenAddress[] = "seen_address";
/// roscpp's threads turn every 0.1 s; on a busy machine some tens of that.
constexpr std::chrono::seconds kPatience{10};
constexpr std::size_t kShown = 64;  // of a host's name in a message [byte]
/// Longest header of a connection [byte]. The longest of a sound one holds the definition of a message, some ten thousand.
constexpr std::uint32_t kLongestHeader = 1 << 18;

/// roscpp says of a connection: "... [host:port on socket 17]". -1: it says nothing.
int socketOf(ros::TransportTCP& transport) {
  const std::string told = transport.getTransportInfo();
  const std::size_t at = told.rfind("on socket ");
  return at == std::string::npos ? -1 : std::atoi(told.c_str() + at + 10);
}

/// Decides what a connection becomes, as roscpp does, and whether it may.
bool admit(ProcessDoor& door, const ros::ConnectionPtr& connection, const ros::Header& header, const std::string& peer) {
  std::string name;
  if (header.getValue("topic", name)) {
    const auto link = boost::make_shared<ros::TransportSubscriberLink>();
    link->initialize(connection);
    return link->handleHeader(header);
  }
  if (!header.getValue("service", name)) return false;
  (*connection->getHeader().getValues())[kSeenAddress] = peer;
  if (!door.commanders().allows(peer) && !door.isOpen(name)) {
    const std::string why = Commanders::refusal("a call of " + name, peer);
    ROS_WARN_STREAM_THROTTLE(1.0, "refused " << why);
    connection->sendHeaderError(why);
    return false;
  }
  const auto link = boost::make_shared<ros::ServiceClientLink>();
  link->initialize(connection);
  return link->handleHeader(header);
}

/// Gives a connection to roscpp.
void begin(ProcessDoor& door, const ros::TransportTCPPtr& transport, const std::string& peer) {
  const auto connection = boost::make_shared<ros::Connection>();
  ros::ConnectionManager::instance()->addConnection(connection);
  connection->initialize(transport, true, [&door, peer](const ros::ConnectionPtr& c, const ros::Header& header) {
    return admit(door, c, header, peer);
  });
}

/// A connection has sent something. roscpp makes room for as much as the first four bytes tell, up to 1 GB: they are looked at before.
void judgeHeader(ProcessDoor& door, const ros::TransportTCPPtr& transport, int socket, const std::string& peer) {
  unsigned char told[4];
  const ssize_t got = ::recv(socket, told, sizeof told, MSG_PEEK | MSG_DONTWAIT);
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) return;
  const std::uint32_t size = got < 4 ? 0 : told[0] | told[1] << 8 | told[2] << 16 | static_cast<std::uint32_t>(told[3]) << 24;
  if (got < 4 || size > kLongestHeader) {
    if (got == 4) ROS_WARN_STREAM_THROTTLE(1.0, "refused: a connection from " << peer << " begins with a header of " << size << " bytes");
    transport->close();
    return;
  }
  const int one = 1;
  ::setsockopt(socket, SOL_SOCKET, SO_RCVLOWAT, &one, sizeof one);
  transport->disableRead();
  begin(door, transport, peer);
}

void acceptOne(ProcessDoor& door, const ros::TransportTCPPtr& server) {
  if (ros::isShuttingDown()) return;
  const ros::TransportTCPPtr transport = server->accept();
  if (!transport) return;
  const int socket = socketOf(*transport), header = 4;
  const std::string peer = socket < 0 ? std::string() : peerAddress(socket);
  ::setsockopt(socket, SOL_SOCKET, SO_RCVLOWAT, &header, sizeof header);  // readable once there is all of the length, or the end
  transport->setReadCallback([&door, socket, peer](const ros::TransportPtr& readable) {
    // Copies: roscpp takes this function's place, and with it what it holds.
    ProcessDoor& its_door = door;
    const int its_socket = socket;
    const std::string its_peer = peer;
    judgeHeader(its_door, boost::static_pointer_cast<ros::TransportTCP>(readable), its_socket, its_peer);
  });
  transport->enableRead();
}

/// Accepts connections in roscpp's place, and cuts those that strangers made before. In the poll thread: nothing is accepted
/// or read meanwhile.
bool takeConnections(ProcessDoor& door) {
  const ros::TransportTCPPtr server = ros::ConnectionManager::instance()->getTCPServerTransport();
  const auto port = static_cast<std::uint32_t>(server->getServerPort());
  const std::vector<int> listening = socketsAt(port, true);
  if (listening.empty()) return false;
  const int mine = ::fcntl(listening.front(), F_DUPFD_CLOEXEC, 0);
  ros::PollSet& sockets = ros::PollManager::instance()->getPollSet();
  if (mine < 0 || !sockets.addSocket(mine, [&door, server](int events) {
        if (events & POLLIN) acceptOne(door, server);
      })) {
    return false;
  }
  server->disableRead();
  sockets.addEvents(mine, POLLIN);
  for (const int connected : socketsAt(port, false)) {
    if (!door.commanders().allows(peerAddress(connected))) ::shutdown(connected, SHUT_RDWR);
  }
  return true;
}

/// Runs `takeConnections` once in roscpp's poll thread.
bool takeConnectionsThere(ProcessDoor& door) {
  const auto& poll = ros::PollManager::instance();
  const auto done = std::make_shared<std::promise<bool>>();
  const auto once = std::make_shared<bool>(true);
  boost::signals2::connection listener = poll->addPollThreadListener([&door, done, once] {
    if (!*once) return;
    *once = false;
    done->set_value(takeConnections(door));
  });
  std::future<bool> result = done->get_future();
  const bool came = result.wait_for(kPatience) == std::future_status::ready;
  poll->removePollThreadListener(listener);
  return came && result.get();
}

}  // namespace

ProcessDoor& ProcessDoor::ofProcess() {
  static std::mutex mutex;
  static ProcessDoor* door = nullptr;  // roscpp's threads use it until the process ends
  const std::lock_guard<std::mutex> lock(mutex);
  if (door) return *door;
  auto* made = new ProcessDoor;  // kept even if it does not stand: roscpp may know it already
  const auto calls = boost::make_shared<NodeCalls>(*made);
  std::future<bool> standing = calls->standing();
  ros::XMLRPCManager::instance()->addASyncConnection(calls);
  if (!takeConnectionsThere(*made) || standing.wait_for(kPatience) != std::future_status::ready || !standing.get()) {
    throw SetupError("the node", "takes calls that cannot be judged", "build the driver with the roscpp that it runs with");
  }
  static const boost::shared_ptr<NodeCalls>* const kept = new boost::shared_ptr<NodeCalls>(calls);
  static_cast<void>(kept);
  return *(door = made);
}

ProcessDoor::ProcessDoor() : commanders_(Commanders::ofMachine()), master_(addressesOf(ros::master::getHost())) {}

bool ProcessDoor::mayAnnounce(const std::string& address) const {
  return std::find(master_.begin(), master_.end(), address) != master_.end() && !address.empty();
}

void ProcessDoor::openToAll(const std::string& service) {
  const std::lock_guard<std::mutex> lock(mutex_);
  open_.insert(service);
}

bool ProcessDoor::isOpen(const std::string& service) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return open_.count(service) > 0;
}

std::string ProcessDoor::refuse(const ros::M_string& connection_header) const {
  const auto seen = connection_header.find(kSeenAddress);
  const std::string address = seen == connection_header.end() ? std::string() : seen->second;
  return commanders_.allows(address) ? std::string() : Commanders::refusal("the caller is", address);
}

void ProcessDoor::add(JudgedSubscription& subscription) {
  const std::lock_guard<std::mutex> lock(subscriptions_mutex_);
  subscriptions_.insert(&subscription);
}

void ProcessDoor::remove(JudgedSubscription& subscription) {
  const std::lock_guard<std::mutex> lock(subscriptions_mutex_);
  subscriptions_.erase(&subscription);
}

void ProcessDoor::announce(const std::string& topic, const std::vector<std::string>& publishers) {
  const std::lock_guard<std::mutex> lock(subscriptions_mutex_);
  announced_[topic] = publishers;
}

/// None: a name is being looked up. Who is missing from a list is let go of, so the list waits for its last name.
std::optional<std::vector<std::string>> ProcessDoor::withKnownHosts(const std::string& topic, const std::vector<std::string>& publishers) {
  std::vector<std::string> known;
  bool all = true;
  for (const std::string& publisher : publishers) {
    std::string host;
    std::uint32_t port = 0;
    if (!ros::network::splitURI(publisher, host, port)) continue;
    const auto addresses = names_.addressesOf(host);
    all = all && addresses;
    if (addresses && addresses->empty()) {
      ROS_WARN_STREAM_THROTTLE(1.0, topic << ": a publisher's host, '" << host.substr(0, kShown) << "', is unknown; it is not heard");
    } else {
      known.push_back(publisher);
    }
  }
  if (!all) return std::nullopt;
  return known;
}

void ProcessDoor::tellAnnounced(const RoscppUpdate& update) {
  const std::lock_guard<std::mutex> lock(subscriptions_mutex_);
  for (auto next = announced_.begin(); next != announced_.end();) {
    const auto announced = next++;
    const std::string topic = announced->first;
    const auto known = withKnownHosts(topic, announced->second);
    if (!known) continue;
    announced_.erase(announced);
    update(topic, *known);
    for (JudgedSubscription* subscription : subscriptions_) {
      if (subscription->topic() == topic) subscription->announce(*known);
    }
  }
}

}  // namespace haptic
