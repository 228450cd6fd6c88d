/// Emulated boards on a pseudo-terminal: any program that opens a serial port can drive them.
#pragma once
#include <atomic>
#include <mutex>
#include <string>
#include <thread>

#include "spidar_driver/emulator/board_bus_emulator.h"

namespace haptic {

class PtyLine {
 public:
  /// `link`: path of a symbolic link to the terminal, made now and after each `plug`; empty: none.
  /// `wire_time`: replies leave when the wire would deliver them; otherwise at once. Throws SetupError.
  PtyLine(BoardBusEmulator& bus, const std::string& link, bool wire_time);
  ~PtyLine();  ///< closes the terminal and removes the link
  PtyLine(const PtyLine&) = delete;
  PtyLine& operator=(const PtyLine&) = delete;

  /// Serves the terminal for at most `patience_ms`; returns when `also_descriptor` (-1: none) has input.
  bool serve(int patience_ms, int also_descriptor = -1);

  void unplug();  ///< closes the terminal: the host's port hangs up
  void plug();    ///< opens a new one, under the same link
  bool plugged() const { return master_ >= 0; }
  const std::string& path() const { return path_; }  ///< of the terminal, /dev/pts/N
  std::uint64_t bytesReceived() const { return received_; }

 private:
  void sendDue();
  void forgetExclusive();

  BoardBusEmulator& bus_;
  std::string link_, path_;
  int master_ = -1, slave_ = -1;
  std::uint64_t received_ = 0;
  std::int64_t last_forget_ns_ = 0;
};

/// Serves a line from a thread of its own (tests, benchmarks, the latency test). While it runs, the boards
/// and their plant are touched inside `with` only.
class PtyThread {
 public:
  explicit PtyThread(PtyLine& line) : line_(line), thread_([this] { run(); }) {}
  ~PtyThread() {
    stop_ = true;
    thread_.join();
  }
  template <class Action>
  void with(Action&& action) {
    ++waiting_;
    std::lock_guard<std::mutex> lock(mutex_);
    action();
    --waiting_;
  }

 private:
  void run() {
    while (!stop_) {
      while (waiting_ > 0) std::this_thread::yield();  // a mutex alone may never let `with` in
      std::lock_guard<std::mutex> lock(mutex_);
      line_.serve(1);
    }
  }
  PtyLine& line_;
  std::mutex mutex_;
  std::atomic<bool> stop_{false};
  std::atomic<int> waiting_{0};
  std::thread thread_;
};

}  // namespace haptic
