/// From the loop's recordings to messages.
#pragma once
#include <haptic_msgs/SessionInfo.h>

#include <string>
#include <vector>

#include "haptic_bridge/realtime_thread.h"

namespace haptic {

/// The description files of the start's devices, as they are now.
std::vector<std::string> deviceTexts(const SessionStart& start);
haptic_msgs::SessionInfo toSessionInfo(const RealtimeThread::Start& start, const std::vector<std::string>& device_texts,
                                       const BridgeParameters& parameters);
}  // namespace haptic
