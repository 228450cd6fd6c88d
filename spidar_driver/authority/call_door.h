/// Connections to a node's XML-RPC port, judged when they are accepted, before a byte of them is read.
///
/// The library reads what comes until nothing comes, and carries requests of up to 2 GB. Here the far end's address decides how much is
/// read for it: of a machine that may command a request of 1 MB, of another what a question about topics needs, and of few of them at once.
/// A longer request ends the connection as soon as its length is known, and one that finds no room beside those of all others.
/// What is carried out, and for whom, decides NodeCalls.
#pragma once
#include <xmlrpcpp/XmlRpc.h>
#include <xmlrpcpp/XmlRpcSource.h>

#include <cstddef>
#include <list>
#include <string>
#include <vector>

namespace haptic {

class Commanders;

/// What a dispatcher of the library watches.
std::vector<XmlRpc::XmlRpcSource*> sourcesOf(const XmlRpc::XmlRpcDispatch& dispatch);

/// Accepts in the place of roscpp's server, in its thread. Connections that were there before are cut; their callers connect anew.
class CallDoor : public XmlRpc::XmlRpcSource {
 public:
  /// Takes over `server`, which is among the sources of `dispatch`. All three live as long as the process.
  CallDoor(XmlRpc::XmlRpcServer& server, XmlRpc::XmlRpcDispatch& dispatch, const Commanders& commanders);

  /// Address of the connection whose method runs now; empty: none. In the server's thread.
  const std::string& caller() const { return caller_; }

  unsigned handleEvent(unsigned event) override;

 private:
  class Connection;
  XmlRpc::XmlRpcServer& server_;
  XmlRpc::XmlRpcDispatch& dispatch_;
  const Commanders& commanders_;
  std::list<Connection*> strangers_;  ///< oldest first
  std::size_t held_ = 0;  ///< of requests that have come in part [byte]
  std::string caller_;
};

}  // namespace haptic
