/// A subscription that hears machines that may command, and no other.
///
/// roscpp connects to every publisher that it is told of, and a message does not say which connection it came by. Here each
/// publisher is judged when it is announced, by the numeric address that is then connected to; from one that was not judged
/// no connection is ever made, so no message of it can arrive, however short its life. Publishers in the same process are heard over a
/// connection as well. The rest (reconnection, deserialization, queues) is roscpp's own Subscription.
#pragma once
#include <ros/node_handle.h>
#include <ros/subscription.h>

#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "spidar_driver/authority/process_door.h"

namespace haptic {

class JudgedSubscription {
 public:
  /// `options` as for NodeHandle::subscribe; its topic is resolved by `nh`, whose queue calls back.
  JudgedSubscription(ProcessDoor& door, ros::NodeHandle& nh, ros::SubscribeOptions options);
  ~JudgedSubscription();  ///< waits for a callback that runs
  JudgedSubscription(const JudgedSubscription&) = delete;
  JudgedSubscription& operator=(const JudgedSubscription&) = delete;

  const std::string& topic() const { return topic_; }
  /// All publishers that there are now and whose hosts are known, by URI of their nodes: connects to new ones that may command, lets go
  /// of others.
  void announce(const std::vector<std::string>& publishers);

 private:
  class Inquiry;
  void ask(const std::string& address, std::uint32_t port, const std::string& uri);
  std::set<std::string> connected() const;

  ProcessDoor& door_;
  std::string topic_;
  ros::SubscriptionCallbackHelperPtr helper_;
  ros::SubscriptionPtr subscription_;
  /// URIs of inquiries under way; shared with them, as they may outlive the subscription.
  struct Asked {
    std::mutex mutex;
    std::set<std::string> uris;
  };
  std::shared_ptr<Asked> asked_ = std::make_shared<Asked>();
  std::mutex mutex_;
};

/// Subscribes a method of an object, as NodeHandle::subscribe does.
template <class Message, class T>
std::unique_ptr<JudgedSubscription> subscribeJudged(ros::NodeHandle& nh, const std::string& topic, std::uint32_t queue,
                                                    void (T::*method)(const boost::shared_ptr<const Message>&), T* object) {
  ros::SubscribeOptions options;
  options.template initByFullCallbackType<const boost::shared_ptr<const Message>&>(
      topic, queue, [object, method](const boost::shared_ptr<const Message>& message) { (object->*method)(message); });
  options.transport_hints = ros::TransportHints().tcpNoDelay();
  return std::make_unique<JudgedSubscription>(ProcessDoor::ofProcess(), nh, std::move(options));
}

}  // namespace haptic
