/// The last seconds of the loop at full rate, kept in memory and written to a bag when something goes wrong.
#pragma once
#include <haptic_msgs/LoopEvent.h>
#include <haptic_msgs/SessionInfo.h>
#include <haptic_msgs/TickRecord.h>

#include <deque>
#include <string>
#include <vector>

#include "haptic_bridge/realtime_thread.h"

namespace haptic {

/// Where a flight recording can begin: a start of the loop, or a copy of its memory made while it ran.
struct FlightStart {
  haptic_msgs::SessionInfo info;
  int events = 0;                                 ///< of those before its first tick, how many it contains already
};

/// All in telemetry's thread. The bag holds standard messages (pose, wrench asked and achieved per hand at every tick,
/// what happened as diagnostics) and what a replay needs (recorded/...), from the last start on that is at least kSeconds
/// before the fault, or the oldest there is.
class FlightRecorder {
 public:
  explicit FlightRecorder(const BridgeParameters& parameters) : parameters_(parameters) {}

  void begin(const haptic_msgs::SessionInfo& info, const RealtimeThread::Start& start);
  void nameLinks(const std::vector<std::string>& links) { links_ = links; }  ///< bodies have come or gone
  void add(const haptic_msgs::TickRecord::ConstPtr& run);
  void add(const haptic_msgs::LoopEvent& event);
  void add(const FlightStart& memory);            ///< before the ticks and events that follow it
  /// Watches for faults; writes the bag a little after one. Returns its path when it did, or what kept it from it.
  std::string add(const TickSample& sample);
  std::string writeNow(const std::string& why);   ///< the loop failed: what there is

  static constexpr double kSeconds = 5;           ///< kept before a fault
  static constexpr double kAfter = 0.2;           ///< kept after it [s]
  static constexpr double kQuiet = 10;            ///< between two files [s]: a fault that flickers must not fill the disk

 private:
  std::string faultOf(const TickSample& sample);
  std::string write() const;

  BridgeParameters parameters_;
  void forgetOld();

  struct Kept : FlightStart {
    bool begins_session = false;                  ///< it must stand in the bag wherever in it it is
  };
  std::deque<Kept> starts_;                       ///< nothing older than the first is kept
  std::vector<std::string> devices_, links_;
  std::deque<haptic_msgs::TickRecord::ConstPtr> runs_;
  std::deque<haptic_msgs::LoopEvent> events_;
  std::deque<TickSample> samples_;
  std::vector<DeviceState> states_;               ///< per hand, of the last sample
  bool was_finite_ = true;
  std::string fault_;                             ///< that waits to be written
  std::uint64_t fault_tick_ = 0;
  std::int64_t written_ns_ = 0;
};

}  // namespace haptic
