/// What takes its time is never silent for long.
#pragma once
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace haptic {

/// Passes lines on, and where none comes for kSilence says what goes on and for how long: "certificate: 4 s". For set-up, from any thread;
/// one line at a time. Its own thread ends with it.
class ProgressWatch {
 public:
  /// `tell` gets the lines, from the caller's threads and from this object's. `stage`: what begins.
  ProgressWatch(std::function<void(const std::string&)> tell, std::string stage);
  ~ProgressWatch();
  ProgressWatch(const ProgressWatch&) = delete;
  ProgressWatch& operator=(const ProgressWatch&) = delete;

  void stage(std::string what);        ///< something else begins
  void tell(const std::string& line);  ///< passes it on

  static constexpr std::chrono::milliseconds kSilence{2000};  ///< an eye waits 3 s before it doubts

 private:
  using Clock = std::chrono::steady_clock;
  void run();

  std::function<void(const std::string&)> tell_;
  std::string stage_;
  Clock::time_point began_ = Clock::now(), told_ = began_;
  bool ends_ = false;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::thread thread_;
};

}  // namespace haptic
