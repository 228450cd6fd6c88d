/// Every parameter of the driver, in one place.
#pragma once
#include <ros/node_handle.h>

#include <string>

#include "haptic_core/loop/realtime.h"
#include "haptic_core/spidar/string_kinematics.h"
#include "spidar_driver/dead_man_switch.h"

namespace haptic {

struct DriverParameters {
  std::string device_file;     ///< ~device: path of a description, or the name of one in haptic_description/devices
  std::string name;            ///< of the device: the last part of the node's namespace; prefix of its frames
  bool twin = true;            ///< ~transport: "twin" (default), or "file" for what the description says
  std::string port;            ///< ~port: serial port of the boards; empty: the first that has some
  int usb_unit = -1;           ///< ~usb_unit: rotary switch of the amplifier, 0–15; -1: any
  double rate = 1000;          ///< ~rate [Hz]: of the twin, and of the driver's own thread
  bool alone = true;           ///< ~alone: run the device in an own thread while no bridge holds it
  enum class Hand { kScript, kMarker, kNone } hand = Hand::kScript;  ///< ~hand: who moves the twin's grip
  std::string script;          ///< ~script: path of the twin's hand (rest, press, touch_cube, wave); "scene": the scene's
  bool calibrate_at_start;     ///< ~calibrate_at_start: the grip is at home when the node starts; default: twin
  GripPose jig_pose;           ///< ~jig_pose [x y z roll pitch yaw, m and rad]: where the grip is held to calibrate; default: home
  std::string calibration_file;  ///< ~calibration_file: read at the start, written by calibrations; empty: none
  bool restore_calibration = false;  ///< ~restore_calibration: the counters have not been reset since it was saved
  double wave_seconds = 20;    ///< ~wave_seconds [s]: length of the wave that ~calibrate_wave records
  bool enable_force;           ///< ~enable_force_at_start; default: twin
  double command_age_limit;    ///< ~command_age_limit [s]: an older wrench command decays
  double pose_rate = 500;      ///< ~pose_rate [Hz]: of pose, twist and wrench
  double joint_state_rate = 100;  ///< ~joint_state_rate [Hz]
  double frame_rate = 30;      ///< ~frame_rate [Hz]: of tf and markers
  std::string world_frame;     ///< ~world_frame: parent of the base in tf when ~place_base is set
  bool place_base = false;     ///< ~place_base: publish world -> base as identity (no simulation does it)
  DeadManParameters dead_man;  ///< ~dead_man (none, joy, grip), ~dead_man_button, ~dead_man_age_limit [s]: a hand on a switch
  bool end_with_parent = false;  ///< ~end_with_parent: the process ends with the one that started it, and takes its siblings along
  RealtimeSettings realtime;   ///< ~priority, ~cpu, ~lock_memory: of the own thread
};

/// Throws SetupError naming parameter, unit and bounds.
DriverParameters readParameters(const ros::NodeHandle& ns, const ros::NodeHandle& priv);

}  // namespace haptic
