/// Everything that changes a running loop beside its samples, as data.
///
/// Other threads send them through rings (base/command_ring.h): owners through `PortOffer::send`, the bridge's own through its
/// `RealtimeThread`. The runner drains the rings between two ticks; `HapticLoop::take` carries out, while running and in a
/// replay alike, and a recording keeps each command as it was told, with the tick that it came before.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "haptic_core/dynamics/joint_law.h"
#include "haptic_core/loop/hand_settings.h"
#include "haptic_core/spidar/device_requests.h"
#include "haptic_core/world/led_motion.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/tuning.h"

namespace haptic {

struct Calibration;
class NextWorld;
class Spidar;
class World;

/// Command: the world goes back to a saved state.
struct RestoreWorld {
  std::vector<double> state;   ///< World::save(); the pointers start there and glide to their grips

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.state);
  }
};
/// Command: new values of what may change about a running world.
struct TuneWorld {
  /// All of them.
  WorldTuning tuning;

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.tuning);
  }
};
/// Command: a device goes back to saved memory.
struct RestoreDevice {
  std::vector<double> memory;  ///< Spidar::save()

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.memory);
  }
};
/// Command: new settings of a hand.
struct ChangeHand {
  /// All of them.
  HandSettings settings;

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.settings);
  }
};
/// Command: a hand lost its device. Its pointer stands, the hands after it move up.
struct DropHand {
  template <class Self, class Visit>
  static void eachField(Self&, Visit&&) {}
};
/// Command: a user asks a device to calibrate, to recover or to switch its force.
struct AskDevice {
  DeviceRequests requests;     ///< followed in the next tick

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.requests);
  }
};
/// Command: the world pauses, or runs on.
/// While paused the world stands and nothing is asked of the devices: their force goes by the law of change, and fades in anew.
struct PauseWorld {
  /// False: it runs on.
  bool on = true;

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.on);
  }
};
/// Command: the clutch is held, or released.
/// While held, the pointer stands and the grip moves freely; it waits while the pointer is in contact, for the wrench
/// would jump to that of another place.
struct HoldClutch {
  /// False: the grip moves the pointer again.
  bool held = true;

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.held);
  }
};
/// Command: another link becomes the pointer, where `World::canGrab` allows it.
struct GrabLink {
  /// Index of the pointer, and world index of the link.
  int pointer = 0, link = 0;

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.pointer), visit(s.link);
  }
};
/// Command: the drive of a joint gets a new target.
struct DriveJoint {
  /// Index of `World::joint`.
  int joint = 0;
  /// From the next step on.
  JointCommand command;

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.joint), visit(s.command);
  }
};
/// Command: one step while the world is paused.
/// One step of a paused world, done at once: the devices stay at minimum tension, the pointers where they are.
struct StepWorld {
  template <class Self, class Visit>
  static void eachField(Self&, Visit&&) {}
};

/// Command: a device takes up a calibration; its pose is then sought from where it was.
struct AdoptCalibration {
  std::vector<double> strings;  ///< per string: exit in B, and length at count 0 [m]

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.strings);
  }
};
/// Command: new limits and λ of a device, within its file's.
struct TuneDevice {
  double lambda = 0;                     ///< see Spidar::Tuning [1]
  double max_force = 0, max_torque = 0;  ///< [N], [N·m]

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.lambda), visit(s.max_force), visit(s.max_torque);
  }
};

/// Command: zero current at once, until the device is told to recover.
struct StopDevice {
  template <class Self, class Visit>
  static void eachField(Self&, Visit&&) {}
};
/// Command: a device's dead-man switch was taken or let go.
struct HoldSwitch {
  /// False: no force.
  bool held = true;

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.held);
  }
};

/// Command: a wrench acts on a link for a time, from the next step on.
struct ApplyWrench {
  int link = 0;                ///< world link index
  LinkWrench wrench;           ///< and about which point
  double seconds = 0;          ///< 0: those that act on the link end

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.link), visit(s.wrench), visit(s.seconds);
  }
};
/// Command: a body is put elsewhere while the world is paused.
struct PutBody {
  int link = 0;                ///< world link index
  Pose X_WL;                   ///< where
  Twist V_WL;                  ///< at the link frame's origin, in W

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.link), visit(s.X_WL), visit(s.V_WL);
  }
};
/// Command: joints are put elsewhere, at rest, while the world is paused.
struct PutJoints {
  std::vector<std::pair<int, double>> positions;  ///< index of `World::joint`, [rad] or [m]

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.positions);
  }
};
/// Command: a body that is told its motion pose by pose goes to the next one, without a jump (World::followBody).
struct LeadBody {
  int motion = 0;              ///< index of `World::motion`
  MotionPoint to;              ///< pose and twist that it arrives with
  double seconds = 0;          ///< how long it takes, at least a step; longer where the pose is a jump

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.motion), visit(s.to.p_WL), visit(s.to.q_WL), visit(s.to.V_WL), visit(s.seconds);
  }
};

