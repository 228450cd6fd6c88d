/// From the world's reports to the simulation's messages.
#pragma once
#include <haptic_msgs/Contacts.h>
#include <haptic_msgs/LiveReport.h>
#include <haptic_msgs/StepReport.h>
#include <haptic_msgs/conversions.h>

#include "haptic_core/loop/ports.h"
#include "haptic_core/analysis/error_estimate.h"
#include "haptic_core/world/contact_detail.h"

namespace haptic {

/// Names are those of the world's links; headers are the caller's.
haptic_msgs::Contacts toContacts(const WorldSnapshot& snapshot, const std::vector<std::string>& links, PatchOutline& outline);
haptic_msgs::StepReport toStepReport(const WorldSnapshot& snapshot, const std::vector<std::string>& links, double step);
haptic_msgs::LiveReport toLiveReport(const WorldCopy& copy, const ErrorEstimate& estimate,
                                     const std::vector<std::string>& links, const WorldSettings& settings);

}  // namespace haptic
