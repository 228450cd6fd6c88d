/// Presses a pointer into its scene through the whole loop, on a simulated device, and measures the force's jumps and rings.
///
/// A trial moves the grip of a DeviceTwin from home along a way, rests there and goes back: held by a jig (the grip is where it
/// shall be), or by a relaxed hand. It ends with numbers that say whether a hand would feel more than the scene:
///   - jump: max over ticks of |F_k - F_(k-1)| - K_max |x_k - x_(k-1)|, F the force asked before the device's limits, x the
///     measured grip, K_max the loop's bound at its rate; for torques K_max (r |Δx| + r² |Δθ|), r the link's reach at the grip.
///     The 20 ms after the tool first touches something at more than 0.1 m/s are impacts, and are counted instead.
///   - rings: the grip's target rests, and some component of F turns by more than 0.3 N over five times within 50 ms.
///   - energy_given: over every interval that begins 50 ms after the way's first contact, the work of the true tensions on the grip, less
///     the energy in the springs of contacts, friction and coupling at its start, less the work of led bodies, belts, drives and gravity
///     in it, as the grip has them (scale); the largest.
/// At set-up: allocates, and costs as many ticks as the way takes.
#pragma once
#include <vector>

#include "haptic_core/loop/hand_settings.h"
#include "haptic_core/spidar/device_def.h"
#include "haptic_core/spidar/hand_path.h"
#include "haptic_core/world/definition.h"

namespace haptic {

/// One way of the grip: out along `direction`, with rests, and back.
struct TrialWay {
  Vector3 direction = -Vector3::UnitZ();  ///< unit, in the device's base
  double depth = 0.01;                    ///< [m] of the grip
  double speed = 0.05;                    ///< greatest, of a motion of least jerk [m/s]
  Vector3 turn = Vector3::Zero();         ///< rotation vector of the grip at the way's end [rad]
  std::vector<double> rests = {1};        ///< where it rests on the way out, of the depth; the last is the way's end
  double rest = 0.3;                      ///< for how long [s]
  bool jig = true;                        ///< the grip is held rigidly, but for a tremor of 0.05 mm; false: by a relaxed hand
};

/// Measures of a trial. The first three are ≤ 0.3 N, N·m in proportion, where nothing strikes the hand.
struct TrialResult {
  double jump = 0;           ///< [N]
  double torque_jump = 0;    ///< [N·m]
  double tension_jump = 0;   ///< [N], of the wrench of the tensions sent
  double strongest = 0;      ///< greatest |F| asked [N]
  double stiffness = 0;      ///< K_max [N/m]
  int ticks = 0, touching = 0, impacts = 0;  ///< ticks; with contact; of those after impacts
  int over_limit = 0;        ///< ticks with |F| above the device's stated limit
  int led = 0;               ///< in which the world's force changed faster than the hand's may (force_slew.h)
  int weakened = 0;          ///< ticks with contact in which coupling or contact was weakened to what the hand bears
  double energy_given = 0;   ///< [J], see above
  double energy_moving = 0;  ///< the same, less the energy of motion at the interval's start as well [J]
  /// The same as energy_given, less what the hand itself has stored by going on beyond a held tool (direct coupling): its force times the
  /// way behind which the tool stays, as of a virtual coupling's spring at its limit [J].
  double energy_held = 0;
  int doubted = 0;           ///< ticks in which the device, a sound one, was REDUCED or in FAULT
  bool rings = false;        ///< while the target rested
  bool finite = true;        ///< the world stayed so

  bool steady() const { return finite && !rings; }  ///< neither rings nor breaks off
};

/// Largest jump that is none [N]: what counts and the velocity's filter make of a rest.
inline constexpr double kQuietJump = 0.3;

/// The farthest way of the grip along a unit direction of B: 80 % of the way to the box of the device's exits [m].
double workspaceEnd(const DeviceDef& device, const Vector3& direction);

/// Ways that press the pointer as it starts on its nearest neighbour, to the workspace's end with rests on the way, since a loop may
/// ring where the tool touches lightly and be quiet where the force has reached its limit: slowly and fast, by a jig and by a relaxed
/// hand. Empty: it can touch nothing.
std::vector<TrialWay> pressingWays(const WorldDef& def, int pointer, const HandSettings& settings, const DeviceDef& device);

/// The worst of all of them: a scene's verdict. Costs some seconds.
TrialResult pressHand(const WorldDef& def, int pointer, const HandSettings& settings, const DeviceDef& device);

/// One trial of a fresh world. Throws SetupError as World and Spidar do.
TrialResult tryHand(const WorldDef& def, int pointer, const HandSettings& settings, const DeviceDef& device, const TrialWay& way);

}  // namespace haptic
