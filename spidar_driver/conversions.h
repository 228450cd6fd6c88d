/// From the core's types to the driver's messages, and back.
#pragma once
#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <geometry_msgs/TwistStamped.h>
#include <geometry_msgs/WrenchStamped.h>
#include <haptic_msgs/DeviceState.h>
#include <ros/time.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/Joy.h>

#include "haptic_core/loop/ports.h"

namespace haptic {

geometry_msgs::Point toPoint(const Vector3& p);
geometry_msgs::Vector3 toVector(const Vector3& v);
geometry_msgs::Quaternion toQuaternion(const Matrix3& R);
geometry_msgs::Pose toPose(const Pose& X);
geometry_msgs::Transform toTransform(const Pose& X);
geometry_msgs::Wrench toWrench(const Wrench& F);
Pose fromPose(const geometry_msgs::Pose& pose);        ///< the quaternion is normalised; NaN stays NaN
Pose fromTransform(const geometry_msgs::Transform& transform);
Wrench fromWrench(const geometry_msgs::Wrench& wrench);

/// ROS time of an instant on the steady clock [ns]. With a simulated clock: its present time.
ros::Time toStamp(std::int64_t steady_ns);

/// What `state` says; counts and claims are the caller's.
haptic_msgs::DeviceState toState(const DeviceRecord& record, const DeviceDef& def);

}  // namespace haptic
