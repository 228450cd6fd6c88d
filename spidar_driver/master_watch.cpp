#include "spidar_driver/master_watch.h"

#include <ros/connection_manager.h>
#include <ros/console.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <ros/xmlrpc_manager.h>
#include <xmlrpcpp/XmlRpc.h>

#include <chrono>

namespace haptic {
namespace {

using XmlRpc::XmlRpcValue;

constexpr std::chrono::seconds kLookEvery{1};

/// One call of the master's; what it takes beside the caller's name. Does not wait for a master.
bool call(const char* method, const std::vector<std::string>& arguments, XmlRpcValue& payload) {
  XmlRpcValue request, response;
  request[0] = ros::this_node::getName();
  for (std::size_t i = 0; i < arguments.size(); ++i) request[static_cast<int>(i + 1)] = arguments[i];
  return ros::master::execute(method, request, response, payload, false);
}

/// The names of a list [[name, [node, ...]], ...] of which this node is one.
std::vector<std::string> ownNames(XmlRpcValue& list) {
  std::vector<std::string> names;
  for (int i = 0; i < list.size(); ++i)
    for (int k = 0; k < list[i][1].size(); ++k)
      if (static_cast<std::string>(list[i][1][k]) == ros::this_node::getName())
        names.push_back(static_cast<std::string>(list[i][0]));
  return names;
}

/// As the master would say it, through the port that it would call: whoever judges publishers judges these.
void announce(const std::string& topic, const XmlRpcValue& publishers) {
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(ros::XMLRPCManager::instance()->getServerURI(), host, port)) return;
  XmlRpcValue request, response;
  request[0] = "/master";
  request[1] = topic;
  request[2] = publishers;
  XmlRpc::XmlRpcClient(host.c_str(), static_cast<int>(port), "/").execute("publisherUpdate", request, response);
}

}  // namespace

MasterWatch::MasterWatch() {
  look();
  thread_ = std::thread([this] { run(); });
}

MasterWatch::~MasterWatch() {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  signal_.notify_all();
  thread_.join();
}

bool MasterWatch::ask(Known& known) {
  XmlRpcValue state, types;
  XmlRpcValue process;
  if (!call("getPid", {}, process) || !call("getSystemState", {}, state) || !call("getTopicTypes", {}, types)) return false;
  known.master = static_cast<int>(process);
  std::map<std::string, std::string> type;
  for (int i = 0; i < types.size(); ++i) type[static_cast<std::string>(types[i][0])] = static_cast<std::string>(types[i][1]);
  for (const std::string& topic : ownNames(state[0])) known.published[topic] = type[topic];
  for (const std::string& topic : ownNames(state[1])) known.subscribed[topic] = type[topic];
  known.services = ownNames(state[2]);
  return true;
}

void MasterWatch::tell() const {
  const std::string node = ros::XMLRPCManager::instance()->getServerURI();
  const std::string services =
      "rosrpc://" + ros::network::getHost() + ":" + std::to_string(ros::ConnectionManager::instance()->getTCPPort());
  XmlRpcValue payload;
  for (const std::string& service : known_.services) call("registerService", {service, services, node}, payload);
  for (const auto& [topic, type] : known_.published) call("registerPublisher", {topic, type, node}, payload);
  for (const auto& [topic, type] : known_.subscribed)
    if (call("registerSubscriber", {topic, type, node}, payload)) announce(topic, payload);
  ROS_WARN("a new master: %zu services and %zu topics are registered again", known_.services.size(),
           known_.published.size() + known_.subscribed.size());
}

void MasterWatch::look() {
  Known now;
  try {
    if (!ask(now)) return;
  } catch (const XmlRpc::XmlRpcException& error) {
    ROS_WARN_STREAM_THROTTLE(60, "the master answers what no master does: " << error.getMessage());
    return;
  }
  // Processes of two containers may have one number: a master that knows nothing is a new one as well.
  const bool other = now.master != known_.master || now.empty();
  if (other && !known_.empty()) tell();
  if (!other || known_.empty()) known_ = now;
  known_.master = now.master;
}

void MasterWatch::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!signal_.wait_for(lock, kLookEvery, [this] { return stop_; })) {
    lock.unlock();
    look();
    lock.lock();
  }
}

}  // namespace haptic
