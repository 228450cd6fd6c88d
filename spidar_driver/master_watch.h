/// Tells a new master what the old one knew of this node. roscpp registers once and never looks again.
#pragma once
#include <condition_variable>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace haptic {

/// Asks the master once a second what it knows of this node; of a whole manager, its nodelets' services and topics. A master
/// that knows nothing while another one did is a new one. Needs no answer while there is none.
class MasterWatch {
 public:
  MasterWatch();  ///< asks once, so that a master that dies at once is not the last that knew this node
  ~MasterWatch();

 private:
  /// Names of this node's services, and of its topics with their types.
  struct Known {
    std::vector<std::string> services;
    std::map<std::string, std::string> published, subscribed;
    int master = 0;  ///< its process
    bool empty() const { return services.empty() && published.empty() && subscribed.empty(); }
  };
  void run();
  void look();
  static bool ask(Known& known);
  void tell() const;

  Known known_;
  std::mutex mutex_;
  std::condition_variable signal_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace haptic