/// Command: bodies come or go while the world runs, see World::exchange.
struct ChangeBodies {
  /// Numbers of `packBodies`: the new definition, and which articulations of the old one stay in it. Never null.
  std::shared_ptr<std::vector<double>> packed = std::make_shared<std::vector<double>>();
  /// Compiled beforehand by the sender, for the running world; null, as in a replay: when it is carried out. Holds the old world then.
  std::shared_ptr<NextWorld> next;

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(*s.packed);  // the rest follows from it
  }
};

/// Command: gravity from the next step on, and nothing else of the tuning.
struct SetGravity {
  Vector3 gravity = Vector3::Zero();  ///< in W [m/s²]

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.gravity);
  }
};

/// A change of a running loop as data, and which hand it is for.
struct LoopCommand {
  /// Recordings number the kinds in this order (haptic_msgs/LoopEvent): new ones go to the end.
  using Kind = std::variant<RestoreWorld, TuneWorld, RestoreDevice, ChangeHand, DropHand, AskDevice, PauseWorld, HoldClutch,
                            GrabLink, DriveJoint, StepWorld, AdoptCalibration, TuneDevice, StopDevice, HoldSwitch, ApplyWrench,
                            PutBody, PutJoints, LeadBody, ChangeBodies, SetGravity>;
  /// What to do, with its data.
  Kind kind;
  int hand = 0;  ///< which; 0 for the world

  /// Whether it is of the kind T.
  template <class T>
  bool is() const {
    return std::holds_alternative<T>(kind);
  }

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.kind), visit(s.hand);
  }
};

/// A command with the tick that it was carried out before.
struct LoopEvent {
  /// The first tick that ran after it.
  std::uint64_t tick = 0;
  /// As it was told.
  LoopCommand command;

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.tick), visit(s.command);
  }
};

/// Of one hand, and not of the world.
inline bool isForHand(const LoopCommand& command) {
  return command.is<RestoreDevice>() || command.is<ChangeHand>() || command.is<DropHand>() || command.is<AskDevice>() ||
         command.is<HoldClutch>() || command.is<AdoptCalibration>() || command.is<TuneDevice>() || command.is<StopDevice>() ||
         command.is<HoldSwitch>();
}

/// Only while the world is paused: a body that is elsewhere from one tick to the next is an impact for a hand that touches it.
inline bool needsPause(const LoopCommand& command) {
  return command.is<StepWorld>() || command.is<PutBody>() || command.is<PutJoints>();
}

/// Between two ticks: carries out the command on a world without hands. Throws SetupError when it cannot be done.
void apply(const LoopCommand& command, World& world);
/// Between two ticks: carries out the command on a device. Throws SetupError when it cannot be done.
void apply(const LoopCommand& command, Spidar& device);

AdoptCalibration adoptionOf(const Calibration& calibration);  ///< the command to take it up

/// At set-up: the numbers of a ChangeBodies. `kept`: as NextWorld takes them.
std::vector<double> packBodies(const WorldDef& def, const std::vector<int>& kept);
WorldDef unpackBodies(const std::vector<double>& packed);  ///< the new definition again, without sensors; throws SetupError
std::vector<std::string> linkNames(const WorldDef& def);   ///< in the world's order
/// Compiles the next world of a ChangeBodies, where its sender has not. Throws SetupError.
std::shared_ptr<NextWorld> nextWorld(const ChangeBodies& change, const World& running);

/// Commands on their way to a runner: they stay the sender's, and are carried out in order, before one tick. The first that is
/// refused ends it; those before it stand.
struct Tell {
  /// The first of `count`.
  const LoopCommand* first = nullptr;
  /// How many.
  std::size_t count = 1;
};

/// For recordings: the numbers of a command beside its kind and hand, and back.
std::vector<double> numbersOf(const LoopCommand& command);
/// The same for settings alone.
std::vector<double> numbersOf(const HandSettings& settings);
HandSettings handSettingsFrom(const std::vector<double>& numbers);  ///< throws SetupError
LoopCommand commandFrom(std::size_t kind, int hand, const std::vector<double>& numbers);  ///< throws SetupError

}  // namespace haptic
