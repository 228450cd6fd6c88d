#include "spidar_driver/authority/judged_subscription.h"

#include <ros/console.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <ros/topic_manager.h>
#include <ros/transport/transport_udp.h>
#include <ros/xmlrpc_manager.h>
#include <xmlrpcpp/XmlRpc.h>

#include <algorithm>
#include <boost/make_shared.hpp>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

using XmlRpc::XmlRpcValue;

std::string uriOf(const std::string& address, std::uint32_t port) { return "http://" + address + ":" + std::to_string(port) + "/"; }

}  // namespace

/// Asks a publisher's node where its messages come from, and connects there if that machine, too, may command.
class JudgedSubscription::Inquiry : public ros::Subscription::PendingConnection {
 public:
  Inquiry(ProcessDoor& door, XmlRpc::XmlRpcClient* client, const ros::SubscriptionPtr& subscription, const std::string& uri,
          std::shared_ptr<Asked> asked)
      : PendingConnection(client, ros::TransportUDPPtr(), subscription, uri),
        door_(door),
        subscription_(subscription),
        asked_(std::move(asked)) {}

  bool check() override {
    const ros::SubscriptionPtr subscription = subscription_.lock();
    if (subscription && !answered_ && !getClient()->executeCheckDone(answer_)) return false;
    answered_ = true;
    const auto addresses = subscription ? hostOf(answer_) : std::vector<std::string>();
    if (!addresses) return false;
    const std::string address = door_.commanders().allowedAmong(*addresses);
    if (!address.empty()) {
      answer_[2][1] = address;  // the one that was judged
      subscription->pendingConnectionDone(boost::dynamic_pointer_cast<PendingConnection>(shared_from_this()), answer_);
    }
    const std::lock_guard<std::mutex> lock(asked_->mutex);
    asked_->uris.erase(getRemoteURI());
    return true;
  }

 private:
  /// Of [1, text, ["TCPROS", host, port]]; none: its name is being looked up.
  std::optional<std::vector<std::string>> hostOf(XmlRpcValue& answer) const {
    const std::vector<std::string> nobody;
    if (answer.getType() != XmlRpcValue::TypeArray || answer.size() != 3) return nobody;
    XmlRpcValue& way = answer[2];
    if (way.getType() != XmlRpcValue::TypeArray || way.size() != 3 || way[1].getType() != XmlRpcValue::TypeString) return nobody;
    return door_.names().addressesOf(way[1]);  // it is asked again at the thread's next turn
  }

  ProcessDoor& door_;
  XmlRpcValue answer_;
  bool answered_ = false;
  boost::weak_ptr<ros::Subscription> subscription_;
  std::shared_ptr<Asked> asked_;
};

JudgedSubscription::JudgedSubscription(ProcessDoor& door, ros::NodeHandle& nh, ros::SubscribeOptions options)
    : door_(door),
      topic_(nh.resolveName(options.topic)),
      helper_(options.helper),
      subscription_(boost::make_shared<ros::Subscription>(topic_, options.md5sum, options.datatype, options.transport_hints)) {
  ros::CallbackQueueInterface* queue = options.callback_queue ? options.callback_queue : nh.getCallbackQueue();
  subscription_->addCallback(helper_, options.md5sum, queue, static_cast<std::int32_t>(options.queue_size), options.tracked_object,
                             options.allow_concurrent_callbacks);
  door_.add(*this);
  XmlRpcValue request, response, payload;
  request[0] = ros::this_node::getName();
  request[1] = topic_;
  request[2] = options.datatype;
  request[3] = ros::XMLRPCManager::instance()->getServerURI();
  if (!ros::master::execute("registerSubscriber", request, response, payload, true)) {
    door_.remove(*this);
    throw SetupError(topic_, "cannot be subscribed: the master does not answer", "start it, and this again");
  }
  std::vector<std::string> publishers;
  for (int i = 0; i < payload.size(); ++i) publishers.push_back(payload[i]);
  door_.announce(topic_, publishers);
}

JudgedSubscription::~JudgedSubscription() {
  door_.remove(*this);
  subscription_->removeCallback(helper_);
  subscription_->shutdown();
  std::vector<std::string> others;
  ros::TopicManager::instance()->getSubscribedTopics(others);
  if (std::find(others.begin(), others.end(), topic_) != others.end()) return;
  // Also when this process ends: the master would list its node for ever. roscpp asks once then, as it does for its own.
  XmlRpcValue request, response, payload;
  request[0] = ros::this_node::getName();
  request[1] = topic_;
  request[2] = ros::XMLRPCManager::instance()->getServerURI();
  ros::master::execute("unregisterSubscriber", request, response, payload, false);
}

std::set<std::string> JudgedSubscription::connected() const {
  XmlRpcValue links;  // [id, publisher's URI, ...] of each
  links.setSize(0);
  subscription_->getInfo(links);
  std::set<std::string> uris;
  for (int i = 0; i < links.size(); ++i) uris.insert(links[i][1]);
  return uris;
}

void JudgedSubscription::announce(const std::vector<std::string>& publishers) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::set<std::string> connected = this->connected();
  std::vector<std::string> kept;
  for (const std::string& publisher : publishers) {
    std::string host;
    std::uint32_t port = 0;
    if (!ros::network::splitURI(publisher, host, port)) continue;
    const auto addresses = door_.names().addressesOf(host);
    const std::string address = addresses ? door_.commanders().allowedAmong(*addresses) : std::string();
    const std::string uri = uriOf(address, port);
    if (address.empty()) {
      ROS_WARN_STREAM_THROTTLE(1.0, topic_ << " refused: " << Commanders::refusal("a publisher of it is", host));
    } else if (connected.count(uri) > 0) {
      kept.push_back(uri);
    } else {
      ask(address, port, uri);
    }
  }
  subscription_->pubUpdate(kept);
}

void JudgedSubscription::ask(const std::string& address, std::uint32_t port, const std::string& uri) {
  {
    const std::lock_guard<std::mutex> lock(asked_->mutex);
    if (!asked_->uris.insert(uri).second) return;
  }
  XmlRpcValue request;
  request[0] = ros::this_node::getName();
  request[1] = topic_;
  request[2][0][0] = std::string("TCPROS");
  auto* client = new XmlRpc::XmlRpcClient(address.c_str(), static_cast<int>(port), "/");  // the inquiry's
  const auto inquiry = boost::make_shared<Inquiry>(door_, client, subscription_, uri, asked_);
  if (client->executeNonBlock("requestTopic", request)) {
    ros::XMLRPCManager::instance()->addASyncConnection(inquiry);
    return;
  }
  const std::lock_guard<std::mutex> lock(asked_->mutex);
  asked_->uris.erase(uri);
}

}  // namespace haptic
