/// From the core's types to the bridge's messages.
#pragma once
#include <haptic_msgs/HandReport.h>
#include <haptic_msgs/conversions.h>

#include <string>

#include "haptic_core/loop/haptic_loop.h"

namespace haptic {

haptic_msgs::HandReport toHandReport(const HandReport& report, const std::string& device, const std::string& pointer);

}  // namespace haptic
