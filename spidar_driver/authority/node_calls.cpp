#include "spidar_driver/authority/node_calls.h"

#include <ros/console.h>
#include <xmlrpcpp/XmlRpc.h>
#include <xmlrpcpp/XmlRpcServerConnection.h>

#include <algorithm>
#include <string>

#include "spidar_driver/authority/addresses.h"

namespace haptic {
namespace {

using XmlRpc::XmlRpcValue;

/// Tell about the node and change nothing; whoever looks at topics needs them.
const std::set<std::string> kTelling{"getBusInfo", "getBusStats", "getMasterUri", "getName",
                                     "getPid", "getPublications", "getSubscriptions", "requestTopic"};
/// The master's part: who publishes, and that a parameter has changed.
const std::set<std::string> kAnnouncing{"publisherUpdate", "paramUpdate"};

/// What the library keeps for those who derive from its classes.
struct Sources : XmlRpc::XmlRpcDispatch {
  static const SourceList& of(const XmlRpc::XmlRpcDispatch& dispatch) { return dispatch.*(&Sources::_sources); }
};
struct Caller : XmlRpc::XmlRpcServerConnection {
  /// The request has been read, and no response is made yet: at most one connection of a server, whose method runs now.
  static bool waits(const XmlRpc::XmlRpcServerConnection& c) {
    return c.*(&Caller::_connectionState) == WRITE_RESPONSE && (c.*(&Caller::_response)).empty();
  }
};

/// Address of the connection whose method runs now; empty: none or several, or it is gone. In the server's thread.
std::string callerOf(const XmlRpc::XmlRpcDispatch& dispatch) {
  const XmlRpc::XmlRpcServerConnection* caller = nullptr;
  for (const auto& monitored : Sources::of(dispatch)) {
    const auto* c = dynamic_cast<const XmlRpc::XmlRpcServerConnection*>(monitored._src);
    if (!c || !Caller::waits(*c)) continue;
    if (caller) return {};
    caller = c;
  }
  return caller ? peerAddress(caller->getfd()) : std::string();
}

}  // namespace

/// Stands in the server under a method's name and passes on what may pass.
class NodeCalls::JudgedMethod : public XmlRpc::XmlRpcServerMethod {
 public:
  /// `method` is roscpp's; null: nothing passes.
  JudgedMethod(const std::string& name, ProcessDoor& door, const XmlRpc::XmlRpcDispatch& dispatch, XmlRpc::XmlRpcServerMethod* method)
      : XmlRpcServerMethod(name), name_(name), door_(door), dispatch_(dispatch), method_(method) {}

  void execute(XmlRpcValue& parameters, XmlRpcValue& result) override {
    const std::string caller = callerOf(dispatch_);
    const bool may = door_.commanders().allows(caller) || (kAnnouncing.count(name_) > 0 && door_.mayAnnounce(caller));
    if (!may || !method_) {
      const std::string why = method_ ? Commanders::refusal("the call " + name_, caller) : name_ + " is not offered";
      ROS_WARN_STREAM_THROTTLE(1.0, "refused " << why);
      result[0] = -1;
      result[1] = why;
      result[2] = 0;
      return;
    }
    method_->execute(parameters, result);
    if (name_ == "publisherUpdate") announce(parameters);
  }

 private:
  /// [caller, topic, [publisher's URI, ...]]
  void announce(XmlRpcValue& parameters) {
    if (parameters.getType() != XmlRpcValue::TypeArray || parameters.size() < 3) return;
    const std::string topic = parameters[1];
    std::vector<std::string> publishers;
    for (int i = 0; i < parameters[2].size(); ++i) publishers.push_back(parameters[2][i]);
    door_.announce(topic, publishers);
  }

  const std::string name_;
  ProcessDoor& door_;
  const XmlRpc::XmlRpcDispatch& dispatch_;
  XmlRpc::XmlRpcServerMethod* method_;
};

NodeCalls::NodeCalls(ProcessDoor& door) : door_(door) {}
NodeCalls::~NodeCalls() = default;

void NodeCalls::addToDispatch(XmlRpc::XmlRpcDispatch* dispatch) {
  XmlRpc::XmlRpcServer* server = nullptr;
  for (const auto& monitored : Sources::of(*dispatch)) {
    if (auto* s = dynamic_cast<XmlRpc::XmlRpcServer*>(monitored._src)) server = s;
  }
  if (!server) return standing_.set_value(false);
  XmlRpcValue names;
  server->listMethods(names);
  for (int i = 0; i < names.size(); ++i) {
    const std::string name = names[i];
    if (kTelling.count(name) > 0) continue;
    methods_.push_back(std::make_unique<JudgedMethod>(name, door_, *dispatch, server->findMethod(name)));
  }
  // The library carries out a call of this name within itself without end, until the process has no stack left.
  methods_.push_back(std::make_unique<JudgedMethod>("system.multicall", door_, *dispatch, nullptr));
  for (const auto& method : methods_) server->addMethod(method.get());
  standing_.set_value(true);
}

}  // namespace haptic
