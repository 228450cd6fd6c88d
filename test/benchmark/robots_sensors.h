/// Sensors of robots as loaded: against inverse dynamics of the motion, and all wrenches on a link against its change of momentum.
#pragma once

namespace haptic::bench {

/// sensors.reaction_err_rel: wrench through every joint of robots that move, with and without contacts, against a second algorithm: forward
/// kinematics and momenta of whole subtrees from q and v of the states before and after, in long double; over the largest force (torque)
/// through a joint in that step. sensors.kdl_err_rel and sensors.kdl_order: along the axes against KDL's inverse dynamics in the middle of
/// the step, at 1 ms and by halving it. sensors.sum_err_rel: forces of all sensors on a link and its weight against m a from its twists,
/// over the sum of their sizes, impacts included; sensors.sum_torque_err_rel: torques likewise, over their sizes and those of the forces at
/// the link's reach. contacts.cop_err_m: centre of pressure of a cube under a tilted, eccentric load against the line of the load [m].
/// coupling.axes: axes of a virtual coupling, of six, that pull with their own stiffness.
void measureSensors();

}  // namespace haptic::bench
