/// From the core's types to the simulation's messages, and back.
#pragma once
#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <geometry_msgs/Wrench.h>
#include <haptic_msgs/Contacts.h>
#include <haptic_msgs/StepReport.h>
#include <ros/time.h>

#include "haptic_core/loop/ports.h"

namespace haptic {

geometry_msgs::Point asPoint(const Vector3& p);
geometry_msgs::Vector3 asVector(const Vector3& v);
geometry_msgs::Pose asPose(const Pose& X);
geometry_msgs::Transform asTransform(const Pose& X);
geometry_msgs::Wrench asWrench(const Wrench& F);
Pose poseFrom(const geometry_msgs::Pose& pose);            ///< the quaternion is normalised; NaN stays NaN
Pose poseFrom(const geometry_msgs::Transform& transform);
bool finite(const Pose& X);

/// ROS time of an instant on the steady clock [ns]. With a simulated clock: its present time.
ros::Time stampOf(std::int64_t steady_ns);

haptic_msgs::EnergyLedger asLedger(const EnergyLedger& energy);
/// Names are those of the world's links; headers are the caller's.
haptic_msgs::Contacts asContacts(const WorldSnapshot& snapshot, const std::vector<std::string>& links);
haptic_msgs::StepReport asStepReport(const WorldSnapshot& snapshot, const std::vector<std::string>& links, double step);

}  // namespace haptic
