/// From the loop's recordings to messages.
#pragma once
#include <haptic_msgs/LoopEvent.h>
#include <haptic_msgs/SessionInfo.h>
#include <haptic_msgs/TickRecord.h>

#include <string>
#include <vector>

#include "haptic_bridge/realtime_thread.h"

namespace haptic {

/// The description files of the start's devices, as they are now.
std::vector<std::string> deviceTexts(const SessionStart& start);
haptic_msgs::SessionInfo toSessionInfo(const RealtimeThread::Start& start, const std::vector<std::string>& device_texts,
                                       const BridgeParameters& parameters);
haptic_msgs::LoopEvent toLoopEvent(const LoopEvent& event);

/// Adds a tick to the run in `message`. False: it does not belong there (other hands, or not the next tick).
bool addTick(const RecordedTick& tick, const std::vector<int>& strings, haptic_msgs::TickRecord& message);

}  // namespace haptic
