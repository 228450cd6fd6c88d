/// Calls of a node's XML-RPC interface, judged by the address of the connection that each came by.
#pragma once
#include <ros/xmlrpc_manager.h>

#include <future>
#include <memory>
#include <vector>

#include "spidar_driver/authority/call_door.h"
#include "spidar_driver/authority/process_door.h"

namespace haptic {

/// Puts a judge before the methods of roscpp's XML-RPC server, in the server's own thread.
class NodeCalls : public ros::ASyncXMLRPCConnection {
 public:
  explicit NodeCalls(ProcessDoor& door);
  ~NodeCalls() override;
  /// Becomes true when the judge stands, false when roscpp's server was not found.
  std::future<bool> standing() { return standing_.get_future(); }

  void addToDispatch(XmlRpc::XmlRpcDispatch* dispatch) override;
  void removeFromDispatch(XmlRpc::XmlRpcDispatch*) override {}
  bool check() override;

 private:
  class JudgedMethod;
  void tellAnnounced();

  ProcessDoor& door_;
  XmlRpc::XmlRpcServerMethod* update_ = nullptr;  ///< roscpp's own publisherUpdate
  std::unique_ptr<CallDoor> calls_;
  std::vector<std::unique_ptr<JudgedMethod>> methods_;
  std::promise<bool> standing_;
};

}  // namespace haptic
