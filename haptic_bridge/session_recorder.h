/// The session as topics under recorded/: what a bag needs to be replayed. Nothing in them reaches a motor.
#pragma once
#include <ros/node_handle.h>

#include <deque>
#include <vector>

#include "haptic_bridge/flight_recorder.h"
#include "haptic_bridge/session_messages.h"

namespace haptic {

/// Drains the real-time thread's recordings; called by telemetry's thread. With ~record they are published; in any
/// case the flight recorder gets them.
class SessionRecorder {
 public:
  SessionRecorder(ros::NodeHandle& nh, const BridgeParameters& parameters, RealtimeThread& loop);

  void drain();
  FlightRecorder& flight() { return flight_; }

 private:
  void publish(const haptic_msgs::TickRecord& run);
  void begin(const RealtimeThread::Start& start);
  void remember();
  void follow(const std::vector<double>& bodies);

  BridgeParameters parameters_;
  RealtimeThread& loop_;
  FlightRecorder flight_;
  ros::Publisher session_, ticks_, events_;
  std::vector<int> strings_;  ///< per hand
  std::shared_ptr<const RealtimeThread::Start> start_;  ///< of the session that runs
  std::vector<std::string> device_texts_;               ///< as they were at its start
  LoopSession::Memory memory_;
  std::int64_t next_memory_ns_ = 0;
  std::deque<FlightStart> waiting_memories_;
  std::deque<std::shared_ptr<const RealtimeThread::Start>> waiting_starts_;
  std::deque<LoopEvent> waiting_events_;
};

}  // namespace haptic
