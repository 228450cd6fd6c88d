#include "spidar_driver/authority/node_calls.h"

#include <ros/console.h>
#include <ros/init.h>
#include <xmlrpcpp/XmlRpc.h>

#include <algorithm>
#include <string>

namespace haptic {
namespace {

using XmlRpc::XmlRpcValue;

/// Tell about the node and change nothing; whoever looks at topics needs them.
const std::set<std::string> kTelling{"getBusInfo", "getBusStats", "getMasterUri", "getName",
                                     "getPid", "getPublications", "getSubscriptions", "requestTopic"};
/// The master's part: who publishes, and that a parameter has changed.
constexpr char kUpdate[] = "publisherUpdate";
const std::set<std::string> kAnnouncing{kUpdate, "paramUpdate"};

}  // namespace

/// Stands in the server under a method's name and passes on what may pass.
class NodeCalls::JudgedMethod : public XmlRpc::XmlRpcServerMethod {
 public:
  /// `method` is roscpp's; null: nothing passes.
  JudgedMethod(const std::string& name, ProcessDoor& door, const CallDoor& calls, XmlRpc::XmlRpcServerMethod* method)
      : XmlRpcServerMethod(name), name_(name), door_(door), calls_(calls), method_(method) {}

  void execute(XmlRpcValue& parameters, XmlRpcValue& result) override {
    const std::string& caller = calls_.caller();
    const bool may = door_.commanders().allows(caller) || (kAnnouncing.count(name_) > 0 && door_.mayAnnounce(caller));
    if (!may || !method_) {
      const std::string why = method_ ? Commanders::refusal("the call " + name_, caller) : name_ + " is not offered";
      ROS_WARN_STREAM_THROTTLE(1.0, "refused " << why);
      result[0] = -1;
      result[1] = why;
      result[2] = 0;
      return;
    }
    if (name_ != kUpdate) return method_->execute(parameters, result);
    announce(parameters);
    result = ros::xmlrpc::responseInt(1, "", 0);
  }

 private:
  /// [caller, topic, [publisher's URI, ...]]: roscpp and ours hear of publishers once the names of their hosts are known. Both would
  /// look them up here, and answer no other call until a name server has answered or kept silent.
  void announce(XmlRpcValue& parameters) {
    if (parameters.getType() != XmlRpcValue::TypeArray || parameters.size() < 3) {
      throw XmlRpc::XmlRpcException(name_ + ": has three arguments");
    }
    const std::string topic = parameters[1];
    std::vector<std::string> publishers;
    for (int i = 0; i < parameters[2].size(); ++i) publishers.push_back(parameters[2][i]);
    door_.announce(topic, publishers);
  }

  const std::string name_;
  ProcessDoor& door_;
  const CallDoor& calls_;
  XmlRpc::XmlRpcServerMethod* method_;
};

NodeCalls::NodeCalls(ProcessDoor& door) : door_(door) {}
NodeCalls::~NodeCalls() = default;

/// At every turn of the thread, ten times a second and more; never done. A node that ends has taken its methods away before its thread.
bool NodeCalls::check() {
  if (update_ && !ros::isShuttingDown()) tellAnnounced();
  return false;
}

void NodeCalls::tellAnnounced() {
  door_.tellAnnounced([this](const std::string& topic, const std::vector<std::string>& publishers) {
    XmlRpcValue parameters, result;
    parameters[0] = std::string("/master");
    parameters[1] = topic;
    parameters[2].setSize(static_cast<int>(publishers.size()));
    for (std::size_t i = 0; i < publishers.size(); ++i) parameters[2][static_cast<int>(i)] = publishers[i];
    update_->execute(parameters, result);
  });
}

void NodeCalls::addToDispatch(XmlRpc::XmlRpcDispatch* dispatch) {
  XmlRpc::XmlRpcServer* server = nullptr;
  for (XmlRpc::XmlRpcSource* source : sourcesOf(*dispatch)) {
    if (auto* s = dynamic_cast<XmlRpc::XmlRpcServer*>(source)) server = s;
  }
  if (!server || !server->findMethod(kUpdate)) return standing_.set_value(false);
  calls_ = std::make_unique<CallDoor>(*server, *dispatch, door_.commanders());
  update_ = server->findMethod(kUpdate);
  XmlRpcValue names;
  server->listMethods(names);
  for (int i = 0; i < names.size(); ++i) {
    const std::string name = names[i];
    if (kTelling.count(name) > 0) continue;
    methods_.push_back(std::make_unique<JudgedMethod>(name, door_, *calls_, server->findMethod(name)));
  }
  // The library carries out a call of this name within itself without end, until the process has no stack left.
  methods_.push_back(std::make_unique<JudgedMethod>("system.multicall", door_, *calls_, nullptr));
  for (const auto& method : methods_) server->addMethod(method.get());
  standing_.set_value(true);
}

}  // namespace haptic
