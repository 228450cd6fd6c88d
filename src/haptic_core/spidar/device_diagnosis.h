/// Names the cause: the one place that accuses.
///
/// Everything that notices something only leaves evidence, a bit of DeviceFlag or DeviceSign. A table of causes (device_diagnosis.cpp) says
/// which evidence means what, in order: the first row whose signs are all there, and whose excuses are not, names the cause,
/// what becomes of the force and of the strings' lengths, and the sentence for the user. A machine that was late is such an
/// excuse: silence counts in ticks that were on time, never in time that this program did not run.
#pragma once
#include <cstdint>
#include <string>

#include "haptic_core/spidar/transport.h"

namespace haptic {

/// Evidence of one tick, and notes on it. `DeviceState.flags` publishes these bits.
enum DeviceFlag : unsigned {
  kCommandNotFinite = 1u << 0,  ///< NaN or infinity in the wrench: taken as zero
  kForceClamped = 1u << 1,      ///< over max_force
  kTorqueClamped = 1u << 2,     ///< over max_torque
  kSlewLimited = 1u << 3,       ///< what is wanted changes faster than the law lets the wrench (force_slew.h)
  kNotPresentable = 1u << 4,    ///< the tensions' bounds keep more than 5 % of the wrench away
  kTensionAtMax = 1u << 5,      ///< a string pulls at its greatest tension
  kFaded = 1u << 6,             ///< the gain is below 1: a ramp, REDUCED, heat
  kCommandStale = 1u << 7,      ///< no fresh wrench within the age limit
  kTorqueIgnored = 1u << 8,     ///< a point grip was asked for torque
  kPoseNotConverged = 1u << 9,  ///< the pose of the tick before is kept
  kSampleStale = 1u << 10,      ///< no new counts of every board in this tick
  kLinkLost = 1u << 11,         ///< silent, disconnected or counts too old: zero current, until counts come for 50 ms
  kEncoderJump = 1u << 12,      ///< a counter jumped: corrected (kStringCorrected), or the lengths are lost
  kResidualHigh = 1u << 13,     ///< lengths contradict each other: slack, slip or break
  kOverRate = 1u << 14,         ///< ticks shorter than the wire's least period
  kMotorHot = 1u << 15,         ///< heat model: the wrench is faded
  kAnswersLost = 1u << 16,      ///< more answers are lost than a sound wire loses: reduced, then no force
  kDelayTooLong = 1u << 17,     ///< the wire's delay leaves no stable wall worth the name
  kCountersStill = 1u << 18,    ///< no counter moves although the force does: stuck, or the grip is clamped; calibrate
  kCounterRestarted = 1u << 19, ///< a board started anew: calibrate
  kStringCorrected = 1u << 20,  ///< an encoder slipped since the last calibration and was corrected
  kCountRefused = 1u << 21,     ///< a count that no string can have made was replaced, or the pose of before kept
  kLoopLate = 1u << 22,         ///< this program stood still: no part of the device is to blame for old counts
  kCountersFrozen = 1u << 23,   ///< all counters of a moving grip stopped within a tick
  kSomeCountersStill = 1u << 24, ///< no counter of a board moves while those of others do
  kCalibrationRefused = 1u << 25, ///< the grip was far from where the last calibration was asked for; said for 10 s
  kUnguarded = 1u << 26,        ///< no second process could turn the motors off: zero current
  kStopped = 1u << 27,          ///< somebody said STOP: zero current until `recover` or until the force is enabled
  kReleased = 1u << 28,         ///< the dead-man switch is not held: minimum tension
  kForceWaits = 1u << 29,       ///< a silence lasted while force was on: minimum tension until somebody enables the force
};

/// Evidence that is not published: it grades the flags.
enum DeviceSign : std::uint64_t {
  kSilenceLasts = 1ull << 32,    ///< silent for longer than an interruption, in ticks that were on time
  kAnswersFailing = 1ull << 33,  ///< half of the answers are lost
  kForceRefused = 1ull << 34,    ///< the wire is so slow that force which is on must end
  kRateRefused = 1ull << 35,     ///< the rate is above the wire's, on hardware
  kCountersLost = 1ull << 36,    ///< the counters no longer tell the strings' lengths
  kLengthsBroken = 1ull << 37,   ///< the lengths contradict each other so much that no pose can be trusted
  kCountsRefusedLong = 1ull << 39, ///< counts come, and have made no pose for longer than force may act on old ones
  kStringNamed = 1ull << 38,     ///< it is known, or will not become clearer, which string contradicts the others
};

/// Why a device is not as it should be.
enum class DeviceCause : unsigned char {
  kNone,
  kLoopLate,          ///< this machine was late
  kUnplugged,         ///< the port is gone
  kPowerLost,         ///< a board lost its power
  kBoardRestarted,    ///< a board's counters started anew
  kOtherBoard,        ///< another model answers
  kTableSpoilt,       ///< a board cuts its packets short: its length table is spoilt
  kWrongMode,         ///< a board is not in the mode in which it follows currents
  kCurrentsIgnored,   ///< a board's currents are not those that it is told
  kForgets,           ///< a board keeps nothing that it is taught
  kNoise,             ///< bytes without end
  kBoardSilent,       ///< a board does not answer
  kAnswersLost,       ///< too many answers are lost
  kWireSlow,          ///< the wire's delay leaves no stable wall
  kCounterJumped,     ///< a counter jumped by more than a slip
  kBoardRepeats,      ///< a board repeats its counts while the others move
  kCountersStill,     ///< no counter moves although the force does
  kCountersFrozen,    ///< the counters of a moving grip stopped at once
  kStringWrong,       ///< a string contradicts the others
  kStringDoubtful,    ///< lengths contradict each other, not for long yet
  kOverRate,          ///< faster than the wire carries
  kUnguarded,         ///< the process that would turn the motors off is gone
  kCountsOld,         ///< a board answers with counts of cycles ago
  kCauses
};

/// Consequence of a cause for the force.
enum class Consequence : unsigned char {
  kSay,     ///< nothing: it is only said
  kPause,   ///< zero current; a ramp leads back when it is over
  kReduce,  ///< little force, until `recover`
  kRest,    ///< no force until `recover`; the pose is sound: balanced least tensions
  kStop,    ///< no force until `recover`; the pose or the motors cannot be trusted: zero current
};

/// One row of the table.
struct CauseRow {
  DeviceCause cause = DeviceCause::kNone;   ///< the cause that the row names
  std::uint64_t signs = 0;                  ///< DeviceFlag and DeviceSign bits that must all be there
  std::uint64_t excuses = 0;                ///< none of which may be
  unsigned statuses = 0;                    ///< bit per LinkStatus, one of which it must be; 0: any
  unsigned findings = 0;                    ///< bit per WireFinding, likewise
  Consequence presenting = Consequence::kSay;  ///< while force is on
  Consequence idle = Consequence::kSay;        ///< while it is off
  bool loses_lengths = false;               ///< a calibration is needed
};

/// (in realtime) The first row that fits; cause kNone: nothing is wrong. `signs`: DeviceFlag and DeviceSign bits.
const CauseRow& diagnose(std::uint64_t signs, LinkStatus status, WireFinding finding) noexcept;
DeviceCause causeOf(WireFinding finding) noexcept;  ///< (in realtime) as a wire's own report names it

const char* toString(DeviceCause cause);  ///< "power lost": for figures and tests
/// What happened, without advice: "board 2 had lost its power". `board`: its id, -1: not known.
std::string whatHappened(DeviceCause cause, int board, double late_s);

}  // namespace haptic
