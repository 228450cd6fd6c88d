/// Abilities and faults of an arrangement of strings: the text that the verb `check` prints.
#pragma once
#include <string>
#include <vector>

#include "haptic_core/spidar/string_kinematics.h"

namespace haptic {

/// Abilities of an arrangement of strings.
/// Numbers about the home pose unless said otherwise. Presentable: with λ → 0 the tensions' bounds keep less
/// than 2 % of the wrench away.
struct DeviceReport {
  double knot_radius = 0;           ///< r of W [m]
  Eigen::VectorXd singular_values;  ///< of the scaled structure matrix, falling [1]
  double worst_singular_value = 0;  ///< wherever a force is presentable all round, identity orientation [1]
  /// Of the grip's origin [m].
  Vector3 reach_min, reach_max;     ///< along each axis, as far as a force is presentable all round and the lengths determine the pose [m]
  /// Of the grip [rad].
  Vector3 turn_min, turn_max;       ///< about each axis, likewise [rad]; zero for a point grip
  double feasible_share = 0;        ///< of the frame's box where a force all round is presentable, the pose determined [1]
  double uncertain_share = 0;       ///< likewise, the pose poorly determined: singular value below .1 [1]
  double presentable_force = 0;     ///< largest, worst of 26 directions [N]
  double presentable_torque = 0;    ///< likewise [N·m]
  double force_share = 0,  ///< presented of 5 N (or the clamp) with the file's λ [1]
         torque_share = 0;              ///< likewise, of 0.1 N·m [1]
  Vector3 stiffness = Vector3::Zero();  ///< of the strings at least tension, x y z [N/m]
  Vector3 resolution = Vector3::Zero();       ///< rms pose error of encoder rounding, x y z [m]
  Vector3 turn_resolution = Vector3::Zero();  ///< about x y z [rad]
  double closest_strings = 0;                 ///< least distance of two strings of different knots [m]
  std::vector<std::string> problems;          ///< one line each: a fault and its remedy
  std::vector<std::string> to_do;             ///< one line each: facts that only the device on the desk can tell
};

/// Set-up: about 0.1 s.
DeviceReport examineDevice(const DeviceDef& def);

/// The report as text, with the first-motion test that settles signs and handedness.
std::string checkDevice(const DeviceDef& def);

/// Most that a fault may put into the hand within the reaction time [J]: the greatest wrong force, rising at the slew limit,
/// for as long as counts may be old, on a grip m without a hand that brakes it, which moves along at v = 1 m/s already: J v + J²/(2m).
double faultEnergy(const DeviceDef& def);

/// Least distance of the segments p0 p1 and q0 q1 [m].
double segmentDistance(const Vector3& p0, const Vector3& p1, const Vector3& q0, const Vector3& q1);

}  // namespace haptic
