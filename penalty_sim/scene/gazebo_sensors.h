/// Sensors as robots for Gazebo have them: <gazebo reference="..."><sensor type="imu|contact|force_torque">.
#pragma once
#include "scene/robot_file.h"

namespace haptic {

/// Turns those that can be measured here into <haptic:sensor>, with name, rate, pose and Gaussian noise; what is left out (other kinds,
/// plugins, references to nothing) stands in one note, and so does a wrench that Gazebo would give the other sign or other axes.
void takeGazeboSensors(RobotFile& robot);

}  // namespace haptic
