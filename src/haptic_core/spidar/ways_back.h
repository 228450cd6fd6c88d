/// Every way in which force ends or weakens, and how it comes back: the one table. spidar_driver/README.md prints its rows, the advice
/// takes its words from here, and a test goes each way (test/core/loop/ways_back_test.cpp).
#pragma once
#include <cstddef>

namespace haptic {

/// Events after which a hand has no force, or less of it.
enum class ForceEnd : unsigned char {
  kLateTick,
  kInterruption,
  kLastingSilence,
  kFault,
  kLengthsLost,
  kReduced,
  kStop,
  kSwitchedOff,
  kDeadMan,
  kSender,
  kHot,
  kCalibration,
  kPause,
  kOtherWorld,
  kSilentHand,
  kEnds
};

/// What a person has to do for force.
enum class Ask : unsigned char {
  kNothing,             ///< it comes back by itself
  kEnable,              ///< `~enable_force`; button Enable
  kRecover,             ///< `~recover`, then `~enable_force`; buttons Recover, Enable
  kCalibrate,           ///< `~calibrate`, `~recover`, `~enable_force`; buttons Calibrate, Recover, Enable
  kHold,                ///< the dead-man switch
  kGoOn,                ///< `~pause` of the simulation with false; button Go on
  kLetIn,               ///< `~silent` of the bridge with false
};

/// A row of the table.
struct WayBack {
  ForceEnd end;           ///< which end it is about
  Ask ask;                ///< whom the force waits for
  const char* event;      ///< what happened
  const char* by_itself;  ///< what is there, or comes back, without anybody
  const char* asked;      ///< what somebody has to do for force; empty: nothing
};

/// In the order of ForceEnd.
inline constexpr WayBack kWaysBack[] = {
    {ForceEnd::kLateTick, Ask::kNothing, "ticks were late, by 20 ms at most", "the force stays, and goes on from where it was", ""},
    {ForceEnd::kInterruption, Ask::kNothing,
     "nothing was exchanged, or no counts came, for up to 0.5 s: programs stood still, or boards were silent",
     "zero current, then a ramp of 0.5 s to the force", ""},
    {ForceEnd::kLastingSilence, Ask::kEnable,
     "nothing was exchanged for more than 0.5 s: programs were stopped, or the machine slept", "least tension",
     "call enable_force"},
    {ForceEnd::kFault, Ask::kRecover,
     "FAULT, lengths known: boards silent for more than 0.5 s, unplugged or disobedient, the guard gone, a string wrong, the wire slow",
     "zero current or balanced least tension", "call recover, then enable_force"},
    {ForceEnd::kLengthsLost, Ask::kCalibrate, "FAULT, lengths lost: a board started anew, a counter jumped or stands still",
     "zero current", "hold the grip at the home pose, call calibrate first, then recover, then enable_force"},
    {ForceEnd::kReduced, Ask::kRecover, "REDUCED: a string is doubtful, counters froze, answers are lost", "1 N at most",
     "call recover, then enable_force"},
    {ForceEnd::kStop, Ask::kEnable, "STOP", "zero current",
     "call recover for tensioned strings, or enable_force for force"},
    {ForceEnd::kSwitchedOff, Ask::kEnable, "enable_force false", "least tension", "call enable_force for force"},
    {ForceEnd::kDeadMan, Ask::kHold, "the dead-man switch was let go", "least tension", "hold the switch"},
    {ForceEnd::kSender, Ask::kNothing, "the sender of wrench_command was silent for 30 ms", "a ramp of 0.5 s with its next command", ""},
    {ForceEnd::kHot, Ask::kNothing, "a motor is hot", "the force grows as it cools", ""},
    {ForceEnd::kCalibration, Ask::kNothing, "a calibration while force was on", "a ramp of 0.5 s to the force", ""},
    {ForceEnd::kPause, Ask::kGoOn, "the world was paused", "least tension", "let it go on (Go on in the panel, pause false)"},
    {ForceEnd::kOtherWorld, Ask::kNothing, "another scene, a reload, a restored state, a grabbed body, another runner of the device",
     "a ramp of soft_start to the force", ""},
    {ForceEnd::kSilentHand, Ask::kLetIn, "silent was set, as between the conditions of a study", "least tension",
     "set silent to false"},
};
static_assert(sizeof kWaysBack / sizeof *kWaysBack == static_cast<std::size_t>(ForceEnd::kEnds), "a row for every end");

/// The row of this end.
constexpr const WayBack& wayBackFrom(ForceEnd end) { return kWaysBack[static_cast<std::size_t>(end)]; }

}  // namespace haptic
