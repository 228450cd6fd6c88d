/// A string-driven device as its description file states it. Constant while running.
///
/// Frames: B is the device's base (REP-103: x forward, y left, z up; origin at the centre of the frame),
/// G the grip. Files written in the makers' axes (x right, y up, z depth) say so and are converted at load.
#pragma once
#include <string>
#include <vector>

#include "haptic_core/base/spatial.h"

namespace haptic {

/// Strings of one device. Vectors over strings live on the stack with run-time size.
inline constexpr int kMaxStrings = 16;
using StringVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxStrings, 1>;  ///< one number per string

/// For lists of fields (base/fields.h): one number per string; the size is not among them.
template <class T, class Visit>
std::enable_if_t<std::is_same_v<std::remove_const_t<T>, StringVector>> eachNumber(T& strings, Visit&& visit) {
  for (int i = 0; i < strings.size(); ++i) visit(strings[i]);
}

/// One string of a device: geometry, encoder and motor.
struct StringDef {
  Vector3 p_BE = Vector3::Zero();    ///< exit from the frame, in B [m]
  Vector3 p_GK = Vector3::Zero();    ///< knot on the grip at opening 0, in G [m]
  Vector3 dp_GK = Vector3::Zero();   ///< knot's travel per metre of opening (7-DOF grips) [1]
  double length_per_count = 0;       ///< [m/count]; its sign makes the length grow when the string pays out
  double volt_per_newton = 0;        ///< [V/N]; its sign makes the drive pull
  double min_tension = 0;            ///< [N], keeps the string wound; > 0
  double max_tension = 0;            ///< [N]

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.p_BE), visit(s.p_GK), visit(s.dp_GK), visit(s.length_per_count), visit(s.volt_per_newton);
    visit(s.min_tension), visit(s.max_tension);
  }
};

/// Of the axes that a file's table was given in: stated by the source, or guessed until a first-motion test.
enum class Handedness : unsigned char { kRight, kLeft, kGuessedRight, kGuessedLeft };

/// A string-driven device as its description file states it.
struct DeviceDef {
  std::string name, file, source;    ///< its name, the file's path, and where its numbers come from
  int dof = 6;                       ///< 3: point grip; 6: rigid grip; 7: with one opening
  Handedness handedness = Handedness::kGuessedRight;  ///< of the axes the table was given in
  std::vector<StringDef> strings;                     ///< in channel order
  double lambda = 0.01;              ///< weight of |t|² against the wrench error [1] (N-weighted)
  double border_lambda = 0;          ///< λ where 1 N of the wrench cannot be presented [1] (TensionDistribution); 0: λ is constant
  double max_rate_hz = 1000;         ///< highest exchange rate of the wire [Hz]
  double delay_s = 0;                ///< from exchange to tension [s], beside the one-tick pipeline
  double max_force = 10;             ///< clamp on the wrench [N]
  double max_torque = 0.3;           ///< clamp on the wrench [N·m]
  double grip_mass = 0.05;           ///< of the twin [kg]
  double grip_radius = 0.02;         ///< of the twin, for its inertia [m]
  double grip_damping = 0;           ///< device damping at the grip [N·s/m]
  std::string transport = "twin";    ///< twin, uart, usb_sh4, usb_simple
  std::vector<std::string> boards;   ///< models that the transport must find, in channel order
  std::string note;                  ///< facts that the source leaves open

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.name), visit(s.file), visit(s.source), visit(s.dof), visit(s.handedness), visit(s.strings), visit(s.lambda);
    visit(s.border_lambda), visit(s.max_rate_hz), visit(s.delay_s), visit(s.max_force), visit(s.max_torque), visit(s.grip_mass);
    visit(s.grip_radius), visit(s.grip_damping), visit(s.transport), visit(s.boards), visit(s.note);
  }
};

/// Reads a description (YAML; format in urdf/devices/README.md). Throws SetupError that names file, key, remedy.
DeviceDef loadDevice(const std::string& path);

}  // namespace haptic
