/// Addresses of hosts by name, for threads that must not wait: a name server that keeps silent is waited for up to a minute.
#pragma once
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace haptic {

/// Lives as long as the process: look-ups run in threads of their own, which nobody joins.
class HostNames {
 public:
  /// All that `host` stands for, from its number or a look-up of lately; empty: there is no such host. None: it is being looked up, ask
  /// again.
  std::optional<std::vector<std::string>> addressesOf(const std::string& host);

 private:
  struct Name {
    std::vector<std::string> addresses;
    std::chrono::steady_clock::time_point good_until;
    bool asking = false;
  };
  void lookUp(const std::string& host);

  std::mutex mutex_;
  std::map<std::string, Name> names_;
  int asking_ = 0;
};

}  // namespace haptic
