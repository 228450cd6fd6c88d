/// Measurements that a user asks of a world, and their samples. Sensors only look: no bit of the motion depends on them.
#pragma once
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "haptic_core/base/spatial.h"
#include "haptic_core/dynamics/articulation_def.h"

namespace haptic {

/// A part of a link: what lies beyond a fixed joint that was merged at load. Contacts and weight of the part alone are measured.
struct LinkPart {
  LinkInertia inertia;          ///< of the part, in the link's frame
  std::vector<int> collisions;  ///< of the link, by index: those of the part
  std::vector<int> children;    ///< links of the articulation that hang on the part
};

/// A sensor on a link L, with its frame S.
struct SensorDef {
  /// Quantity that it measures.
  enum class Kind : unsigned char {
    kWrench,   ///< wrench through the link's joint (of a part: through the merged joint) on all that hangs beyond, about S
    kContact,  ///< sum of the contacts on the link or part, about S
    kImu       ///< orientation, angular rate and specific force of S
  };
  Kind kind = Kind::kWrench;           ///< see there
  std::string name;                    ///< unique in a world
  std::string frame;                   ///< name that S goes by, for messages
  int articulation = -1, link = -1;    ///< L
  Pose X_LS;                           ///< S in L
  bool on_part = false;                ///< not the whole link: `part`
  LinkPart part;                       ///< see above
  int with_articulation = -1, with_link = -1;  ///< contacts with this link only; -1: with all
  bool with_part = false;              ///< not with the whole of that link: `with_collisions`
  std::vector<int> with_collisions;    ///< see above
  double rate = 0;                     ///< samples per simulated second [Hz]; 0: one a step, which is also the most
  std::uint64_t seed = 1;              ///< of the noise; sensors of other names have other noise
  /// Standard deviations of white noise on every component of a sample: torque [N·m] and force [N] of a wrench; angular rate [rad/s],
  /// specific force [m/s²] and orientation (a turn about each axis of S [rad]) of an IMU.
  double noise_torque = 0, noise_force = 0, noise_rate = 0, noise_specific_force = 0, noise_orientation = 0;
};

/// A sample. Fields that its sensor does not fill are NaN.
struct SensorReading {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();  ///< not filled
  std::uint64_t step = 0;  ///< after which it was taken; 0: none since the start or a restore
  Wrench F_S{Vector3::Constant(kNone), Vector3::Constant(kNone)};  ///< on the link or part, about S, in S's axes [N·m], [N]
  Quaternion q_WS{kNone, kNone, kNone, kNone};                     ///< orientation of S
  Vector3 omega_S = Vector3::Constant(kNone);                      ///< angular velocity of S in W, in S's axes [rad/s]
  Vector3 specific_force_S = Vector3::Constant(kNone);             ///< acceleration of S's origin minus gravity, in S's axes [m/s²]
};

}  // namespace haptic
