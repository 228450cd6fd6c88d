/// What people and monitors see of the loop: statistics, diagnostics, and the figures of a timed run.
#pragma once
#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "haptic_bridge/bridge_parameters.h"
#include "haptic_bridge/realtime_thread.h"
#include "haptic_bridge/run_figures.h"
#include "haptic_bridge/session_recorder.h"

namespace haptic {

/// Drains the real-time thread's ring at 60 Hz in a thread of its own. `tick_statistics` at 10 Hz when somebody
/// subscribes; /diagnostics at 1 Hz. Shuts the process down when a timed run is done, or the loop cannot start.
class Telemetry {
 public:
  Telemetry(ros::NodeHandle& nh, ros::NodeHandle& priv, const std::string& name, const BridgeParameters& parameters,
            RealtimeThread& loop);
  ~Telemetry();

 private:
  void run();
  void drain();
  void publishStatistics();
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);
  void diagnoseHands(diagnostic_updater::DiagnosticStatusWrapper& status) const;
  bool followPhase();
  void watchClock(std::int64_t now_ns);
  void finish();

  std::string name_;
  BridgeParameters parameters_;
  RealtimeThread& loop_;
  ros::Publisher statistics_;
  SessionRecorder recorder_;
  diagnostic_updater::Updater diagnostics_;
  TickTimes period_;                     ///< since the last statistics
  TickTimes second_;                     ///< since the last diagnostics
  std::unique_ptr<RunFigures> figures_;  ///< of a timed run
  std::uint64_t ticks_ = 0, missed_before_ = 0;
  TickSample last_;
  RealtimeThread::LastTick last_tick_;
  std::int64_t next_statistics_ns_ = 0, next_diagnostics_ns_ = 0, next_reminder_ns_ = 0;
  ros::Time last_clock_;                 ///< of a simulated clock, and when it last moved
  std::int64_t clock_moved_ns_ = 0;
  bool clock_told_ = false;
  bool setup_told_ = false;
  std::string deadline_told_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace haptic
