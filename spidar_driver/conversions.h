/// From the device's record to the driver's messages.
#pragma once
#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <geometry_msgs/TwistStamped.h>
#include <geometry_msgs/WrenchStamped.h>
#include <haptic_msgs/DeviceState.h>
#include <haptic_msgs/conversions.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/Joy.h>

#include "haptic_core/loop/ports.h"

namespace haptic {

/// What `state` says; counts and claims are the caller's.
haptic_msgs::DeviceState toState(const DeviceRecord& record, const DeviceDef& def);

}  // namespace haptic
