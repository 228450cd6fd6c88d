/// STOP that needs no master, no node and no network: a socket per device in a folder of the user's, and a signal.
///
/// Whoever connects to the socket says STOP; the answer is one line, then the socket closes. SIGUSR1 to the process stops all of
/// its devices and has no answer. The folder is the user's alone (mode 0700), so other users cannot stop, nor stand in the way.
#pragma once
#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace haptic {

/// What became of a STOP.
struct StopAnswer {
  bool off = false;     ///< the motors have no current
  std::string message;  ///< one line for the user
};

/// A device's ear for STOP, in a thread of its own.
class StopListener {
 public:
  /// `device`: name of the device. `stop` is called in the listener's thread for every STOP. Throws SetupError when there can
  /// be no socket.
  StopListener(const std::string& device, std::function<StopAnswer()> stop);
  ~StopListener();  ///< waits for the answer that is under way
  StopListener(const StopListener&) = delete;
  StopListener& operator=(const StopListener&) = delete;

  const std::string& path() const { return path_; }  ///< of the socket

 private:
  void run();
  void answer(int connection) const;

  std::function<StopAnswer()> stop_;
  std::string path_;
  int socket_ = -1, wake_ = -1;  ///< wake_: an eventfd; 1 is a signal's STOP, kEnd the end
  std::thread thread_;
};

/// Where a user's devices listen: the environment's HAPTIC_STOP_FOLDER, else a place that is the same in every shell.
std::string stopFolder();
/// Sockets of the devices of this user on this machine: all, or those of this name. Root gets every user's.
std::vector<std::string> stopSockets(const std::string& device = "");

/// One device that was told.
struct Stopped {
  std::string socket;  ///< its path: FOLDER/DEVICE.PROCESS.stop
  /// Its answer; without one within the patience, `off` is false and the message says so.
  StopAnswer answer;
};
/// Says STOP to all of them at once and waits for their answers, at most `patience`. A socket without a listener is left out:
/// its process has ended. Never throws.
std::vector<Stopped> sayStop(const std::vector<std::string>& sockets, std::chrono::milliseconds patience);

}  // namespace haptic
