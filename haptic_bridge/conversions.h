/// From the core's types to the bridge's messages.
#pragma once
#include <haptic_msgs/EnergyLedger.h>
#include <haptic_msgs/HandReport.h>

#include <string>

#include "haptic_core/loop/haptic_loop.h"

namespace haptic {

haptic_msgs::EnergyLedger ledgerMessage(const EnergyLedger& energy);
haptic_msgs::HandReport handMessage(const HandReport& report, const std::string& device, const std::string& pointer);

}  // namespace haptic
